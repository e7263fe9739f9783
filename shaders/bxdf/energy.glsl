// Energy of rough surfaces: the albedo of one bounce, by the tables of shared/energy_tables.h, and the
// factors on single scattering that compensate for multiple scattering.
//
// E. Turquin 2019, "Practical multiple scattering compensation for microfacet models", with a refined factor:
// his 1 + F0 (1 - E) / E returns too much from rough and half-bright facets. Light that meets a second facet
// is reflected by the mean of Schlick's curve at the two, and goes on to a third, a fourth, ... with a
// probability q that was measured by random walks: of reflectance F there, (1 - q) / (1 - q F) of it is
// returned. White facets return all, and the factor is 1 / E as in the paper.
//
// The includer provides the tables, declared beforehand:
//     uvec4 EnergyEntryAt(uint index)  eight numbers, two to a word, the first in the lower bits
#ifndef RAYGRAPH_BXDF_ENERGY_GLSL
#define RAYGRAPH_BXDF_ENERGY_GLSL

#include "bxdf/fresnel.glsl"
#include "core/math.glsl"
#include "core/option.h"
#include "shared/energy_tables.h"
#include "shared/choice.h"

#ifdef __cplusplus
namespace raygraph::shading {
using glm::unpackUnorm2x16;
}  // namespace raygraph::shading
#endif

SHADING_BEGIN

OPTION(MultiscatterKind, MultiscatterKind, 4, Lut)

// Describes a position between two entries of an evenly spaced axis.
struct TableSpan {
    uint first;  // at most count - 2
    float t;     // 0: the first, 1: the one after it
};

// x in [0, 1] runs from the first of `count` entries to the last; others are clamped.
INLINE TableSpan SpanAt(float x, uint count) {
    float place = clamp(x, 0.0f, 1.0f) * float(count - 1u);
    TableSpan span;
    span.first = min(uint(place), count - 2u);
    span.t = place - float(span.first);
    return span;
}

// Returns the row of the reflection tables for a roughness.
INLINE TableSpan EnergyRow(float alpha) { return SpanAt(sqrt(alpha), kEnergyAlphaCount); }

// Holds values of an entry, or interpolated ones.
struct EnergyEntry {
    vec4 first;
    vec4 second;
};

INLINE EnergyEntry EnergyEntryOf(uint index) {
    uvec4 words = EnergyEntryAt(index);
    EnergyEntry entry;
    entry.first = vec4(unpackUnorm2x16(words.x), unpackUnorm2x16(words.y));
    entry.second = vec4(unpackUnorm2x16(words.z), unpackUnorm2x16(words.w));
    return entry;
}

INLINE EnergyEntry MixEntries(EnergyEntry a, EnergyEntry b, float t) {
    EnergyEntry entry;
    entry.first = mix(a.first, b.first, t);
    entry.second = mix(a.second, b.second, t);
    return entry;
}

// Holds the reflection of white facets and of facets with Schlick's curve, from one direction or averaged
// over all.
struct FacetEnergy {
    vec2 single;         // A, B of one bounce, F0 A + F90 B
    float second;        // share that meets a second facet, 1 - A - B
    float curveMean;     // there, of Schlick's curve s1 and s2 at the two: (s1 + s2) / 2, times the share
    float curveProduct;  // s1 s2, times the share
    float continuation;  // probability of a third facet, a fourth, ...
};

INLINE FacetEnergy FacetEnergyOf(EnergyEntry entry) {
    FacetEnergy energy;
    energy.single = vec2(entry.first.x, entry.first.y);
    energy.second = max(1.0f - entry.first.x - entry.first.y, 0.0f);
    energy.curveMean = entry.first.z;
    energy.curveProduct = entry.first.w;
    energy.continuation = entry.second.x;
    return energy;
}

INLINE FacetEnergy FacetEnergyAt(TableSpan row, float cosTheta) {
    TableSpan column = SpanAt(sqrt(max(cosTheta, 0.0f)), kEnergyCosCount);
    uint at = kEnergyReflectionOffset + row.first * kEnergyCosCount + column.first;
    uint next = at + kEnergyCosCount;
    EnergyEntry low = MixEntries(EnergyEntryOf(at), EnergyEntryOf(at + 1u), column.t);
    EnergyEntry high = MixEntries(EnergyEntryOf(next), EnergyEntryOf(next + 1u), column.t);
    return FacetEnergyOf(MixEntries(low, high, row.t));
}

INLINE EnergyEntry MeanEntry(TableSpan row) {
    uint at = kEnergyMeanOffset + row.first;
    return MixEntries(EnergyEntryOf(at), EnergyEntryOf(at + 1u), row.t);
}

INLINE FacetEnergy MeanFacetEnergy(TableSpan row) { return FacetEnergyOf(MeanEntry(row)); }

// Returns the mean of Schlick's curve from the third facet on.
INLINE float HigherOrderCurve(TableSpan row) { return MeanEntry(row).second.y; }

INLINE vec3 SingleAlbedo(FacetEnergy energy, vec3 f0, vec3 f90) {
    return f0 * energy.single.x + f90 * energy.single.y;
}

// Returns the albedo of all bounces from the second on.
INLINE vec3 MultipleAlbedo(FacetEnergy energy, vec3 f0, vec3 f90, float higherOrderCurve) {
    vec3 rise = f90 - f0;
    vec3 two = f0 * f0 * energy.second + f0 * rise * (2.0f * energy.curveMean) +
               rise * rise * energy.curveProduct;
    float q = energy.continuation;
    return two * (1.0f - q) / max(vec3(1.0f) - q * mix(f0, f90, higherOrderCurve), vec3(1e-4f));
}

// Holds the factors on reflection and transmission of a refracting surface, and the albedo of an additional
// diffuse reflection.
struct GlassScale {
    vec3 reflected;
    vec3 transmitted;
    vec3 diffuse;
};

INLINE float CornerWeight(TableSpan span, uint isNext) { return isNext != 0u ? span.t : 1.0f - span.t; }

// Holds the entries of the tables for a refracting surface and one direction.
struct GlassEnergy {
    vec2 passed;          // C, D of one bounce, (1 - F0) C + (1 - F90) D
    vec3 reflected;       // K, A, B of one bounce, K + F0 A + F90 B; K is total reflection
    float toReflected;    // what the walk has of either, over its share in one bounce
    float toTransmitted;
};

// eta is n(beyond) / n(here); `single` is that of FacetEnergy for the same direction.
INLINE GlassEnergy GlassEnergyAt(vec2 single, float alpha, float eta, float cosTheta) {
    TableSpan column = SpanAt(sqrt(max(cosTheta, 0.0f)), kEnergyGlassCosCount);
    TableSpan row = SpanAt(sqrt(alpha), kEnergyGlassAlphaCount);
    TableSpan slab = SpanAt(sqrt(2.0f * abs(eta - 1.0f) / (eta + 1.0f)), kEnergyGlassEtaCount);
    bool isLeaving = eta < 1.0f;
    uint offset = isLeaving ? kEnergyLeaveOffset : kEnergyEnterOffset;
    GlassEnergy energy;
    energy.passed = vec2(0.0f);
    energy.reflected = vec3(0.0f);
    float walk = 0.0f;  // share of light that it reflects
    for (uint i = 0u; i < 8u; ++i) {
        uint slabAt = (slab.first + (i >> 2u)) * kEnergyGlassAlphaCount;
        uint rowAt = (slabAt + row.first + ((i >> 1u) & 1u)) * kEnergyGlassCosCount;
        EnergyEntry corner = EnergyEntryOf(offset + rowAt + column.first + (i & 1u));
        float weight = CornerWeight(slab, i >> 2u) * CornerWeight(row, (i >> 1u) & 1u) *
                       CornerWeight(column, i & 1u);
        energy.passed += weight * vec2(corner.first.x, corner.first.y);
        walk += weight * corner.first.z;
        energy.reflected += weight * vec3(corner.second.x, corner.second.y, corner.second.z);
    }
    if (!isLeaving) energy.reflected = vec3(0.0f, single.x, single.y);

    // The shares of the walk for the two parts, for the Fresnel of eta, or that of the table's last
    float tableEta = clamp(eta, 1.0f / 3.0f, 3.0f);
    float own = DielectricF0(tableEta);
    float own90 = DielectricF90(tableEta);
    float reflected = energy.reflected.x + own * energy.reflected.y + own90 * energy.reflected.z;
    float passed = (1.0f - own) * energy.passed.x + (1.0f - own90) * energy.passed.y;
    float share = reflected / max(reflected + passed, 1e-4f);
    energy.toReflected = min(walk / max(share, 1e-3f), 1.0f);
    energy.toTransmitted = (1.0f - walk) / max(1.0f - share, 1e-3f);
    return energy;
}

// All three together sum to 1, for a Fresnel, and light is reflected and transmitted in the shares that the
// walk has. From the denser side it reflects far more than one bounce does (facets send back what others
// transmit): that lobe is broad, and approximated by the diffuse part.
INLINE GlassScale GlassScaleOf(GlassEnergy energy, vec3 f0, vec3 f90) {
    vec3 reflection = vec3(energy.reflected.x) + f0 * energy.reflected.y + f90 * energy.reflected.z;
    vec3 transmission = (vec3(1.0f) - f0) * energy.passed.x + (vec3(1.0f) - f90) * energy.passed.y;
    vec3 shifted = energy.toReflected * reflection + energy.toTransmitted * transmission;
    vec3 scale = vec3(1.0f) / max(max(reflection + transmission, shifted), vec3(0.02f));
    GlassScale result;
    result.reflected = energy.toReflected * scale;
    result.transmitted = energy.toTransmitted * scale;
    result.diffuse = vec3(1.0f) - scale * shifted;
    return result;
}

SHADING_END

#endif

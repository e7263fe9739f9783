// The single-scattering albedo of rough GGX surfaces, as tables: one flat array of entries, made by
// shaders/bxdf/bake_energy_tables.cpp, read by bxdf/energy.glsl. Smith masking is height-correlated; Fresnel
// is Schlick's curve, so that each albedo is linear in F0 and F90.
//
// An entry is a row of eight numbers in [0, 1], of 16 bits each, so that a shader has it by one load; those
// that a table does not use are 0.
//
// Axes, evenly spaced over [0, 1]: sqrt(cos theta); sqrt(alpha); sqrt(2 |eta - 1| / (eta + 1)), up to eta 3.
#ifndef RAYGRAPH_SHARED_ENERGY_TABLES_H
#define RAYGRAPH_SHARED_ENERGY_TABLES_H

#ifdef __cplusplus
#include <cstdint>
#define RAYGRAPH_CONSTANT inline constexpr
namespace raygraph {
using uint = uint32_t;
#else
#define RAYGRAPH_CONSTANT const
#endif

RAYGRAPH_CONSTANT uint kEnergyEntrySize = 8u;

// Reflection, [alpha][cos]: A and B of the albedo F0 A + F90 B of one bounce. Then of light that meets a
// second facet, with s1 and s2 Schlick's curve at the two: the means of (s1 + s2) / 2 and of s1 s2, times the
// share of such light; and the chance that it meets a third, a fourth, ...
RAYGRAPH_CONSTANT uint kEnergyCosCount = 32u;
RAYGRAPH_CONSTANT uint kEnergyAlphaCount = 32u;
RAYGRAPH_CONSTANT uint kEnergyReflectionOffset = 0u;

// [alpha]: the means of those five over the hemisphere, weighted by the cosine (the last also by the light
// that meets a second facet); and that of Schlick's curve from the third facet on.
RAYGRAPH_CONSTANT uint kEnergyMeanOffset = kEnergyReflectionOffset + kEnergyCosCount * kEnergyAlphaCount;

// Glass, [eta][alpha][cos], from the thinner side (eta > 1 lies beyond) and from the denser one. C and D of
// the transmission (1 - F0) C + (1 - F90) D of one bounce, masked as reflection is; the share of all light
// that the walk reflects, for the F0 and F90 of eta (bxdf/fresnel.glsl). From the denser side also, fifth to
// seventh, what one bounce reflects, K + F0 A + F90 B, as K, A and B.
RAYGRAPH_CONSTANT uint kEnergyGlassCosCount = 13u;
RAYGRAPH_CONSTANT uint kEnergyGlassAlphaCount = 13u;
RAYGRAPH_CONSTANT uint kEnergyGlassEtaCount = 9u;
RAYGRAPH_CONSTANT uint kEnergyGlassEntries =
    kEnergyGlassCosCount * kEnergyGlassAlphaCount * kEnergyGlassEtaCount;
RAYGRAPH_CONSTANT uint kEnergyEnterOffset = kEnergyMeanOffset + kEnergyAlphaCount;
RAYGRAPH_CONSTANT uint kEnergyLeaveOffset = kEnergyEnterOffset + kEnergyGlassEntries;

// White sheen, [alpha][cos]: its albedo, and the factor that caps f towards that direction (bxdf/sheen.glsl).
// [alpha]: the mean of the albedo over the hemisphere, weighted by the cosine.
// Fibers are at least this far from upright.
RAYGRAPH_CONSTANT float kMinSheenAlpha = 0.001f;
RAYGRAPH_CONSTANT uint kEnergySheenOffset = kEnergyLeaveOffset + kEnergyGlassEntries;
RAYGRAPH_CONSTANT uint kEnergySheenMeanOffset = kEnergySheenOffset + kEnergyCosCount * kEnergyAlphaCount;

RAYGRAPH_CONSTANT uint kEnergyEntryCount = kEnergySheenMeanOffset + kEnergyAlphaCount;

#undef RAYGRAPH_CONSTANT
#ifdef __cplusplus
}  // namespace raygraph
#endif

#endif

// Stretched highlights (KHR_materials_anisotropy): facets are rougher along one direction of the surface than
// across it. That direction is the x axis of the local frame, and alpha a vec2.
//
// Their energy depends on two alphas, the angle and the azimuth: no table of bxdf/energy.glsl has it. What
// one bounce returns towards wo is the mean over the facets that wo sees, of which a few are drawn here,
// evenly spread and moved by the walk's seed. So the factors that compensate for later bounces are estimates:
// the albedo is right on average over seeds, to the square of an estimate's error (tests: Anisotropy.*). For
// the direction of the light, where a layer over a diffuse base needs it once more, the tables serve: a
// stretched surface masks light like a round one of alpha sqrt((x^2 + y^2) / 2), met where alpha times the
// tangent is the same, and Fresnel's curve has the mean that it has on a round surface of the alpha in the
// direction of the light.
#ifndef RAYGRAPH_BXDF_ANISOTROPY_GLSL
#define RAYGRAPH_BXDF_ANISOTROPY_GLSL

#include "bxdf/energy.glsl"
#include "bxdf/multiscatter_walk.glsl"
#include "core/frame.glsl"
#include "core/rng.glsl"
#include "core/trace_options.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

// Returns alpha along the direction of the stretch, and across it.
INLINE vec2 AlphaOf(SurfaceMaterial material) {
    float across = Sqr(material.roughness);
    if (!HasTraceFeature(kTraceAnisotropy)) return vec2(across);
    return vec2(mix(across, 1.0f, Sqr(material.anisotropy)), across);
}

// Returns the frame in which a surface is shaded.
INLINE Frame FrameOf(SurfaceInteraction surface) {
    if (!HasTraceFeature(kTraceAnisotropy)) return FrameFromZ(surface.shadingNormal);
    return FrameFromZX(surface.shadingNormal, surface.stretch);
}

INLINE bool HasAnisotropicAlpha(vec2 alpha) {
    return HasTraceFeature(kTraceAnisotropy) && alpha.x != alpha.y;
}

// Returns one alpha for code that handles only round highlights.
INLINE float IsotropicAlpha(vec2 alpha) {
    if (!HasTraceFeature(kTraceAnisotropy)) return sqrt(alpha.x * alpha.y);
    return sqrt(0.5f * (Sqr(alpha.x) + Sqr(alpha.y)));
}

// ---------------------------------------------------------------------------------- by drawing a few facets

CONST uint kStretchFacets = 16u;
CONST uint kStretchGlassFacets = 32u;

// Holds two lattices of two dimensions each, moved by random numbers: for the first facet that light meets,
// and for the second.
struct FacetLattice {
    vec2 first;
    vec2 second;
};

INLINE FacetLattice StartLattice(uint seed) {
    WalkRng rng = StartWalkRng(seed ^ 0x7feb352du);
    FacetLattice lattice;
    lattice.first = WalkGet2D(rng);
    lattice.second = WalkGet2D(rng);
    return lattice;
}

INLINE vec2 FirstPoint(FacetLattice lattice, uint i, uint count) {
    return vec2((float(i) + lattice.first.x) / float(count),
                fract(float(i) * 0.61803399f + lattice.first.y));
}

INLINE vec2 SecondPoint(FacetLattice lattice, uint i) {
    return vec2(fract(float(i) * 0.75487767f + lattice.second.x),
                fract(float(i) * 0.56984029f + lattice.second.y));
}

// Returns the share of light that leaves along wi without meeting a second facet, of what a facet sends
// there.
INLINE float ConditionalShadowing(vec2 alpha, vec3 wo, vec3 wi) {
    float facets = ProjectedMicrofacetArea(alpha, wo);
    return facets / (facets + WalkLambda(alpha, vec3(wi.x, wi.y, abs(wi.z))) * wo.z);
}

// Estimates FacetEnergy towards wo but for what only a walk knows: the probability of a third facet.
INLINE FacetEnergy EstimateFacets(vec2 alpha, vec3 wo, uint seed) {
    FacetLattice lattice = StartLattice(seed);
    FacetEnergy energy;
    energy.single = vec2(0.0f);
    energy.second = 0.0f;
    energy.curveMean = 0.0f;
    energy.curveProduct = 0.0f;
    energy.continuation = 0.0f;
    if (!HasTraceFeature(kTraceAnisotropy)) return energy;
    float share = 1.0f / float(kStretchFacets);
    DONT_UNROLL
    for (uint i = 0u; i < kStretchFacets; ++i) {
        vec3 wm = SampleVisibleFacet(alpha, wo, FirstPoint(lattice, i, kStretchFacets));
        float cosI = dot(wo, wm);
        vec3 wi = 2.0f * cosI * wm - wo;
        float curve = SchlickWeight(cosI);
        float leaving = wi.z > 0.0f ? share * ConditionalShadowing(alpha, wo, wi) : 0.0f;
        energy.single += leaving * vec2(1.0f - curve, curve);
        float second = share - leaving;
        float next = SchlickWeight(-dot(wi, SampleVisibleFacet(alpha, -wi, SecondPoint(lattice, i))));
        energy.second += second;
        energy.curveMean += second * 0.5f * (curve + next);
        energy.curveProduct += second * curve * next;
    }
    return energy;
}

// Estimates GlassEnergy towards wo. Light that meets more facets is divided as in `table`.
INLINE GlassEnergy EstimateGlass(vec2 alpha, float eta, vec3 wo, uint seed, GlassEnergy table) {
    if (!HasTraceFeature(kTraceAnisotropy)) return table;
    FacetLattice lattice = StartLattice(seed);
    GlassEnergy energy;
    energy.passed = vec2(0.0f);
    energy.reflected = vec3(0.0f);
    // An estimate may miss what little is transmitted
    energy.toReflected = table.toReflected;
    energy.toTransmitted = min(table.toTransmitted, 1.5f);
    DONT_UNROLL
    for (uint i = 0u; i < kStretchGlassFacets; ++i) {
        vec3 wm = SampleVisibleFacet(alpha, wo, FirstPoint(lattice, i, kStretchGlassFacets));
        float cosI = dot(wo, wm);
        float cosT = RefractedCosine(cosI, eta);  // negative: total reflection
        float curve = SchlickWeight(eta < 1.0f ? max(cosT, 0.0f) : cosI);
        vec3 reflected = 2.0f * cosI * wm - wo;
        vec3 refracted = (cosI / eta - cosT) * wm - wo / eta;
        if (reflected.z > 0.0f) {
            vec3 kind = cosT < 0.0f ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 1.0f - curve, curve);
            energy.reflected += ConditionalShadowing(alpha, wo, reflected) * kind;
        }
        if (cosT >= 0.0f && refracted.z < 0.0f)
            energy.passed += ConditionalShadowing(alpha, wo, refracted) * vec2(1.0f - curve, curve);
    }
    energy.passed /= float(kStretchGlassFacets);
    energy.reflected /= float(kStretchGlassFacets);
    return energy;
}

// ------------------------------------------------------------------------------------------- by the tables

// Returns the alpha in the direction of w, times the sine of its angle; and that alpha, from above the round
// one.
INLINE float AlphaSine(vec2 alpha, vec3 w) { return sqrt(Sqr(alpha.x * w.x) + Sqr(alpha.y * w.y)); }
INLINE float ProjectedAlpha(vec2 alpha, vec3 w) {
    return sqrt(Sqr(IsotropicAlpha(alpha) * w.z) + Sqr(AlphaSine(alpha, w)));
}

// Returns the cosine at which a round surface of that alpha is masked as the stretched one is from w.
INLINE float IsotropicCosine(vec2 alpha, float isotropicAlpha, vec3 w) {
    return w.z / max(sqrt(Sqr(w.z) + Sqr(AlphaSine(alpha, w) / isotropicAlpha)), 1e-20f);
}

// Returns FacetEnergyAt for these alphas. `row` is that of IsotropicAlpha.
INLINE FacetEnergy FacetEnergyFrom(vec2 alpha, TableSpan row, vec3 w) {
    if (!HasAnisotropicAlpha(alpha)) return FacetEnergyAt(row, w.z);
    FacetEnergy energy = FacetEnergyAt(row, IsotropicCosine(alpha, IsotropicAlpha(alpha), w));
    FacetEnergy seen = FacetEnergyAt(EnergyRow(ProjectedAlpha(alpha, w)), w.z);
    float total = energy.single.x + energy.single.y;
    float curve = seen.single.y / max(seen.single.x + seen.single.y, 1e-4f);
    float second = energy.second / max(seen.second, 1e-3f);
    energy.single = total * vec2(1.0f - curve, curve);
    energy.curveMean = min(seen.curveMean * second, energy.second);
    energy.curveProduct = min(seen.curveProduct * second, energy.second);
    return energy;
}

// Returns the energy of the facets towards the viewer.
INLINE FacetEnergy ViewEnergy(vec2 alpha, TableSpan row, vec3 wo, uint seed) {
    if (!HasAnisotropicAlpha(alpha)) return FacetEnergyAt(row, wo.z);
    FacetEnergy energy = EstimateFacets(alpha, wo, seed);
    energy.continuation = FacetEnergyAt(row, IsotropicCosine(alpha, IsotropicAlpha(alpha), wo)).continuation;
    return energy;
}

// Returns HigherOrderCurve for light that left towards wo. Between the walls of a groove light keeps its
// angle to the groove, and Fresnel's curve its value.
INLINE float ViewHigherOrderCurve(vec2 alpha, TableSpan row, FacetEnergy energy) {
    if (!HasAnisotropicAlpha(alpha)) return HigherOrderCurve(row);
    float groove = 1.0f - min(alpha.x, alpha.y) / max(alpha.x, alpha.y);
    return mix(HigherOrderCurve(row), energy.curveMean / max(energy.second, 1e-4f), groove);
}

// Returns GlassEnergyAt for these alphas.
INLINE GlassEnergy ViewGlassEnergy(vec2 alpha, vec2 single, float eta, vec3 wo, uint seed) {
    if (!HasAnisotropicAlpha(alpha)) return GlassEnergyAt(single, IsotropicAlpha(alpha), eta, wo.z);
    return EstimateGlass(alpha, eta, wo, seed, GlassEnergyAt(single, ProjectedAlpha(alpha, wo), eta, wo.z));
}

SHADING_END

#endif

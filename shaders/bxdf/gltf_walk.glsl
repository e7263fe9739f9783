// Multiple scattering between the facets of a glTF material by random walks (bxdf/multiscatter_walk.glsl), in
// place of the lobes of the facets. f is an unbiased estimate that depends on `seed`.
#ifndef RAYGRAPH_BXDF_GLTF_WALK_GLSL
#define RAYGRAPH_BXDF_GLTF_WALK_GLSL

#include "bxdf/gltf_lobes.glsl"
#include "bxdf/multiscatter_walk.glsl"

SHADING_BEGIN

// One of the surfaces in which the walk may take place, and the factors on what it reflects and transmits.
struct WalkChoice {
    WalkSurface surface;
    vec3 reflect;
    vec3 pass;
};

INLINE float FacetChance(GltfBSDF g) { return g.metalChance + g.layerChance + g.glassChance; }

// With the probabilities of Sample_f, for which the factors compensate.
INLINE WalkChoice ChooseWalk(GltfBSDF g, float uc) {
    float chance = uc * FacetChance(g);
    WalkChoice choice;
    choice.surface.alpha = g.view.facets.alpha;
    choice.surface.kind = kWalkAbsorbs;
    choice.surface.eta = 1.0f;
    choice.surface.fresnel = BlackFresnel();
    choice.reflect = vec3(0.0f);
    choice.pass = vec3(0.0f);
    if (HasTraceFeature(kTraceGlass) && g.glassChance > 0.0f && chance >= g.metalChance + g.layerChance) {
        choice.surface.kind = g.view.isThin ? kWalkPassesThin : kWalkRefracts;
        choice.surface.eta = g.glass.eta;
        choice.surface.fresnel = g.glass.fresnel;
        choice.reflect = g.glass.reflect / g.glassChance;
        choice.pass = g.glass.pass / (g.view.isThin ? g.glassChance : g.glassChance * Sqr(g.glass.eta));
    } else if (HasTraceFeature(kTraceOpaque) && g.layerChance > 0.0f && chance >= g.metalChance) {
        choice.surface.eta = g.layer.eta;
        choice.surface.fresnel = g.layer.fresnel;
        choice.reflect = g.layer.scale / g.layerChance;
    } else if (HasTraceFeature(kTraceMetals) && g.metalChance > 0.0f) {
        choice.surface.fresnel.f0 = g.metal.fresnel.f0;
        choice.surface.fresnel.f90 = g.metal.fresnel.f90;
        choice.surface.fresnel.exactF90 = g.metal.fresnel.f90;
        choice.surface.fresnel.isMetal = true;
        choice.reflect = g.metal.scale / g.metalChance;
    }
    return choice;
}

// The walk's estimate of f, without diffuse.
INLINE vec3 EstimateWalk(GltfBSDF g, vec3 wi) {
    WalkRng rng = StartWalkRng(g.seed ^ 0x5bd1e995u);
    WalkChoice choice = ChooseWalk(g, WalkGet1D(rng));
    vec3 weight = (wi.z < 0.0f ? choice.pass : choice.reflect) * FacetChance(g);
    return EstimateWalk(choice.surface, g.view.wo, wi, rng.state) * weight / abs(wi.z);
}

// The density that approximates the walk's: single scattering, and a cosine lobe for the rest.
INLINE float WalkPDF(GltfBSDF g, vec3 wi, float singlePDF) {
    float glassHalf = 0.5f * g.glassChance;
    float chance = wi.z > 0.0f ? g.metalChance + g.layerChance + glassHalf : glassHalf;
    float rescattered = max(g.view.energy.second, 0.01f);  // share of light that meets a second facet, about
    return mix(singlePDF, chance * CosineHemispherePDF(abs(wi.z)), rescattered);
}

// A direction by the walk, with uc of those of the facets. f |wi.z| / pdf is an estimate, pdf is 1.
INLINE BSDFSample SampleWalk(GltfBSDF g, float uc, vec2 u) {
    WalkChoice choice = ChooseWalk(g, uc);
    WalkSample walked = SampleWalk(choice.surface, g.view.wo, g.seed ^ floatBitsToUint(u.x + 1.0f) * 31u);
    if (!(MaxComponent(walked.weight) > 0.0f) || walked.wi.z == 0.0f) return NoSample();
    BSDFSample result = SampledDirection(walked.wi, 1.0f, kBxDFReflection | kBxDFGlossy);
    result.f = walked.weight * choice.reflect;
    if (walked.wi.z < 0.0f) {
        result.flags = kBxDFTransmission | kBxDFGlossy;
        result.eta = g.view.isThin ? 1.0f : g.glass.mediumEta;
        result.f = walked.weight * choice.pass;
    }
    result.f /= abs(walked.wi.z);
    result.pdf = 1.0f;
    return result;
}

SHADING_END

#endif

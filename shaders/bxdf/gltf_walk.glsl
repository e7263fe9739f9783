// Multiple scattering between the facets of a glTF material by random walks (bxdf/multiscatter_walk.glsl), in
// place of the lobes that say so (IsWalked). f is an unbiased estimate that depends on `seed`. Lobes are
// counted from 1 in the order of the list.
#ifndef RAYGRAPH_BXDF_GLTF_WALK_GLSL
#define RAYGRAPH_BXDF_GLTF_WALK_GLSL

#include "bxdf/gltf_lobes.glsl"

SHADING_BEGIN

// The probability that Sample_f chooses one of the walked lobes; 0 where no walk takes place.
INLINE float WalkProbability(GltfBSDF g) {
    float sum = 0.0f;
    if (!UsesMicrosurfaceWalk() || g.view.isSmooth) return sum;
#define RAYGRAPH_ADD_CHANCE_(Lobe, name, feature) \
    if (HasTraceFeature(feature) && IsWalked(g.name)) sum += g.name##Chance;
    GLTF_LOBES(RAYGRAPH_ADD_CHANCE_)
#undef RAYGRAPH_ADD_CHANCE_
    return sum;
}

// Chooses one of the walked lobes, with those probabilities.
INLINE uint ChooseWalkedLobe(GltfBSDF g, float uc, float walkProbability) {
    float above = (1.0f - uc) * walkProbability;
    uint lobe = 0u;
    uint chosen = 0u;
#define RAYGRAPH_CHOOSE_WALK_(Lobe, name, feature)                                                  \
    ++lobe;                                                                                         \
    if (HasTraceFeature(feature) && IsWalked(g.name) && g.name##Chance > 0.0f && above > 0.0f) {    \
        chosen = lobe;                                                                              \
        above -= g.name##Chance;                                                                    \
    }
    GLTF_LOBES(RAYGRAPH_CHOOSE_WALK_)
#undef RAYGRAPH_CHOOSE_WALK_
    return chosen;
}

// Returns the chosen lobe's walk, with factors that compensate for the probability of the choice.
INLINE MicrosurfaceWalk WalkOf(GltfBSDF g, uint chosen) {
    MicrosurfaceWalk walk = NoWalk(g.view);
    float chance = 1.0f;
    uint lobe = 0u;
#define RAYGRAPH_TAKE_WALK_(Lobe, name, feature)                                \
    ++lobe;                                                                     \
    if (HasTraceFeature(feature) && IsWalked(g.name) && chosen == lobe) {       \
        walk = WalkOf(g.name, g.view);                                          \
        chance = g.name##Chance;                                                \
    }
    GLTF_LOBES(RAYGRAPH_TAKE_WALK_)
#undef RAYGRAPH_TAKE_WALK_
    walk.reflect /= chance;
    walk.pass /= chance;
    return walk;
}

// The walks' estimate of f.
INLINE vec3 EstimateWalk(GltfBSDF g, FacetPair pair, float walkProbability) {
    WalkRng rng = StartWalkRng(g.seed ^ 0x5bd1e995u);
    uint chosen = ChooseWalkedLobe(g, WalkGet1D(rng), walkProbability);
    MicrosurfaceWalk walk = WalkOf(g, chosen);
    vec3 wi = pair.wi;
    if (HasRetroreflection(g.view, wi) && WalkGet1D(rng) < g.view.retroreflectedShare) wi = Mirrored(wi);
    vec3 weight = (pair.wi.z < 0.0f ? walk.pass : walk.reflect) * walkProbability;
    return EstimateWalk(walk.surface, g.view.wo, wi, rng.state) * weight / abs(wi.z);
}

// The density that approximates the walks': single scattering, and a cosine lobe for the rest; half of it on
// either side of lobes that transmit.
INLINE float WalkPDF(GltfBSDF g, vec3 wi, float singlePDF) {
    float chance = 0.0f;
#define RAYGRAPH_ADD_SIDE_(Lobe, name, feature)                                 \
    if (HasTraceFeature(feature) && IsWalked(g.name))                           \
        chance += g.name##Chance * (IsTransmissive(Flags(g.name, g.view)) ? 0.5f : wi.z > 0.0f ? 1.0f : 0.0f);
    GLTF_LOBES(RAYGRAPH_ADD_SIDE_)
#undef RAYGRAPH_ADD_SIDE_
    float rescattered = max(g.view.energy.second, 0.01f);  // share of light that meets a second facet, about
    return mix(singlePDF, chance * CosineHemispherePDF(abs(wi.z)), rescattered);
}

// A direction by the walk of a lobe, without what lies above it. f |wi.z| / pdf is an estimate, pdf is 1.
INLINE BSDFSample SampleWalk(GltfBSDF g, uint chosen, vec2 u) {
    MicrosurfaceWalk walk = WalkOf(g, chosen);
    WalkSample walked = SampleWalk(walk.surface, g.view.wo, g.seed ^ floatBitsToUint(u.x + 1.0f) * 31u);
    if (!(MaxComponent(walked.weight) > 0.0f) || walked.wi.z == 0.0f) return NoSample();
    BSDFSample result = SampledDirection(walked.wi, 1.0f, kBxDFReflection | kBxDFGlossy);
    result.f = walked.weight * walk.reflect;
    if (walked.wi.z < 0.0f) {
        result.flags = kBxDFTransmission | kBxDFGlossy;
        result.eta = walk.eta;
        result.f = walked.weight * walk.pass;
    }
    result.f /= abs(walked.wi.z);
    result.pdf = 1.0f;
    return result;
}

SHADING_END

#endif

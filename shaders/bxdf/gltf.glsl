// The BSDF of a glTF material at one point: the sum of the lobes of bxdf/gltf_lobes.glsl.
//     GltfBSDF Prepare(material, setting, wo)   the lobes as seen from wo
//     vec3 Evaluate(g, wi, isDelta, pdf, diffuse)
//         f, the density of wi in Sample_f, and the part of f that is of diffuse lobes. `isDelta`: wi was
//         sampled from a delta (IsDelta); these are the factors of the deltas in its direction
//     BSDFSample SampleDirection(g, uc, u, isEvaluated)
//         Sample_f; without f and pdf unless isEvaluated is set
//     f, PDF, Sample_f  with the contracts of bxdf/bxdf.glsl
//
// Multiple scattering between the facets, by kMultiscatter:
// - `off` loses them.
// - `lut` scales each lobe by a factor that depends on wo (bxdf/energy.glsl), so that f(wo, wi) and f(wi, wo)
//   differ by the ratio of two such factors: for white metals and thin walls less than 1.4 at alpha 0.2, 1.8
//   at 0.5 and 3.3 at 1, for dielectrics over diffuse less than 1.1. Factors of anisotropic surfaces are
//   estimates that depend on `seed` (bxdf/anisotropy.glsl), their ratio less than 2.6.
// - `walk` simulates a random walk. f is then an unbiased estimate that depends on `seed`, and PDF, made of
//   single scattering and a diffuse share, only approximates the density of Sample_f. It suffices for the
//   weights of multiple importance sampling, which only need to sum to one; f |wi.z| / pdf of the sample is
//   an unbiased estimate, but is not f(wo, wi) |wi.z| / PDF(wo, wi).
//
// wo.z > 0 always: the integrator turns the frame to the viewer's side and gives eta for it. Transmission
// scales radiance by 1 / eta^2, and the sample returns eta.
#ifndef RAYGRAPH_BXDF_GLTF_GLSL
#define RAYGRAPH_BXDF_GLTF_GLSL

#include "bxdf/gltf_lobes.glsl"
#include "core/record.glsl"

SHADING_BEGIN

// --- Multiple scattering by random walks between the facets (bxdf/multiscatter_walk.glsl) ---
// They take the place of the lobes that say so (IsWalked). f is an unbiased estimate that depends on `seed`.
// Lobes are counted from 1 in the order of the list.

// Returns the probability that Sample_f chooses one of the walked lobes; 0 where no walk takes place.
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

// Returns the walks' estimate of f.
INLINE vec3 EstimateWalk(GltfBSDF g, FacetPair pair, float walkProbability) {
    WalkRng rng = StartWalkRng(g.seed ^ 0x5bd1e995u);
    uint chosen = ChooseWalkedLobe(g, WalkGet1D(rng), walkProbability);
    MicrosurfaceWalk walk = WalkOf(g, chosen);
    vec3 wi = pair.wi;
    if (HasRetroreflection(g.view, wi) && WalkGet1D(rng) < g.view.retroreflectedShare) wi = Mirrored(wi);
    vec3 weight = (pair.wi.z < 0.0f ? walk.pass : walk.reflect) * walkProbability;
    return EstimateWalk(walk.surface, g.view.wo, wi, rng.state) * weight / abs(wi.z);
}

// Returns the density that approximates the walks': single scattering, and a cosine lobe for the rest; half
// of it on either side of lobes that transmit.
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

// Returns a direction by the walk of a lobe, without what lies above it. f |wi.z| / pdf is an estimate, pdf
// is 1.
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

// Holds the sum over all lobes.
struct LobeSum {
    vec3 value;  // without lobes that a walk takes the place of
    float pdf;
    vec3 diffuse;     // the part of value that is of diffuse lobes
    float walkedPDF;  // densities of single scattering of walked lobes
};

// The part of a lobe that goes back, in SumLobes.
#define RAYGRAPH_TURN_BACK_(name)                                                     \
    if (HasTraceFeature(kTraceRetroreflection) && isRetroreflected && IsWalked(g.name)) { \
        float backPDF = 0.0f;                                                         \
        vec3 backValue = Evaluate(g.name, g.view, back, backPDF);                     \
        value = mix(value, backValue, g.view.retroreflectedShare);                              \
        lobePDF = mix(lobePDF, backPDF, g.view.retroreflectedShare);                            \
    }

INLINE LobeSum SumLobes(GltfBSDF g, FacetPair pair, bool hasWalk) {
    LobeSum sum;
    sum.value = vec3(0.0f);
    sum.pdf = 0.0f;
    sum.diffuse = vec3(0.0f);
    sum.walkedPDF = 0.0f;
    float passed = 1.0f;  // to diffuse lobes, by the lobes so far
    FacetPair back = pair;
    bool isRetroreflected = HasRetroreflection(g.view, pair.wi);
    if (isRetroreflected) back = RetroreflectedPair(g.view, pair.wi, pair.isDelta);
#define RAYGRAPH_ADD_LOBE_(Lobe, name, feature)                                   \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f) {                      \
        float lobePDF = 0.0f;                                                     \
        vec3 value = Evaluate(g.name, g.view, pair, lobePDF);                     \
        RAYGRAPH_TURN_BACK_(name)                                                 \
        if (IsDiffuse(g.name)) value *= passed;                                   \
        lobePDF *= g.name##Chance;                                                \
        if (hasWalk && IsWalked(g.name)) {                                        \
            sum.walkedPDF += lobePDF;                                             \
        } else {                                                                  \
            sum.value += value;                                                   \
            sum.pdf += lobePDF;                                                   \
        }                                                                         \
        if (IsDiffuse(g.name)) sum.diffuse += value;                              \
        passed *= NormalizedTransmittance(g.name, g.view, pair);                                 \
    }
    GLTF_LOBES(RAYGRAPH_ADD_LOBE_)
#undef RAYGRAPH_ADD_LOBE_
#undef RAYGRAPH_TURN_BACK_
    return sum;
}

INLINE vec3 Evaluate(GltfBSDF g, vec3 wi, bool isDelta, OUT(float) pdf, OUT(vec3) diffuse) {
    pdf = 0.0f;
    diffuse = vec3(0.0f);
    if (wi.z == 0.0f || g.flags == kBxDFNone) return vec3(0.0f);
    if (wi.z < 0.0f && !IsTransmissive(g.flags)) return vec3(0.0f);
    float walkProbability = WalkProbability(g);
    bool hasWalk = walkProbability > 0.0f && !isDelta;
    FacetPair pair = PairOf(g.view, wi, isDelta);
    LobeSum sum = SumLobes(g, pair, hasWalk);
    if (hasWalk) {
        sum.value += EstimateWalk(g, pair, walkProbability);
        sum.pdf += WalkPDF(g, wi, sum.walkedPDF);
    }
    pdf = sum.pdf;
    diffuse = sum.diffuse;
    return sum.value;
}

// Returns a direction of the walk of lobe number `walked`, or of a lobe beside those (0), with PDF, and f
// such that f |wi.z| / pdf is an estimate.
INLINE BSDFSample EvaluateWalked(GltfBSDF g, BSDFSample s, uint walked) {
    FacetPair pair = PairOf(g.view, s.wi, false);
    LobeSum sum = SumLobes(g, pair, true);
    if (walked == 0u) {
        s.f = sum.value;
        s.pdf = sum.pdf;
    }
    float pdf = WalkPDF(g, s.wi, sum.walkedPDF) + sum.pdf;
    s.f *= pdf / s.pdf;
    s.pdf = pdf;
    return s;
}

// Returns whether the sample is of a delta. No scene without smooth materials has any.
INLINE bool IsDelta(BSDFSample s) { return HasTraceFeature(kTraceSmooth) && IsSpecular(s.flags); }

// Sample_f without f and pdf, which come from Evaluate, unless isEvaluated is set.
INLINE BSDFSample SampleDirection(GltfBSDF g, float uc, vec2 u, OUT(bool) isEvaluated) {
    isEvaluated = true;
    BSDFSample result = NoSample();
    if (g.flags == kBxDFNone) return result;

    // Choose a lobe: from the bottom up, uc goes through their probabilities
    bool hasWalk = WalkProbability(g) > 0.0f;
    float above = 1.0f - uc;  // what remains of the probabilities, from the top
    float within = 0.0f;
    uint lobe = 0u;
    uint chosen = 0u;
    bool isCosine = false;
    bool isWalked = false;
    bool isBack = false;
#define RAYGRAPH_CHOOSE_LOBE_(Lobe, name, feature)                               \
    ++lobe;                                                                      \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f && above > 0.0f) {     \
        chosen = lobe;                                                           \
        within = max(1.0f - above / g.name##Chance, 0.0f);                       \
        isBack = IsWalked(g.name) && ChooseRetroreflection(g.view, within);                 \
        isCosine = SamplesCosine(g.name, within);                                  \
        isWalked = hasWalk && IsWalked(g.name);                                  \
        RECORD(lobe, kPathLobe##Lobe);                                           \
        RECORD(lobeProbability, g.name##Chance);                                 \
        above -= g.name##Chance;                                                 \
    }
    GLTF_LOBES(RAYGRAPH_CHOOSE_LOBE_)
#undef RAYGRAPH_CHOOSE_LOBE_

    // The direction is one of that lobe, or of its walk
    if (isWalked) {
        result = SampleWalk(g, chosen, u);
        if (isBack && result.wi.z > 0.0f) result.wi = Mirrored(result.wi);
        return result.flags == kBxDFNone ? result : EvaluateWalked(g, result, chosen);
    }
    vec3 drawn = SampleCosineOrNormal(g.view, isCosine, u);
    lobe = 0u;
#define RAYGRAPH_SAMPLE_LOBE_(Lobe, name, feature)                  \
    ++lobe;                                                         \
    if (HasTraceFeature(feature) && chosen == lobe)                 \
        result = SampleDirection(g.name, g.view, drawn, within, u);
    GLTF_LOBES(RAYGRAPH_SAMPLE_LOBE_)
#undef RAYGRAPH_SAMPLE_LOBE_
    if (result.flags == kBxDFNone) return result;
    if (isBack && result.wi.z > 0.0f) result.wi = Mirrored(result.wi);
    if (hasWalk && !IsDelta(result)) return EvaluateWalked(g, result, 0u);
    isEvaluated = false;
    return result;
}

INLINE vec3 Evaluate(GltfBSDF g, vec3 wi, OUT(float) pdf) {
    vec3 diffuse = vec3(0.0f);
    return Evaluate(g, wi, false, pdf, diffuse);
}

INLINE vec3 f(GltfBSDF g, vec3 wi) {
    float pdf = 0.0f;
    return Evaluate(g, wi, pdf);
}

INLINE float PDF(GltfBSDF g, vec3 wi) {
    float pdf = 0.0f;
    Evaluate(g, wi, pdf);
    return pdf;
}

INLINE BSDFSample Sample_f(GltfBSDF g, float uc, vec2 u) {
    bool isEvaluated = false;
    BSDFSample result = SampleDirection(g, uc, u, isEvaluated);
    vec3 diffuse = vec3(0.0f);
    if (!isEvaluated) result.f = Evaluate(g, result.wi, IsDelta(result), result.pdf, diffuse);
    return result;
}

// --- Straight passage, at smooth thin walls and between media of one index ---

// Returns the probability that Sample_f passes straight through, and the share of light that does.
INLINE float PassThroughProbability(GltfBSDF g) {
    float chance = 0.0f;
#define RAYGRAPH_ADD_STRAIGHT_(Lobe, name, feature)             \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f)      \
        chance += g.name##Chance * PassThroughProbability(g.name, g.view);
    GLTF_LOBES(RAYGRAPH_ADD_STRAIGHT_)
#undef RAYGRAPH_ADD_STRAIGHT_
    return chance;
}

INLINE vec3 PassThroughWeight(GltfBSDF g) {
    vec3 share = vec3(0.0f);
#define RAYGRAPH_ADD_STRAIGHT_(Lobe, name, feature)             \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f)      \
        share += PassThroughWeight(g.name, g.view);
    GLTF_LOBES(RAYGRAPH_ADD_STRAIGHT_)
#undef RAYGRAPH_ADD_STRAIGHT_
    return share;
}

// Returns the surface without that; `chance` is PassThroughProbability, and below 1.
INLINE GltfBSDF WithoutPassThrough(GltfBSDF g, float chance) {
    float scale = 1.0f / (1.0f - chance);
    uint flags = kBxDFNone;
#define RAYGRAPH_REMOVE_STRAIGHT_(Lobe, name, feature)                                  \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f) {                            \
        float straight = PassThroughProbability(g.name, g.view);                                \
        flags |= Flags(g.name, g.view) & (straight > 0.0f ? ~kBxDFTransmission : ~0u);  \
        g.name##Chance = max(g.name##Chance - g.name##Chance * straight, 0.0f) * scale; \
        g.name = WithoutPassThrough(g.name);                                               \
    }
    GLTF_LOBES(RAYGRAPH_REMOVE_STRAIGHT_)
#undef RAYGRAPH_REMOVE_STRAIGHT_
    g.flags = flags;
    return g;
}

// Returns the share of light from wo that passes straight through, without the rest of the BSDF.
INLINE vec3 PassThroughWeight(SurfaceMaterial material, SurfaceSetting setting, vec3 wo) {
    vec3 sum = vec3(0.0f);
    if (!(wo.z > 0.0f)) return sum;
    FacetView view = ViewOf(material, setting, wo);
    material.baseColor = clamp(material.baseColor, vec3(0.0f), vec3(1.0f));
    float share = 1.0f;
#define RAYGRAPH_ADD_STRAIGHT_(Lobe, name, feature)         \
    if (HasTraceFeature(feature)) {                         \
        Lobe name;                                          \
        InitLobe(name, material, setting, view, share);    \
        sum += PassThroughWeight(name, view);                   \
    }
    GLTF_LOBES(RAYGRAPH_ADD_STRAIGHT_)
#undef RAYGRAPH_ADD_STRAIGHT_
    return sum;
}

SHADING_END

#endif

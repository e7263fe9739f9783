// The BSDF of a glTF material at one point: the sum of the lobes of bxdf/gltf_lobes.glsl.
//     GltfBSDF Prepare(material, setting, wo)   the lobes as seen from wo
//     vec3 Evaluate(g, wi, pdf, diffuse)
//         f, the density of wi in Sample_f, and the part of f that is of diffuse lobes
//     BSDFSample SampleDirection(g, uc, u, isEvaluated)
//         Sample_f; without f and pdf unless isEvaluated is set
//     f, PDF, Sample_f  with the contracts of bxdf/bxdf.glsl
//
// Multiple scattering between the facets, by kMultiscatter:
// - `off` loses them.
// - `lut` scales each lobe by a factor that depends on wo (bxdf/energy.glsl), so that f(wo, wi) and f(wi, wo)
//   differ by the ratio of two such factors: for white metals and thin walls less than 1.4 at alpha 0.2, 1.8
//   at 0.5 and 3.3 at 1, for dielectrics over diffuse less than 1.1.
// - `walk` simulates a random walk (bxdf/gltf_walk.glsl). f is then an unbiased estimate that depends
//   on `seed`, and PDF, made of single scattering and a diffuse share, only approximates the density of
//   Sample_f. It suffices for the weights of multiple importance sampling, which only need to sum to one; f
//   |wi.z| / pdf of the sample is an unbiased estimate, but is not f(wo, wi) |wi.z| / PDF(wo, wi).
//
// wo.z > 0 always: the integrator turns the frame to the viewer's side and gives eta for it. Transmission
// scales radiance by 1 / eta^2, and the sample returns eta.
#ifndef RAYGRAPH_BXDF_GLTF_GLSL
#define RAYGRAPH_BXDF_GLTF_GLSL

#include "bxdf/gltf_walk.glsl"

SHADING_BEGIN

// The sum over all lobes, diffuse ones apart.
struct LobeSum {
    vec3 facets;
    float facetPDF;
    vec3 diffuse;
    float diffusePDF;
};

INLINE LobeSum SumLobes(GltfBSDF g, FacetPair pair) {
    LobeSum sum;
    sum.facets = vec3(0.0f);
    sum.facetPDF = 0.0f;
    sum.diffuse = vec3(0.0f);
    sum.diffusePDF = 0.0f;
    float passed = 1.0f;  // by the lobes so far
#define RAYGRAPH_ADD_LOBE_(Lobe, name, feature)                                   \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f) {                      \
        float lobePDF = 0.0f;                                                     \
        vec3 value = passed * Evaluate(g.name, g.view, pair, lobePDF);            \
        lobePDF *= g.name##Chance;                                                \
        if (IsDiffuse(g.name)) {                                                  \
            sum.diffuse += value;                                                 \
            sum.diffusePDF += lobePDF;                                            \
        } else {                                                                  \
            sum.facets += value;                                                  \
            sum.facetPDF += lobePDF;                                              \
        }                                                                         \
        passed *= PassedTo(g.name, g.view, pair);                                 \
    }
    GLTF_LOBES(RAYGRAPH_ADD_LOBE_)
#undef RAYGRAPH_ADD_LOBE_
    return sum;
}

INLINE vec3 Evaluate(GltfBSDF g, vec3 wi, OUT(float) pdf, OUT(vec3) diffuse) {
    pdf = 0.0f;
    diffuse = vec3(0.0f);
    if (wi.z == 0.0f || g.flags == kBxDFNone) return vec3(0.0f);
    if (wi.z < 0.0f && !IsTransmissive(g.flags)) return vec3(0.0f);
    LobeSum sum = SumLobes(g, PairOf(g.view, wi, false));
    if (IsWalked() && !g.view.isSmooth && FacetChance(g) > 0.0f) {
        sum.facets = EstimateWalk(g, wi);
        sum.facetPDF = WalkPDF(g, wi, sum.facetPDF);
    }
    pdf = sum.facetPDF + sum.diffusePDF;
    diffuse = sum.diffuse;
    return sum.facets + sum.diffuse;
}

// A direction of the walk, or of a diffuse lobe beside it, with PDF, and f such that f |wi.z| / pdf is an
// estimate.
INLINE BSDFSample EvaluateWalked(GltfBSDF g, BSDFSample s) {
    LobeSum sum = SumLobes(g, PairOf(g.view, s.wi, false));
    if ((s.flags & kBxDFDiffuse) != 0u) {
        s.f = sum.diffuse;
        s.pdf = sum.diffusePDF;
    }
    float pdf = WalkPDF(g, s.wi, sum.facetPDF) + sum.diffusePDF;
    s.f *= pdf / s.pdf;
    s.pdf = pdf;
    return s;
}

// f and pdf of a sample of kBxDFSpecular: the factors of the deltas in its direction.
INLINE BSDFSample EvaluateDelta(GltfBSDF g, BSDFSample s) {
    LobeSum sum = SumLobes(g, PairOf(g.view, s.wi, true));
    s.f = sum.facets;
    s.pdf = sum.facetPDF;
    return s;
}

// Sample_f without f and pdf, which come from Evaluate, unless isEvaluated is set: deltas are evaluated here,
// where a mirror and a pane are cheap and Evaluate is not.
INLINE BSDFSample SampleDirection(GltfBSDF g, float uc, vec2 u, OUT(bool) isEvaluated) {
    isEvaluated = true;
    BSDFSample result = NoSample();
    if (g.flags == kBxDFNone) return result;

    // Choose a lobe: from the bottom up, uc goes through their probabilities
    float above = 1.0f - uc;  // of what remains of them, from the top
    float within = 0.0f;
    uint lobe = 0u;
    uint chosen = 0u;
    bool isDiffuse = false;
    bool isCosine = false;
#define RAYGRAPH_CHOOSE_LOBE_(Lobe, name, feature)                               \
    lobe++;                                                                      \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f && above > 0.0f) {     \
        chosen = lobe;                                                           \
        within = max(1.0f - above / g.name##Chance, 0.0f);                       \
        isDiffuse = IsDiffuse(g.name);                                           \
        isCosine = DrawsCosine(g.name, within);                                  \
        above -= g.name##Chance;                                                 \
    }
    GLTF_LOBES(RAYGRAPH_CHOOSE_LOBE_)
#undef RAYGRAPH_CHOOSE_LOBE_

    // A direction of that lobe, or of the walk among the facets
    bool isWalked = IsWalked() && !g.view.isSmooth && FacetChance(g) > 0.0f;
    if (isWalked && !isDiffuse) {
        float facetChance = FacetChance(g);
        result = SampleWalk(g, clamp((uc + facetChance - 1.0f) / facetChance, 0.0f, 1.0f), u);
        return result.flags == kBxDFNone ? result : EvaluateWalked(g, result);
    }
    vec3 drawn = DrawFor(g.view, isCosine, u);
    lobe = 0u;
#define RAYGRAPH_SAMPLE_LOBE_(Lobe, name, feature)                  \
    lobe++;                                                         \
    if (HasTraceFeature(feature) && chosen == lobe)                 \
        result = SampleDirection(g.name, g.view, drawn, within, u);
    GLTF_LOBES(RAYGRAPH_SAMPLE_LOBE_)
#undef RAYGRAPH_SAMPLE_LOBE_
    if (result.flags == kBxDFNone) return result;
    if (IsSpecular(result.flags)) return EvaluateDelta(g, result);
    if (isWalked) return EvaluateWalked(g, result);
    isEvaluated = false;
    return result;
}

INLINE vec3 Evaluate(GltfBSDF g, vec3 wi, OUT(float) pdf) {
    vec3 diffuse = vec3(0.0f);
    return Evaluate(g, wi, pdf, diffuse);
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
    if (!isEvaluated) result.f = Evaluate(g, result.wi, result.pdf);
    return result;
}

// ----------------------------------------------------------------------------------------- smooth thin walls

// The probability that Sample_f passes straight through a smooth thin wall, and the share of light that does.
INLINE float StraightChance(GltfBSDF g) {
    if (!IsTransmissive(g.flags)) return 0.0f;
    return g.glassChance * StraightChance(g.glass, g.view);
}

INLINE vec3 StraightShare(GltfBSDF g) { return StraightShare(g.glass, g.view.wo.z); }

// A smooth thin wall without its transmission; `chance` is StraightChance, and below 1.
INLINE GltfBSDF WithoutStraight(GltfBSDF g, float chance) {
    g.glass.pass = vec3(0.0f);
    g.glassChance = max(g.glassChance - chance, 0.0f);
    g.flags &= ~kBxDFTransmission;
    float scale = 1.0f / (1.0f - chance);
#define RAYGRAPH_SCALE_LOBE_(Lobe, name, feature) g.name##Chance *= scale;
    GLTF_LOBES(RAYGRAPH_SCALE_LOBE_)
#undef RAYGRAPH_SCALE_LOBE_
    return g;
}

SHADING_END

#endif

// Lambert's lobe: equal radiance in every direction of the side that wo is on. Alone, and as the base of a
// material: what the lobes above it let pass is colored by the material.
#ifndef RAYGRAPH_BXDF_DIFFUSE_GLSL
#define RAYGRAPH_BXDF_DIFFUSE_GLSL

#include "bxdf/lobe.glsl"
#include "core/warp.glsl"

SHADING_BEGIN

struct DiffuseBxDF {
    vec3 albedo;  // the share of light that is reflected, in [0, 1]
};

INLINE uint Flags(DiffuseBxDF lobe) {
    return MaxComponent(lobe.albedo) > 0.0f ? kBxDFReflection | kBxDFDiffuse : kBxDFNone;
}

INLINE vec3 f(DiffuseBxDF lobe, vec3 wo, vec3 wi) {
    return SameHemisphere(wo, wi) ? lobe.albedo * kInvPi : vec3(0.0f);
}

INLINE float PDF(DiffuseBxDF lobe, vec3 wo, vec3 wi) {
    return SameHemisphere(wo, wi) && Flags(lobe) != kBxDFNone ? CosineHemispherePDF(abs(wi.z)) : 0.0f;
}

INLINE BSDFSample Sample_f(DiffuseBxDF lobe, vec3 wo, float /* uc: one part */, vec2 u) {
    BSDFSample result = NoSample();
    if (wo.z == 0.0f || Flags(lobe) == kBxDFNone) return result;
    vec3 wi = SampleCosineHemisphere(u);
    result.pdf = CosineHemispherePDF(wi.z);
    if (wo.z < 0.0f) wi.z = -wi.z;
    result.f = lobe.albedo * kInvPi;
    result.wi = wi;
    result.flags = kBxDFReflection | kBxDFDiffuse;
    return result;
}

// -------------------------------------------------------------------------------------- as a material's base

INLINE void InitLobe(OUT(DiffuseBxDF) lobe, SurfaceMaterial material, SurfaceSetting, FacetView,
                      INOUT(float) share) {
    lobe.albedo = share * material.baseColor;
}

INLINE bool IsDiffuse(DiffuseBxDF) { return true; }

INLINE uint Flags(DiffuseBxDF, FacetView) { return kBxDFReflection | kBxDFDiffuse; }

INLINE vec3 Evaluate(DiffuseBxDF lobe, FacetView, FacetPair pair, OUT(float) pdf) {
    pdf = 0.0f;
    if (pair.isDelta || !(pair.wi.z > 0.0f)) return vec3(0.0f);
    pdf = CosineHemispherePDF(pair.wi.z);
    return lobe.albedo * kInvPi;
}

INLINE bool SamplesCosine(DiffuseBxDF, float) { return true; }

INLINE BSDFSample SampleDirection(DiffuseBxDF, FacetView, vec3 drawn, float, vec2) {
    return CosineDirection(drawn, kBxDFDiffuse);
}

INLINE LobeMean Reflected(DiffuseBxDF lobe, FacetView) {
    LobeMean mean = NoMean();
    mean.albedo = lobe.albedo;
    mean.isDiffuse = true;
    return mean;
}

INLINE float Weight(DiffuseBxDF lobe, FacetView) { return Average(lobe.albedo); }

LOBE_IS_OPAQUE(DiffuseBxDF)
LOBE_IS_NOT_A_LAYER(DiffuseBxDF)
LOBE_HAS_NO_WALK(DiffuseBxDF)
LOBE_BXDF_INTERFACE(DiffuseBxDF)

SHADING_END

#endif

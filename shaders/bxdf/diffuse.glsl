// Lambert's lobe: equal radiance in every direction of the side that wo is on.
#ifndef RAYGRAPH_BXDF_DIFFUSE_GLSL
#define RAYGRAPH_BXDF_DIFFUSE_GLSL

#include "bxdf/bxdf.glsl"
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

SHADING_END

#endif

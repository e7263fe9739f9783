// A metal: microfacets that reflect by Fresnel's share, once (Walter et al. 2007, eq. 20), or a mirror where
// the surface is effectively smooth. Single scattering: light that a facet sends to another facet is lost.
#ifndef RAYGRAPH_BXDF_CONDUCTOR_GLSL
#define RAYGRAPH_BXDF_CONDUCTOR_GLSL

#include "bxdf/microfacet.glsl"

SHADING_BEGIN

struct ConductorBxDF {
    MicrofacetDistribution distribution;
    ConductorFresnel fresnel;
};

INLINE uint Flags(ConductorBxDF lobe) {
    return kBxDFReflection | (IsEffectivelySmooth(lobe.distribution) ? kBxDFSpecular : kBxDFGlossy);
}

INLINE vec3 f(ConductorBxDF lobe, vec3 wo, vec3 wi) {
    if (!SameHemisphere(wo, wi) || IsEffectivelySmooth(lobe.distribution)) return vec3(0.0f);
    vec3 wm = ReflectionNormal(wo, wi);
    vec3 reflected = ConductorReflectance(lobe.fresnel, abs(dot(wo, wm)));
    return reflected * ReflectionLobe(lobe.distribution, wo, wi, wm);
}

INLINE float PDF(ConductorBxDF lobe, vec3 wo, vec3 wi) {
    if (!SameHemisphere(wo, wi) || IsEffectivelySmooth(lobe.distribution)) return 0.0f;
    return ReflectionPDF(lobe.distribution, wo, ReflectionNormal(wo, wi));
}

INLINE BSDFSample Sample_f(ConductorBxDF lobe, vec3 wo, float /* uc: one part */, vec2 u) {
    BSDFSample result = NoSample();
    if (wo.z == 0.0f) return result;
    result.flags = Flags(lobe);
    if (IsEffectivelySmooth(lobe.distribution)) {
        result.wi = vec3(-wo.x, -wo.y, wo.z);
        result.f = ConductorReflectance(lobe.fresnel, abs(wo.z)) / abs(wo.z);
        result.pdf = 1.0f;
        return result;
    }
    float side = wo.z < 0.0f ? -1.0f : 1.0f;
    vec3 wm = side * Sample_wm(lobe.distribution, side * wo, u);
    // A direction into the surface meets another facet; that light is lost.
    vec3 wi = Reflect(wo, wm);
    if (dot(wo, wm) <= 0.0f || !SameHemisphere(wo, wi)) return result;
    result.wi = wi;
    vec3 reflected = ConductorReflectance(lobe.fresnel, dot(wo, wm));
    result.f = reflected * ReflectionLobe(lobe.distribution, wo, wi, wm);
    result.pdf = ReflectionPDF(lobe.distribution, wo, wm);
    return result;
}

SHADING_END

#endif

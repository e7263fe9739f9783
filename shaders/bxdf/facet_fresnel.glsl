// The reflectance of one facet of a material: the curves of bxdf/fresnel.glsl between the reflectances that
// materials give.
#ifndef RAYGRAPH_BXDF_FACET_FRESNEL_GLSL
#define RAYGRAPH_BXDF_FACET_FRESNEL_GLSL

#include "bxdf/fresnel.glsl"

SHADING_BEGIN

struct FacetFresnel {
    vec3 f0;        // at normal incidence
    vec3 f90;       // where Schlick's curve ends; the energy tables use this one whatever the model
    vec3 exactF90;  // where the exact curve of a dielectric ends
    bool isMetal;
};

INLINE FacetFresnel BlackFresnel() {
    FacetFresnel fresnel;
    fresnel.f0 = vec3(0.0f);
    fresnel.f90 = vec3(0.0f);
    fresnel.exactF90 = vec3(0.0f);
    fresnel.isMetal = true;
    return fresnel;
}

// Of light that makes cosI > 0 with the facet of a dielectric; `cosOutside` is the cosine on its thinner
// side. Exact models have the shape of the exact curve, moved to f0 and exactF90 at its ends; f0 is then that
// of eta times a tint.
INLINE vec3 DielectricCurve(FacetFresnel fresnel, float cosOutside, float cosI, float eta) {
    if (ActiveFresnel() == kFresnelSchlick) return FresnelSchlick(cosOutside, fresnel.f0, fresnel.f90);
    float f0 = DielectricF0(eta);
    float exact = FresnelDielectric(cosI, eta);
    return mix(fresnel.f0, fresnel.exactF90, clamp((exact - f0) / max(1.0f - f0, 1e-6f), 0.0f, 1.0f));
}

// As FacetReflectance, of a dielectric seen from its thinner side, eta >= 1: nothing is reflected totally.
INLINE vec3 OutsideReflectance(FacetFresnel fresnel, float cosI, float eta) {
    return DielectricCurve(fresnel, cosI, cosI, eta);
}

// Of light that makes cosI > 0 with the facet; eta is n(far side) / n(this side) as seen from here, and not
// read for metals. Total reflection is 1 whatever f90.
INLINE vec3 FacetReflectance(FacetFresnel fresnel, float cosI, float eta) {
    if (fresnel.isMetal) {
        if (ActiveFresnel() == kFresnelSchlick) return FresnelSchlick(cosI, fresnel.f0, fresnel.f90);
        return ConductorReflectance(ConductorFromColor(fresnel.f0, fresnel.f90), cosI);
    }
    float c = min(cosI, 1.0f);
    if (eta < 1.0f) {
        c = RefractedCosine(c, eta);
        if (c < 0.0f) return vec3(1.0f);
    }
    return DielectricCurve(fresnel, c, cosI, eta);
}

// The share of light that a layer of that reflectance passes to its base: for every channel that of
// the channel which is reflected most. Otherwise a colored layer would give the base the inverse
// color (KHR_materials_specular).
INLINE vec3 PassedShare(vec3 reflectance) { return vec3(1.0f - MaxComponent(reflectance)); }

SHADING_END

#endif

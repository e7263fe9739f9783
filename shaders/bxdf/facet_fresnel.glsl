// What one facet reflects, by the parameters that materials have: the reflectance at normal incidence and
// that at grazing, with Fresnel's curve between them.
#ifndef RAYGRAPH_BXDF_FACET_FRESNEL_GLSL
#define RAYGRAPH_BXDF_FACET_FRESNEL_GLSL

#include "core/math.glsl"

SHADING_BEGIN

struct FacetFresnel {
    vec3 f0;
    vec3 f90;
    float eta;  // n below the surface / n above it; 1 where no light passes
};

// The share that a facet reflects of light that makes cosI > 0 with it; eta is n(far side) / n(this side) as
// seen from here. Schlick's curve (Schlick 1994) takes the cosine on the thinner side, so that both sides
// agree; beyond the critical angle everything is reflected.
INLINE vec3 FacetReflectance(FacetFresnel fresnel, float cosI, float eta) {
    float c = cosI;
    if (eta < 1.0f) {
        float cos2T = 1.0f - (1.0f - cosI * cosI) / (eta * eta);
        if (cos2T <= 0.0f) return vec3(1.0f);
        c = sqrt(cos2T);
    }
    float x = clamp(1.0f - c, 0.0f, 1.0f);
    float x2 = x * x;
    return mix(fresnel.f0, fresnel.f90, x2 * x2 * x);
}

SHADING_END

#endif

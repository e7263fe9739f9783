// The BSDF of a surface, by the model in use.
#ifndef RAYGRAPH_BXDF_BSDF_GLSL
#define RAYGRAPH_BXDF_BSDF_GLSL

#include "bxdf/diffuse.glsl"
#include "scene/ray.glsl"
#include "shared/trace_options.h"
#include "shared/microfacet_models.h"
#include "shared/multiscatter_kinds.h"

SHADING_BEGIN

struct SurfaceBSDF {
    DiffuseBxDF lambert;
};

INLINE SurfaceBSDF BSDFOf(SurfaceMaterial material, float eta, bool isThin, float leastAlpha) {
    SurfaceBSDF bsdf;
    bsdf.lambert.albedo = material.baseColor;
    return bsdf;
}

INLINE uint Flags(SurfaceBSDF bsdf) { return Flags(bsdf.lambert); }
INLINE vec3 f(SurfaceBSDF bsdf, vec3 wo, vec3 wi) { return f(bsdf.lambert, wo, wi); }
INLINE float PDF(SurfaceBSDF bsdf, vec3 wo, vec3 wi) { return PDF(bsdf.lambert, wo, wi); }
INLINE BSDFSample Sample_f(SurfaceBSDF bsdf, vec3 wo, float uc, vec2 u) {
    return Sample_f(bsdf.lambert, wo, uc, u);
}

SHADING_END

#endif

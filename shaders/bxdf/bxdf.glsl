// Conventions of every lobe, with the terms of pbrt-v4.
//
// Directions are of unit length, in the local frame of the surface: the shading normal is +z. wo points to
// the viewer, wi to the light; both point away from the surface, and the cosine of w is w.z.
//
// A lobe is a struct with these overloads:
//     vec3 f(lobe, wo, wi)                  the value of the BSDF in 1/sr, without the cosine
//     BSDFSample Sample_f(lobe, wo, uc, u)  a direction: uc chooses among parts, u within one
//     float PDF(lobe, wo, wi)               density of wi in Sample_f, per solid angle
//     uint Flags(lobe)                      what kind of scattering it has, kBxDF* below
// Random numbers are arguments; no lobe draws any. The lobes of a material take what they share in place of
// wo, and say more of themselves: bxdf/lobe.glsl.
//
// Sample_f fails by pdf = 0 (nothing scatters, or the direction has no density): test it before dividing.
// Else f and pdf of the sample are f(lobe, wo, wi) and PDF(lobe, wo, wi) of its wi, to rounding, and the
// estimator of the light scattered to wo is f * L(wi) * abs(wi.z) / pdf.
//
// Specular parts (a delta in direction) have f and PDF of 0 for every pair of directions. Only Sample_f sees
// them, with f and pdf sharing the factor that the delta leaves and kBxDFSpecular among the sample's flags.
//
// wo below the surface (wo.z < 0) is legal: lobes are symmetric about z = 0 unless they say otherwise.
//
// f is for radiance carried from the light to the viewer. A lobe that scales by the square of the relative
// index of refraction says so and returns that index as `eta`.
#ifndef RAYGRAPH_BXDF_BXDF_GLSL
#define RAYGRAPH_BXDF_BXDF_GLSL

#include "core/math.glsl"
#include "shared/bxdf_flags.h"

SHADING_BEGIN

INLINE bool IsReflective(uint flags) { return (flags & kBxDFReflection) != 0u; }
INLINE bool IsTransmissive(uint flags) { return (flags & kBxDFTransmission) != 0u; }
INLINE bool IsSpecular(uint flags) { return (flags & kBxDFSpecular) != 0u; }
// Returns whether there is more than a delta, so that light sampling can evaluate it.
INLINE bool IsNonSpecular(uint flags) { return (flags & (kBxDFDiffuse | kBxDFGlossy)) != 0u; }

struct BSDFSample {
    vec3 f;      // 1/sr, without the cosine
    float pdf;   // per solid angle; 0: there is no sample, and the other fields are undefined
    vec3 wi;     // local frame, unit length
    float eta;   // relative index of refraction along wi: 1 but for transmission
    uint flags;  // flags of the sampled part, a subset of Flags(lobe)
};

INLINE BSDFSample NoSample() {
    BSDFSample result;
    result.f = vec3(0.0f);
    result.pdf = 0.0f;
    result.wi = vec3(0.0f, 0.0f, 1.0f);
    result.eta = 1.0f;
    result.flags = kBxDFNone;
    return result;
}

INLINE bool SameHemisphere(vec3 a, vec3 b) { return a.z * b.z > 0.0f; }

SHADING_END

#endif

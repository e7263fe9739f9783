// Fresnel reflectance: the share of light that an interface reflects.
//
// Cosines are of the angle between the direction and the normal (of the microfacet, for rough surfaces).
// Rounding may leave them a little outside [-1, 1]. eta is an index of refraction relative to the side that
// the light comes from, eta - i k the complex one of a conductor.
//
// The model is chosen when the pipeline is created (shared/choice.h). Facets of dielectrics,
// which materials tint, are in bxdf/facet_fresnel.glsl.
//     model        ConductorReflectance                    FacetReflectance of a dielectric
//     Schlick      Schlick's, from f0 to f90               Schlick's, of the cosine on the thinner side
//                                                          (from DielectricF0 to DielectricF90); total
//                                                          reflection exact
//     Dielectric   exact, with the index that has this f0  exact
//     Conductor    exact, eta and k                        exact
//     Lazanyi      Schlick's and a term that mends it      exact
#ifndef RAYGRAPH_BXDF_FRESNEL_GLSL
#define RAYGRAPH_BXDF_FRESNEL_GLSL

#include "core/math.glsl"
#include "core/option.h"
#include "shared/choice.h"

SHADING_BEGIN

OPTION(FresnelModel, Fresnel, 3, Schlick)

// Returns (1 - cosTheta)^5, the weight of f90 in Schlick's curve. Schlick 1994, "An Inexpensive BRDF Model
// for Physically-based Rendering", eq. 15.
INLINE float SchlickWeight(float cosTheta) {
    float m = clamp(1.0f - cosTheta, 0.0f, 1.0f);
    return Sqr(Sqr(m)) * m;
}

INLINE float FresnelSchlick(float cosTheta, float f0, float f90) {
    return f0 + (f90 - f0) * SchlickWeight(cosTheta);
}

INLINE vec3 FresnelSchlick(float cosTheta, vec3 f0, vec3 f90) {
    return f0 + (f90 - f0) * SchlickWeight(cosTheta);
}

// Returns the reflectance of a dielectric at normal incidence; the same from both sides.
INLINE float DielectricF0(float eta) { return Sqr((eta - 1.0f) / (eta + 1.0f)); }

// Returns the value of Schlick's curve for a dielectric at grazing angles, the same from both sides. It is 1
// for relative indices of 1.346 and more (common glass and plastic in air: F90 of glTF). Between media of
// nearer indices the true reflectance vanishes, except at angles ever closer to grazing; a curve that ends at
// 1 would keep (1 - cos)^5. There F90 is such that the mean over the hemisphere, weighted by the cosine, F0 +
// (F90 - F0) / 21, is that of Fresnel's equations within 0.5 %: a fit to 21 (mean - F0) + F0, with r =
// sqrt(F0). Its limit for r -> 0 is exact, 14 r: the mean is then 8 r times the integral over t > 0 of t
// (sqrt(t^2 + 1) - t)^4, which is 1/12.
INLINE float DielectricF90(float eta) {
    float r = abs((eta - 1.0f) / (eta + 1.0f));  // the quotient of DielectricF0
    return min(14.0f * r / (1.0f + 5.9f * r + 0.457f * sqrt(r)), 1.0f);
}

// Returns the cosine on the far side of an interface, in [0, 1] for cosTheta >= 0, by Snell's law; -1 for
// total reflection.
INLINE float RefractedCosine(float cosTheta, float eta) {
    float sin2 = max(1.0f - cosTheta * cosTheta, 0.0f) / (eta * eta);
    return sin2 < 1.0f ? sqrt(1.0f - sin2) : -1.0f;
}

// Evaluates Fresnel's equations for unpolarized light and two dielectrics. eta is the index below the surface
// over that above it; cosTheta < 0 is light from below. 1 for total reflection.
INLINE float FresnelDielectric(float cosTheta, float eta) {
    float etaAhead = cosTheta < 0.0f ? 1.0f / eta : eta;
    float cosI = min(abs(cosTheta), 1.0f);
    float cosT = RefractedCosine(cosI, etaAhead);
    if (cosT < 0.0f) return 1.0f;
    float parallel = (etaAhead * cosI - cosT) / (etaAhead * cosI + cosT);
    float perpendicular = (cosI - etaAhead * cosT) / (cosI + etaAhead * cosT);
    return 0.5f * (Sqr(parallel) + Sqr(perpendicular));
}

// Evaluates Fresnel's equations for unpolarized light from vacuum onto a conductor, channel by channel, in
// real arithmetic: Born and Wolf, Principles of Optics, 14.2; as in Lagarde 2013, "Memo on Fresnel
// equations".
INLINE vec3 FresnelConductor(float cosTheta, vec3 eta, vec3 k) {
    float c = clamp(abs(cosTheta), 0.0f, 1.0f);
    float c2 = c * c;
    float s2 = 1.0f - c2;
    vec3 t0 = eta * eta - k * k - vec3(s2);
    vec3 a2b2 = sqrt(t0 * t0 + 4.0f * (eta * eta) * (k * k));
    vec3 t1 = a2b2 + vec3(c2);
    vec3 t2 = (2.0f * c) * sqrt(max(0.5f * (a2b2 + t0), vec3(0.0f)));
    vec3 perpendicular = (t1 - t2) / max(t1 + t2, vec3(1e-20f));
    vec3 t3 = c2 * a2b2 + vec3(s2 * s2);
    vec3 t4 = s2 * t2;
    vec3 parallel = perpendicular * (t3 - t4) / max(t3 + t4, vec3(1e-20f));
    return max(0.5f * (perpendicular + parallel), vec3(0.0f));
}

INLINE vec3 ConductorF0(vec3 eta, vec3 k) {
    vec3 k2 = k * k;
    vec3 below = eta - vec3(1.0f);
    vec3 above = eta + vec3(1.0f);
    return (below * below + k2) / (above * above + k2);
}

// The cosine where LazanyiWeight is largest, 1 / 7: 82 degrees.
CONST float kLazanyiPeak = 0.142857142857143f;

// Returns the shape of the excess of Schlick's curve for metals, cos (1 - cos)^6: Lazányi and Szirmay-Kalos
// 2005, "Fresnel Term Approximations for Metals". Their exponent is fitted to each metal; here it is 6 and
// only the amplitude is fitted (Hoffman 2019, "Fresnel Equations Considered Harmful").
INLINE float LazanyiWeight(float cosTheta) {
    float c = clamp(cosTheta, 0.0f, 1.0f);
    float m = 1.0f - c;
    return c * Sqr(Sqr(m)) * Sqr(m);
}

// Holds the reflectance parameters of a conductor. Create them by one of the two functions below; a field
// that the active model does not read costs nothing on the device.
struct ConductorFresnel {
    vec3 f0;       // at normal incidence
    vec3 f90;      // at grazing incidence; read by Schlick and Lazanyi
    vec3 eta;      // read by Dielectric (with k = 0) and Conductor
    vec3 k;
    vec3 lazanyi;  // amplitude of LazanyiWeight
};

// Returns the values for measured indices; f90 is 1.
INLINE ConductorFresnel ConductorFromIndices(vec3 eta, vec3 k) {
    ConductorFresnel fresnel;
    fresnel.f0 = ConductorF0(eta, k);
    fresnel.f90 = vec3(1.0f);
    fresnel.eta = eta;
    fresnel.k = k;
    fresnel.lazanyi = vec3(0.0f);
    if (ActiveFresnel() == kFresnelLazanyi) {
        vec3 schlick = FresnelSchlick(kLazanyiPeak, fresnel.f0, fresnel.f90);
        vec3 excess = schlick - FresnelConductor(kLazanyiPeak, eta, k);
        fresnel.lazanyi = excess / LazanyiWeight(kLazanyiPeak);
    }
    if (ActiveFresnel() == kFresnelDielectric) {
        vec3 root = min(sqrt(fresnel.f0), vec3(0.9999f));
        fresnel.eta = (vec3(1.0f) + root) / (vec3(1.0f) - root);
    }
    return fresnel;
}

// Returns the values for a color, which does not determine the two indices: Gulbrandsen 2014, "Artist
// Friendly Metallic Fresnel", with the edge tint 1 - 0.3 (1 - r). It keeps the index finite up to r = 1, and
// gives eta = 1.2, k = 6.9 for the reflectance of aluminium (1.0 and 6.7 in tables).
INLINE ConductorFresnel ConductorFromColor(vec3 f0, vec3 f90) {
    vec3 r = clamp(f0, vec3(0.0f), vec3(0.9999f));
    vec3 absorbed = vec3(1.0f) - r;
    vec3 root = vec3(1.0f) + sqrt(r);
    vec3 eta = (vec3(1.0f) - 0.3f * absorbed) * absorbed / (vec3(1.0f) + r) + 0.3f * root * root;
    vec3 above = eta + vec3(1.0f);
    vec3 below = eta - vec3(1.0f);
    vec3 k2 = (above * above * r - below * below) / absorbed;
    ConductorFresnel fresnel = ConductorFromIndices(eta, sqrt(max(k2, vec3(0.0f))));
    fresnel.f0 = f0;
    fresnel.f90 = f90;
    return fresnel;
}

INLINE vec3 ConductorReflectance(ConductorFresnel fresnel, float cosTheta) {
    if (ActiveFresnel() == kFresnelDielectric) return FresnelConductor(cosTheta, fresnel.eta, vec3(0.0f));
    if (ActiveFresnel() == kFresnelConductor) return FresnelConductor(cosTheta, fresnel.eta, fresnel.k);
    vec3 schlick = FresnelSchlick(cosTheta, fresnel.f0, fresnel.f90);
    if (ActiveFresnel() != kFresnelLazanyi) return schlick;
    return clamp(schlick - LazanyiWeight(cosTheta) * fresnel.lazanyi, vec3(0.0f), vec3(1.0f));
}

SHADING_END

#endif

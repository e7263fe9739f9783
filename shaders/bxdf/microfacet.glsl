// Microfacet distributions, masking and shadowing, and the sampling of normals.
//
// Directions w are in the local frame of the surface. Masking uses abs(w.z), so either side is valid; normals
// wm point up. Lobes use forms without division by a cosine and without tangents: grazing directions and
// tan = 0 are valid, and the caller must refuse only w.z = 0 itself.
//
//     ggx       Trowbridge and Reitz 1975; Walter et al. 2007, "Microfacet Models for Refraction through
//               Rough Surfaces", eq. 33. Draws visible normals.
//     beckmann  Walter eq. 25, masked by his rational fit. Draws by D cos.
//     phong     Walter eq. 30 with exponent 2 / alpha^2 - 2. He masks it as the Beckmann distribution of
//               this alpha, which is right for small alpha; at alpha = 1 it is the GGX distribution, and
//               Beckmann's masking would have it reflect 1.5 times what comes in. So its Lambda goes from one
//               to the other. Draws by D cos. Alpha is at most 1.
// Anisotropy stretches slopes along x and y (Heitz 2014, "Understanding the Masking-Shadowing Function in
// Microfacet-Based BRDFs"); for phong it is Ashikhmin and Shirley's 2000.
//
// Distribution and masking are chosen when the pipeline is created (shared/choice.h).
#ifndef RAYGRAPH_BXDF_MICROFACET_GLSL
#define RAYGRAPH_BXDF_MICROFACET_GLSL

#include "bxdf/bxdf.glsl"
#include "bxdf/fresnel.glsl"
#include "core/option.h"
#include "core/trace_options.glsl"
#include "core/warp.glsl"
#include "shared/choice.h"

SHADING_BEGIN

OPTION(MicrofacetModel, Distribution, 1, Ggx)
OPTION(MaskingModel, Masking, 2, Correlated)

struct MicrofacetDistribution {
    vec2 alpha;  // along x and y
};

// A surface is smooth if both alphas are; one that is not has neither below kSmoothAlpha.
INLINE MicrofacetDistribution MakeMicrofacetDistribution(vec2 alpha) {
    MicrofacetDistribution d;
    bool isSmooth = HasTraceFeature(kTraceSmooth) && max(alpha.x, alpha.y) < kSmoothAlpha;
    d.alpha = isSmooth ? vec2(0.0f, 0.0f) : max(alpha, vec2(kSmoothAlpha, kSmoothAlpha));
    return d;
}

INLINE bool IsEffectivelySmooth(MicrofacetDistribution d) {
    return HasTraceFeature(kTraceSmooth) && max(d.alpha.x, d.alpha.y) < kSmoothAlpha;
}

// Returns ln(1 - x) for 0 <= x < 1 without the cancellation near 0.
INLINE float LogOneMinus(float x) {
    if (x > 0.1f) return 0.693147180559945f * log2(1.0f - x);
    float t = x / (2.0f - x);
    float t2 = t * t;
    return -2.0f * t * (1.0f + t2 * (0.333333333f + t2 * 0.2f));
}

// Returns 1 - e^x for x <= 0 without the cancellation near 0.
INLINE float OneMinusExp(float x) {
    if (x < -0.1f) return 1.0f - exp2(1.44269504088896f * x);
    return -x * (1.0f + x * (0.5f + x * (0.166666667f + x * (0.0416666667f + x * 0.00833333333f))));
}

// Returns the density of normals: area of facets per solid angle and unit area of the surface. Its integral
// times the cosine is 1.
INLINE float D(MicrofacetDistribution d, vec3 wm) {
    float mx = wm.x / d.alpha.x;
    float my = wm.y / d.alpha.y;
    float slope2 = mx * mx + my * my;
    float cos2 = wm.z * wm.z;
    float peak = kInvPi / (d.alpha.x * d.alpha.y);
    if (ActiveDistribution() == kDistributionBeckmann) {
        // The exponential underflows to 0 long before the cosine does.
        return cos2 < 1e-8f ? 0.0f : peak * exp2(-1.44269504088896f * slope2 / cos2) / (cos2 * cos2);
    }
    if (ActiveDistribution() == kDistributionPhong) {
        float sin2 = wm.x * wm.x + wm.y * wm.y;
        if (sin2 < 1e-12f) return peak;
        float exponent = 2.0f * slope2 / sin2 - 2.0f;
        return sin2 < 1.0f ? peak * exp2(0.721347520444482f * exponent * LogOneMinus(sin2)) : 0.0f;
    }
    return peak / Sqr(slope2 + cos2);
}

// Returns Smith's Lambda times abs(w.z): finite for every w.
INLINE float LambdaCos(MicrofacetDistribution d, vec3 w) {
    float c = abs(w.z);
    float stretched2 = Sqr(d.alpha.x * w.x) + Sqr(d.alpha.y * w.y);
    // This is Walter eq. 34 in Heitz's form, 2 Lambda = sqrt(1 + alpha^2 tan^2) - 1.
    float ggx = 0.5f * (sqrt(c * c + stretched2) - c);
    if (ActiveDistribution() == kDistributionGgx) return ggx;
    // This is Walter eq. 27 with a = 1 / (alpha tan).
    float beckmann = 0.0f;
    float s = sqrt(stretched2);
    if (c < 1.6f * s) {
        float a = c / s;
        beckmann = s * max(1.0f + a * (-1.259f + a * 0.396f), 0.0f) / (3.535f + a * 2.181f);
    }
    if (ActiveDistribution() == kDistributionBeckmann) return beckmann;
    // At grazing angles this weight makes it exact (to 1 %): there LambdaCos is Gamma(N - 1/2) / (2 sqrt(pi)
    // Gamma(N)), N = 1 / alpha^2.
    float alpha2 = stretched2 / max(w.x * w.x + w.y * w.y, 1e-20f);
    float weight = min(alpha2 * (0.485f + 0.515f * alpha2 * sqrt(alpha2)), 1.0f);
    return mix(beckmann, ggx, weight);
}

INLINE float Lambda(MicrofacetDistribution d, vec3 w) { return LambdaCos(d, w) / max(abs(w.z), 1e-12f); }

// Returns the visible share of the facets that face w. 0 for w.z = 0.
INLINE float G1(MicrofacetDistribution d, vec3 w) {
    float c = abs(w.z);
    return c > 0.0f ? c / (c + LambdaCos(d, w)) : 0.0f;
}

// Returns ln Gamma(z) less (z - 1/2) ln z - z + ln(2 pi) / 2, by Stirling's series; 5e-6 at z = 2, less
// beyond.
INLINE float StirlingRest(float z) {
    float r = 1.0f / z;
    return r * (0.0833333333f - r * r * (0.00277777778f - r * r * 0.000793650794f));
}

// Returns Euler's beta function of 1 + a and 1 + b, for a, b >= 0; to 1e-5.
INLINE float BetaOnePlus(float a, float b) {
    // B(x, y) = B(x + 1, y + 1) (x + y) (x + y + 1) / (x y) shifts the arguments to where Stirling's series
    // is accurate.
    float x = 2.0f + a;
    float y = 2.0f + b;
    float sum = x + y;
    float exponent = x * log2(x / sum) + y * log2(y / sum) +
                     1.44269504088896f * (StirlingRest(x) + StirlingRest(y) - StirlingRest(sum));
    float beta = 2.50662827463100f * sqrt(sum / (x * y)) * exp2(exponent);
    return beta * (sum - 2.0f) * (sum - 1.0f) / ((x - 1.0f) * (y - 1.0f));
}

// The share of facets visible from both wo and wi, over the product of their cosines, among those that either
// sees from the proper side. They are not both at z = 0.
//
// Correlated: Heitz 2014 eq. 99 on one side of the surface. On either side a facet high up is seen from above
// and hidden from below, and the shares come to Euler's beta function: Heitz et al. 2016,
// "Multiple-Scattering Microfacet BSDFs with the Smith Model". Separable: Walter eq. 23. Shortcut: Kelemen
// and Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model", for reflection; it has no
// form for transmission, which stays separable.
INLINE float GOverCosines(MicrofacetDistribution d, vec3 wo, vec3 wi) {
    float co = abs(wo.z);
    float ci = abs(wi.z);
    bool isReflection = SameHemisphere(wo, wi);
    if (ActiveMasking() == kMaskingShortcut && isReflection) {
        // L.H is half the length of L + V.
        vec3 sum = wo + wi;
        return 4.0f / max(dot(sum, sum), 1e-12f);
    }
    float lo = LambdaCos(d, wo);
    float li = LambdaCos(d, wi);
    if (ActiveMasking() == kMaskingCorrelated && isReflection) return 1.0f / (co * ci + lo * ci + li * co);
    float separable = 1.0f / ((co + lo) * (ci + li));
    if (ActiveMasking() != kMaskingCorrelated) return separable;
    float a = lo / max(co, 1e-12f);
    float b = li / max(ci, 1e-12f);
    return min(BetaOnePlus(a, b) / max(co * ci, 1e-24f), separable);
}

// Returns the share of facets wm visible from both; 0 where either sees the back of the facet.
INLINE float G(MicrofacetDistribution d, vec3 wo, vec3 wi, vec3 wm) {
    if (dot(wo, wm) * wo.z <= 0.0f || dot(wi, wm) * wi.z <= 0.0f) return 0.0f;
    return GOverCosines(d, wo, wi) * abs(wo.z * wi.z);
}

// Returns a normal, wm.z >= 0, by the density that PDF gives. w.z > 0; w is the viewer's direction.
INLINE vec3 Sample_wm(MicrofacetDistribution d, vec3 w, vec2 u) {
    vec2 cs = CosSinTurn(u.y);
    if (ActiveDistribution() == kDistributionGgx) {
        // Samples the upper cap of the unit sphere that a stretched viewer sees, reflected: Dupuy and Benyoub
        // 2023, "Sampling Visible GGX Normals with Spherical Caps".
        vec3 v = normalize(vec3(d.alpha.x * w.x, d.alpha.y * w.y, max(w.z, 0.0f)));
        float z = (1.0f - u.x) * (1.0f + v.z) - v.z;
        float r = SafeSqrt(1.0f - z * z);
        vec3 h = vec3(r * cs.x + v.x, r * cs.y + v.y, max(z + v.z, 1e-8f));
        return normalize(vec3(d.alpha.x * h.x, d.alpha.y * h.y, h.z));
    }
    float x = d.alpha.x * cs.x;
    float y = d.alpha.y * cs.y;
    if (ActiveDistribution() == kDistributionPhong) {
        // cos^2 = (1 - u)^(2 / (exponent + 2)), which is the squared alpha of this azimuth.
        float across2 = x * x + y * y;
        float sin2 = OneMinusExp(across2 * LogOneMinus(u.x));
        float scale = sqrt(sin2 / across2);
        return vec3(x * scale, y * scale, SafeSqrt(1.0f - sin2));
    }
    // This is Walter eq. 28: tan^2 = -alpha^2 ln(1 - u).
    float r = sqrt(-LogOneMinus(u.x));
    return normalize(vec3(x * r, y * r, 1.0f));
}

// Returns the density of Sample_wm per solid angle of wm. w and wm may each be turned around the surface, to
// -w and -wm.
INLINE float PDF(MicrofacetDistribution d, vec3 w, vec3 wm) {
    if (ActiveDistribution() != kDistributionGgx) return D(d, wm) * abs(wm.z);
    float facing = dot(w, wm);
    if (w.z * wm.z < 0.0f) facing = -facing;
    return D(d, wm) * max(facing, 0.0f) / (abs(w.z) + LambdaCos(d, w));
}

// ------------------------------------------------------------------------------- reflection and refraction

INLINE vec3 Reflect(vec3 wo, vec3 wm) { return 2.0f * dot(wo, wm) * wm - wo; }

// Returns the normal that reflects wo into wi, wm.z >= 0; zero if there is none.
INLINE vec3 ReflectionNormal(vec3 wo, vec3 wi) {
    vec3 h = wo + wi;
    float length2 = dot(h, h);
    if (length2 == 0.0f) return vec3(0.0f);
    return h * ((h.z < 0.0f ? -1.0f : 1.0f) / sqrt(length2));
}

// wo refracted at a facet that it sees from the front, dot(wo, wm) > 0. eta is the index behind the facet
// over that before it. False for total reflection.
INLINE bool Refract(vec3 wo, vec3 wm, float eta, OUT(vec3) wi) {
    wi = vec3(0.0f, 0.0f, 1.0f);
    float cosI = dot(wo, wm);
    float cosT = RefractedCosine(cosI, eta);
    if (cosT <= 0.0f) return false;
    wi = normalize((cosI / eta - cosT) * wm - wo / eta);
    return true;
}

// Returns the normal that refracts wo into wi, wm.z >= 0 (Walter eq. 16); zero if there is none. eta is the
// index on the side of wi over that on the side of wo.
INLINE vec3 RefractionNormal(vec3 wo, vec3 wi, float eta) {
    vec3 h = wo + eta * wi;
    float length2 = dot(h, h);
    if (length2 == 0.0f) return vec3(0.0f);
    return h * ((h.z < 0.0f ? -1.0f : 1.0f) / sqrt(length2));
}

// Returns D G / (4 cos cos), the reflection lobe of facets that reflect everything (Walter eq. 20).
INLINE float ReflectionLobe(MicrofacetDistribution d, vec3 wo, vec3 wi, vec3 wm) {
    return 0.25f * D(d, wm) * GOverCosines(d, wo, wi);
}

// Returns the density of wo reflected at the normals of Sample_wm (Walter eq. 14).
INLINE float ReflectionPDF(MicrofacetDistribution d, vec3 wo, vec3 wm) {
    // For visible normals the cosine cancels.
    if (ActiveDistribution() == kDistributionGgx) return 0.25f * D(d, wm) / (abs(wo.z) + LambdaCos(d, wo));
    return 0.25f * PDF(d, wo, wm) / max(abs(dot(wo, wm)), 1e-12f);
}

// Returns the Jacobian of refraction (Walter eq. 17): the solid angle of wm over that of wi.
INLINE float RefractionJacobian(vec3 wo, vec3 wi, vec3 wm, float eta) {
    return abs(dot(wi, wm)) / max(Sqr(dot(wi, wm) + dot(wo, wm) / eta), 1e-20f);
}

// Returns the refraction lobe of facets that refract everything (Walter eq. 21), for radiance: it holds the
// factor 1 / eta^2 by which radiance that comes from the side of wi changes. Refracts from wo.z > 0 alone.
INLINE float RefractionLobe(MicrofacetDistribution d, vec3 wo, vec3 wi, vec3 wm, float eta) {
    return D(d, wm) * GOverCosines(d, wo, wi) * abs(dot(wo, wm)) * RefractionJacobian(wo, wi, wm, eta) /
           (eta * eta);
}

// Returns the density of wo refracted at the normals of Sample_wm.
INLINE float RefractionPDF(MicrofacetDistribution d, vec3 wo, vec3 wi, vec3 wm, float eta) {
    return PDF(d, wo, wm) * RefractionJacobian(wo, wi, wm, eta);
}

// Returns whether wo sees the front of the facet and wi, on the other side of the surface, its back.
INLINE bool IsRefractedBy(vec3 wo, vec3 wi, vec3 wm) {
    return dot(wo, wm) * wo.z > 0.0f && dot(wi, wm) * wi.z > 0.0f;
}

SHADING_END

#endif

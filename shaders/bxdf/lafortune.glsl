// The modified Phong lobe: Lafortune and Willems 1994, "Using the Modified Phong Reflectance Model for
// Physically Based Rendering". A diffuse share, and a specular one about the mirror direction:
//     f = diffuse / pi + specular (n + 2) / (2 pi) cos^n(angle to the mirror direction)
// Reciprocal; it reflects at most diffuse + specular, which must not exceed 1 in any channel, and all of it
// at normal incidence. Part of the specular lobe goes below the horizon at other angles, and is lost.
//
// Sample_f chooses by uc among diffuse, specular and nothing: with probability 1 - max(diffuse) -
// max(specular) the light is absorbed and the sample fails. So PDF integrates to less than one: to the two
// shares, minus the part of the specular lobe below the horizon.
#ifndef RAYGRAPH_BXDF_LAFORTUNE_GLSL
#define RAYGRAPH_BXDF_LAFORTUNE_GLSL

#include "bxdf/microfacet.glsl"
#include "core/frame.glsl"

SHADING_BEGIN

struct LafortuneBxDF {
    vec3 diffuse;    // the shares of light that each part reflects
    vec3 specular;
    float exponent;  // n, at least 0
};

// Returns the exponent whose lobe is as wide, at normal incidence, as that of microfacets of this alpha.
// Theirs is cos^(2 / alpha^2 - 2) of the angle of the normal (Walter et al. 2007), half that of the mirror
// direction; to second order in the angle a quarter of the exponent does the same there.
INLINE float LafortuneExponent(float alpha) {
    return max(0.5f / Sqr(clamp(alpha, kSmoothAlpha, 1.0f)) - 0.5f, 0.0f);
}

INLINE uint Flags(LafortuneBxDF lobe) {
    uint flags = MaxComponent(lobe.diffuse) > 0.0f ? kBxDFReflection | kBxDFDiffuse : kBxDFNone;
    return flags | (MaxComponent(lobe.specular) > 0.0f ? kBxDFReflection | kBxDFGlossy : kBxDFNone);
}

// Returns the probabilities of the diffuse and of the specular part. Their sum exceeds 1 where different
// channels have the largest share; then both are scaled to leave no absorption.
INLINE vec2 LobeProbabilities(LafortuneBxDF lobe) {
    vec2 chances = vec2(MaxComponent(lobe.diffuse), MaxComponent(lobe.specular));
    return chances / max(chances.x + chances.y, 1.0f);
}

// Returns cos^n of the angle between wi and the mirror direction of wo; 0 from a right angle on. The distance
// of their ends gives that angle more precisely than its cosine does.
INLINE float MirrorPower(float exponent, vec3 wo, vec3 wi) {
    vec3 difference = wi - vec3(-wo.x, -wo.y, wo.z);
    float oneMinusCos = 0.5f * dot(difference, difference);
    return oneMinusCos < 1.0f ? exp2(1.44269504088896f * exponent * LogOneMinus(oneMinusCos)) : 0.0f;
}

INLINE vec3 f(LafortuneBxDF lobe, vec3 wo, vec3 wi) {
    if (!SameHemisphere(wo, wi)) return vec3(0.0f);
    float power = (lobe.exponent + 2.0f) * kInv2Pi * MirrorPower(lobe.exponent, wo, wi);
    return lobe.diffuse * kInvPi + lobe.specular * power;
}

INLINE float PDF(LafortuneBxDF lobe, vec3 wo, vec3 wi) {
    if (!SameHemisphere(wo, wi)) return 0.0f;
    vec2 chances = LobeProbabilities(lobe);
    float power = (lobe.exponent + 1.0f) * kInv2Pi * MirrorPower(lobe.exponent, wo, wi);
    return chances.x * CosineHemispherePDF(abs(wi.z)) + chances.y * power;
}

INLINE BSDFSample Sample_f(LafortuneBxDF lobe, vec3 wo, float uc, vec2 u) {
    BSDFSample result = NoSample();
    vec2 chances = LobeProbabilities(lobe);
    if (wo.z == 0.0f || uc >= chances.x + chances.y) return result;
    vec3 wi = vec3(0.0f);
    if (uc < chances.x) {
        wi = SampleCosineHemisphere(u);
        if (wo.z < 0.0f) wi.z = -wi.z;
        result.flags = kBxDFReflection | kBxDFDiffuse;
    } else {
        // The sample is cos^(n + 1) = 1 - u about the mirror direction.
        float logCos = LogOneMinus(u.x) / (lobe.exponent + 1.0f);
        float sinTheta = SafeSqrt(OneMinusExp(2.0f * logCos));
        vec2 cs = CosSinTurn(u.y);
        Frame frame = FrameFromZ(vec3(-wo.x, -wo.y, wo.z));
        float cosTheta = 1.0f - OneMinusExp(logCos);
        wi = normalize(FromLocal(frame, vec3(sinTheta * cs.x, sinTheta * cs.y, cosTheta)));
        result.flags = kBxDFReflection | kBxDFGlossy;
    }
    if (!SameHemisphere(wo, wi)) return NoSample();
    result.wi = wi;
    result.f = f(lobe, wo, wi);
    result.pdf = PDF(lobe, wo, wi);
    return result;
}

SHADING_END

#endif

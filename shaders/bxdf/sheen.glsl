// The lobe of sheen (KHR_materials_sheen): fibers that stand on the surface, more or less upright, like those
// of velvet. Conty and Kulla 2017, "Production Friendly Microfacet Sheen BRDF": the "Charlie" distribution
// and their fit of its masking, without Fresnel. Below a roughness of 0.25 that fit reflects more than comes
// in at grazing angles (2.1 times at 0.1): there f is capped, by the lesser of the factors that keep the
// albedo of either direction at 1, which is reciprocal and leaves all other pairs as they are.
//
// The lobes below are scaled by 1 - m E(wo), with m the largest channel of the color and E the albedo of
// white sheen; a diffuse base also by the same factor of the light's direction over its mean, so that the sum
// is reciprocal and white stays white.
#ifndef RAYGRAPH_BXDF_SHEEN_GLSL
#define RAYGRAPH_BXDF_SHEEN_GLSL

#include "bxdf/lobe.glsl"

SHADING_BEGIN

struct SheenBxDF {
    vec3 color;         // times its share of the light
    float alpha;
    TableSpan row;      // row of the energy tables
    float covered;      // the largest channel of the color
    vec2 energy;        // SheenEnergyAt wo
    float transmittanceScale;  // 1 / mean of what it passes
};

// Returns the density of normals: its integral times the cosine is 1. Conty and Kulla, section 2.
INLINE float SheenD(float alpha, float cosTheta) {
    float exponent = 1.0f / alpha;
    float sin2 = max(1.0f - cosTheta * cosTheta, 0.0f);
    return (2.0f + exponent) * pow(sin2, 0.5f * exponent) * (0.5f * kInvPi);
}

// Returns the exponent of Lambda for cosines below 0.5; the same paper, section 3.
INLINE float SheenFit(float alpha, float x) {
    float t = Sqr(1.0f - alpha);
    float a = mix(21.5473f, 25.3245f, t);
    float b = mix(3.82987f, 3.32435f, t);
    float c = mix(0.19823f, 0.16801f, t);
    float d = mix(-1.97760f, -1.27393f, t);
    float e = mix(-4.32054f, -4.85967f, t);
    return a / (1.0f + b * pow(x, c)) + d * x + e;
}

INLINE float SheenLambda(float alpha, float cosTheta) {
    float exponent = cosTheta < 0.5f ? SheenFit(alpha, cosTheta)
                                     : 2.0f * SheenFit(alpha, 0.5f) - SheenFit(alpha, 1.0f - cosTheta);
    return exp2(1.44269504088896f * exponent);
}

// Returns f of white sheen, for two directions above the surface.
INLINE float SheenF(float alpha, vec3 wo, vec3 wi) {
    vec3 sum = wo + wi;
    float square = dot(sum, sum);
    if (!(square > 0.0f) || !(wo.z > 0.0f) || !(wi.z > 0.0f)) return 0.0f;
    float masking = 1.0f + SheenLambda(alpha, min(wo.z, 1.0f)) + SheenLambda(alpha, min(wi.z, 1.0f));
    return SheenD(alpha, sum.z * inversesqrt(square)) / (4.0f * wo.z * wi.z * masking);
}

// Returns the energy for one direction. x: the albedo of white sheen; y: the factor that caps f.
INLINE vec2 SheenEnergyAt(TableSpan row, float cosTheta) {
    TableSpan column = SpanAt(sqrt(max(cosTheta, 0.0f)), kEnergyCosCount);
    uint at = kEnergySheenOffset + row.first * kEnergyCosCount + column.first;
    uint next = at + kEnergyCosCount;
    vec4 low = mix(EnergyEntryOf(at).first, EnergyEntryOf(at + 1u).first, column.t);
    vec4 high = mix(EnergyEntryOf(next).first, EnergyEntryOf(next + 1u).first, column.t);
    vec4 energy = mix(low, high, row.t);
    return vec2(energy.x, energy.y);
}

// Returns the mean of that albedo.
INLINE float MeanSheenAlbedo(TableSpan row) {
    uint at = kEnergySheenMeanOffset + row.first;
    return mix(EnergyEntryOf(at).first.x, EnergyEntryOf(at + 1u).first.x, row.t);
}

INLINE void InitLobe(OUT(SheenBxDF) lobe, SurfaceMaterial material, SurfaceSetting, FacetView view,
                      INOUT(float) share) {
    lobe.alpha = max(Sqr(material.sheenRoughness), kMinSheenAlpha);
    lobe.row = SpanAt(sqrt(lobe.alpha), kEnergyAlphaCount);
    lobe.color = share * material.sheenColor;
    lobe.covered = MaxComponent(material.sheenColor);
    lobe.energy = vec2(0.0f);
    lobe.transmittanceScale = 1.0f;
    if (!(lobe.covered > 0.0f)) return;
    lobe.energy = SheenEnergyAt(lobe.row, view.wo.z);
    lobe.transmittanceScale = 1.0f / max(1.0f - lobe.covered * MeanSheenAlbedo(lobe.row), 1e-3f);
    share *= 1.0f - lobe.covered * lobe.energy.x;
}

INLINE bool IsDiffuse(SheenBxDF) { return false; }

INLINE uint Flags(SheenBxDF, FacetView) { return kBxDFReflection | kBxDFGlossy; }

INLINE vec3 Evaluate(SheenBxDF lobe, FacetView view, FacetPair pair, OUT(float) pdf) {
    pdf = 0.0f;
    if (pair.isDelta || !(pair.wi.z > 0.0f)) return vec3(0.0f);
    pdf = UniformHemispherePDF();
    float cap = min(lobe.energy.y, SheenEnergyAt(lobe.row, pair.wi.z).y);
    return lobe.color * (cap * SheenF(lobe.alpha, view.wo, pair.wi));
}

INLINE bool SamplesCosine(SheenBxDF, float) { return true; }

// Samples all directions uniformly: the lobe is brightest where the cosine is least.
INLINE BSDFSample SampleDirection(SheenBxDF, FacetView, vec3, float, vec2 u) {
    return CosineDirection(SampleUniformHemisphere(u), kBxDFGlossy);
}

// The light comes from all directions of its side, more from the viewer's: the normal stands for them.
INLINE LobeMean Reflected(SheenBxDF lobe, FacetView) {
    LobeMean mean = NoMean();
    mean.albedo = lobe.color * lobe.energy.x;
    mean.isDiffuse = true;
    return mean;
}

// Never 0, where the table ends at it: what lies below would jump (NormalizedTransmittance).
INLINE float Weight(SheenBxDF lobe, FacetView) { return Average(lobe.color) * max(lobe.energy.x, 1e-4f); }

INLINE float NormalizedTransmittance(SheenBxDF lobe, FacetView, FacetPair pair) {
    if (!IsForDiffuse(pair)) return 1.0f;
    return (1.0f - lobe.covered * SheenEnergyAt(lobe.row, abs(pair.wi.z)).x) * lobe.transmittanceScale;
}

LOBE_IS_OPAQUE(SheenBxDF)
LOBE_HAS_NO_WALK(SheenBxDF)
LOBE_BXDF_INTERFACE(SheenBxDF)

SHADING_END

#endif

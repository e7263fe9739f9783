// The parameters of bxdf/gltf.glsl, and the values that evaluation and sampling from one direction share.
#ifndef RAYGRAPH_BXDF_GLTF_PREPARE_GLSL
#define RAYGRAPH_BXDF_GLTF_PREPARE_GLSL

#include "bxdf/bxdf.glsl"
#include "bxdf/energy.glsl"
#include "bxdf/facet_fresnel.glsl"
#include "bxdf/microfacet.glsl"
#include "core/trace_options.glsl"

SHADING_BEGIN

// Surfaces that refract are kept this far from matched media, where the facet cannot be computed from
// the direction.
CONST float kGltfMinRefraction = 1e-3f;

struct GltfBxDF {
    vec3 baseColor;  // in [0, 1], as are the next two
    float metallic;
    float transmission;
    vec2 alpha;  // roughness^2, along x and y
    float specular;
    vec3 specularColor;
    float eta;    // n(other side) / n(side of wo)
    uint isThin;  // 1: a thin wall of that index
    uint seed;    // of the walk; another one for each sample
};

// A GltfBxDF as seen from one direction.
struct PreparedGltf {
    vec3 wo;
    MicrofacetDistribution facets;
    float eta;
    bool isSmooth;
    bool isThin;
    // Opaque reflection, metal and layer: at normal incidence and grazing, scaled
    vec3 reflect0;
    vec3 reflect90;
    vec3 metalScale;
    vec3 layerScale;
    // The dielectric's own Fresnel
    FacetFresnel dielectric;
    // Factors for glass: on reflection, and on transmission
    vec3 glassReflect;
    vec3 glassPass;
    vec3 glassDiffuse;  // over pi
    // Diffuse base over pi, without the factor 1 - E(wi)
    vec3 diffuse;
    TableSpan row;
    float laterCurve;
    // The lobe probabilities of Sample_f; they sum to 1, or all are 0
    float opaqueChance;
    float glassChance;
    float diffuseChance;
    // For the walk
    GltfBxDF bxdf;
    float rescattered;  // share of light that meets a second facet, about
    float metalShare;   // of opaqueChance
};

INLINE float Average(vec3 v) {
    return (v.x + v.y + v.z) * (1.0f / 3.0f);
}

INLINE uint Flags(GltfBxDF lobe) {
    uint rough = max(lobe.alpha.x, lobe.alpha.y) < kSmoothAlpha ? kBxDFSpecular : kBxDFGlossy;
    uint flags = kBxDFReflection | rough;
    if (lobe.metallic < 1.0f && lobe.transmission < 1.0f) flags |= kBxDFDiffuse;
    if (HasTraceFeature(kTraceGlass) && lobe.metallic < 1.0f && lobe.transmission > 0.0f)
        flags |= kBxDFTransmission;
    return flags;
}

INLINE FacetFresnel DielectricFresnel(GltfBxDF lobe) {
    FacetFresnel fresnel;
    fresnel.f0 = min(DielectricF0(lobe.eta) * lobe.specularColor, vec3(1.0f)) * lobe.specular;
    fresnel.f90 = vec3(lobe.specular * DielectricF90(lobe.eta));
    fresnel.exactF90 = vec3(lobe.specular);
    fresnel.isMetal = false;
    return fresnel;
}

INLINE FacetFresnel MetalFresnel(GltfBxDF lobe) {
    FacetFresnel fresnel;
    fresnel.f0 = lobe.baseColor;
    fresnel.f90 = vec3(1.0f);
    fresnel.exactF90 = vec3(1.0f);
    fresnel.isMetal = true;
    return fresnel;
}

// The tables are those of GGX with correlated masking; other models are not scaled.
INLINE bool HasCompensation() {
    return ActiveMultiscatterKind() == kMultiscatterKindLut && ActiveDistribution() == kDistributionGgx &&
           ActiveMasking() == kMaskingCorrelated;
}

INLINE bool IsWalked() {
    return ActiveMultiscatterKind() == kMultiscatterKindWalk && ActiveDistribution() == kDistributionGgx;
}

// The factor by which single scattering of albedo `single` includes `multiple`.
INLINE vec3 LaterBounces(vec3 single, vec3 multiple) {
    return HasCompensation() ? vec3(1.0f) + multiple / max(single, vec3(1e-4f)) : vec3(1.0f);
}

// MultipleAlbedo, if there is any.
INLINE vec3 LaterAlbedo(PreparedGltf g, FacetEnergy energy, vec3 f0, vec3 f90) {
    if (!HasCompensation() && !IsWalked()) return vec3(0.0f);
    return MultipleAlbedo(energy, f0, f90, g.laterCurve);
}

INLINE PreparedGltf Prepare(GltfBxDF lobe, vec3 wo) {
    PreparedGltf g;
    g.wo = wo;
    g.facets = MakeMicrofacetDistribution(lobe.alpha);
    g.isSmooth = IsEffectivelySmooth(g.facets);
    g.isThin = lobe.isThin != 0u;
    g.eta = lobe.eta;
    g.reflect0 = vec3(0.0f);
    g.reflect90 = vec3(0.0f);
    g.metalScale = vec3(0.0f);
    g.layerScale = vec3(0.0f);
    g.dielectric = DielectricFresnel(lobe);
    g.glassReflect = vec3(0.0f);
    g.glassPass = vec3(0.0f);
    g.glassDiffuse = vec3(0.0f);
    g.diffuse = vec3(0.0f);
    g.laterCurve = 0.0f;
    g.row = EnergyRow(g.facets.alpha);
    g.opaqueChance = 0.0f;
    g.glassChance = 0.0f;
    g.diffuseChance = 0.0f;
    g.bxdf = lobe;
    g.rescattered = 0.0f;
    g.metalShare = 0.0f;
    if (!(wo.z > 0.0f)) return g;

    FacetEnergy energy = FacetEnergyAt(g.row, wo.z);
    g.laterCurve = LaterCurve(g.row);
    g.rescattered = max(energy.second, 0.01f);
    float layered = 1.0f - lobe.metallic;
    float glass = HasTraceFeature(kTraceGlass) ? layered * lobe.transmission : 0.0f;
    float opaque = layered - glass;

    if (lobe.metallic > 0.0f) {
        vec3 single = SingleAlbedo(energy, lobe.baseColor, vec3(1.0f));
        vec3 multiple = LaterAlbedo(g, energy, lobe.baseColor, vec3(1.0f));
        g.metalScale = lobe.metallic * LaterBounces(single, multiple);
        g.reflect0 = g.metalScale * lobe.baseColor;
        g.reflect90 = g.metalScale;
        g.opaqueChance = Average(g.metalScale * single);
        g.metalShare = g.opaqueChance;
    }
    vec3 f0 = g.dielectric.f0;
    vec3 f90 = g.dielectric.f90;
    vec3 single = SingleAlbedo(energy, f0, f90);
    if (opaque > 0.0f) {
        vec3 multiple = LaterAlbedo(g, energy, f0, f90);
        g.layerScale = opaque * LaterBounces(single, multiple);
        g.reflect0 += g.layerScale * f0;
        g.reflect90 += g.layerScale * f90;
        FacetEnergy mean = MeanFacetEnergy(g.row);
        // The same of each channel: PassedShare
        vec3 meanLater = LaterAlbedo(g, mean, f0, f90);
        float passedMean = MinComponent(vec3(1.0f) - SingleAlbedo(mean, f0, f90) - meanLater);
        float passed = MinComponent(vec3(1.0f) - single - multiple);
        vec3 base = opaque * lobe.baseColor * max(passed, 0.0f);
        g.diffuse = base * kInvPi / max(passedMean, 1e-3f);
        g.opaqueChance += Average(g.layerScale * single);
        g.diffuseChance = Average(base);
    }
    if (glass > 0.0f) {
        if (!g.isThin && !g.isSmooth) {
            bool isDenser = g.eta >= 1.0f;
            g.eta = isDenser ? max(g.eta, 1.0f + kGltfMinRefraction) : min(g.eta, 1.0f - kGltfMinRefraction);
        }
        float glassDiffuse = 0.0f;
        g.glassReflect = vec3(glass);
        // Radiance is scaled by the true index
        g.glassPass = lobe.baseColor * (g.isThin ? glass : glass * Sqr(g.eta / lobe.eta));
        if (HasCompensation() && !g.isSmooth) {
            GlassScale scale;
            if (g.isThin) {
                scale.reflected = vec3(1.0f / max(energy.single.x + energy.single.y, 0.05f));
                scale.transmitted = scale.reflected;
                scale.diffuse = vec3(0.0f);
            } else {
                scale = GlassScaleAt(f0, f90, energy.single, g.facets.alpha, g.eta, wo.z);
            }
            g.glassReflect *= scale.reflected;
            g.glassPass *= scale.transmitted;
            g.glassDiffuse = scale.diffuse * (glass * kInvPi);
            glassDiffuse = glass * Average(scale.diffuse);
        }
        // From the denser side there is much total reflection
        vec3 layer = g.eta < 1.0f && !g.isThin ? max(single, vec3(0.5f)) : single;
        float returned = glass * Average(mix(lobe.baseColor, vec3(1.0f), layer));
        g.glassChance = max(returned - glassDiffuse, 0.01f * glass);
        g.diffuseChance += glassDiffuse;
    }

    float sum = g.opaqueChance + g.glassChance + g.diffuseChance;
    float scale = sum > 0.0f ? 1.0f / sum : 0.0f;
    g.metalShare = g.opaqueChance > 0.0f ? g.metalShare / g.opaqueChance : 0.0f;
    g.opaqueChance *= scale;
    g.glassChance *= scale;
    g.diffuseChance *= scale;
    return g;
}

// Folds where the scene has none.
INLINE bool HasGlass(PreparedGltf g) {
    return HasTraceFeature(kTraceGlass) && g.glassChance > 0.0f;
}

SHADING_END

#endif

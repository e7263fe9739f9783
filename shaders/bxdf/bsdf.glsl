// The BSDF of a surface as seen from one direction, by the active model (shared/trace_options.h).
//     SurfaceBSDF BSDFOf(material, wo, ...)
//     vec3 Evaluate(bsdf, wi, isDelta, pdf, diffuse)
//         f, the density of wi in Sample_f, and the diffuse part of f; as bxdf/gltf.glsl
//     BSDFSample SampleDirection(bsdf, uc, u, isEvaluated)
//     vec3 DiffuseOf(bsdf, sample)           the diffuse part of the f of a sample that is evaluated
// Conventions are those of bxdf/bxdf.glsl.
#ifndef RAYGRAPH_BXDF_BSDF_GLSL
#define RAYGRAPH_BXDF_BSDF_GLSL

#include "bxdf/diffuse.glsl"
#include "bxdf/gltf.glsl"
#include "bxdf/lafortune.glsl"
#include "core/frame.glsl"
#include "core/trace_options.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

struct SurfaceBSDF {
    uint flags;
    vec3 wo;
    GltfBSDF gltf;  // the active one of these three is set
    DiffuseBxDF lambert;
    LafortuneBxDF lafortune;
};

// Returns the glTF material on the modified Phong model: the base color of the non-metallic share is diffuse,
// the rest a specular lobe about as wide as that of microfacets of this roughness.
INLINE LafortuneBxDF LafortuneOf(SurfaceMaterial material) {
    float f0 = Sqr((material.ior - 1.0f) / (material.ior + 1.0f)) * material.specular;
    LafortuneBxDF lobe;
    lobe.specular = mix(min(f0 * material.specularColor, vec3(1.0f)), material.baseColor, material.metallic);
    lobe.diffuse = material.baseColor * (1.0f - material.metallic) * (vec3(1.0f) - lobe.specular);
    lobe.exponent = LafortuneExponent(Sqr(material.roughness));
    return lobe;
}

// Returns the setting of a surface in the frame of its shading normal.
INLINE SurfaceSetting SettingOf(SurfaceInteraction surface, Frame frame, float eta, float minAlpha,
                                uint seed) {
    SurfaceSetting setting = SettingOf(surface.material, eta, minAlpha, seed);
    if (HasTraceFeature(kTraceClearcoat)) setting.coatNormal = ToLocal(frame, surface.coatNormal);
    // Seen from within a volume, its own index is on this side.
    if (HasTraceFeature(kTraceIridescence) && !setting.isThin && !surface.isFront)
        setting.outerIor = surface.material.ior;
    return setting;
}

INLINE SurfaceBSDF BSDFOf(SurfaceMaterial material, vec3 wo, SurfaceSetting setting) {
    SurfaceBSDF bsdf;
    bsdf.wo = wo;
    if (ActiveBrdf() == kBrdfLambert) {
        bsdf.lambert.albedo = material.baseColor;
        bsdf.flags = Flags(bsdf.lambert);
    } else if (ActiveBrdf() == kBrdfLafortune) {
        bsdf.lafortune = LafortuneOf(material);
        bsdf.flags = Flags(bsdf.lafortune);
    } else {
        bsdf.gltf = Prepare(material, setting, wo);
        bsdf.flags = bsdf.gltf.flags;
    }
    return bsdf;
}

// Returns whether light passes straight through a smooth thin wall as through a hole, except for the share
// that is lost.
INLINE bool IsSmoothThinWall(SurfaceMaterial material) {
    if (!HasTraceFeature(kTraceThinWalls) || ActiveBrdf() != kBrdfGltf) return false;
    return (material.flags & (kMaterialVolume | kMaterialUnlit)) == 0u && material.transmission > 0.0f &&
           IsEffectivelySmooth(MakeMicrofacetDistribution(AlphaOf(material)));
}

// Returns whether light passes straight through the boundary of a medium because both sides have one index:
// whatever its roughness, its facets have no effect, unless there is a film on them.
INLINE bool IsIndexMatched(SurfaceMaterial material, bool haveEqualIndices) {
    if (!HasTraceFeature(kTraceMatchedMedia) || ActiveBrdf() != kBrdfGltf) return false;
    if (HasTraceFeature(kTraceIridescence) && material.iridescence > 0.0f) return false;
    return haveEqualIndices && (material.flags & (kMaterialVolume | kMaterialUnlit)) == kMaterialVolume &&
           material.transmission > 0.0f;
}

// For smooth thin walls and matched boundaries, these return the share of light that goes straight on from
// wo, the probability that a sample does, and the other lobes, which sample the rest. The probability is
// below 1 unless there is no rest.
INLINE vec3 PassThroughWeight(SurfaceBSDF wall) { return PassThroughWeight(wall.gltf); }
INLINE float PassThroughProbability(SurfaceBSDF wall) { return PassThroughProbability(wall.gltf); }
INLINE SurfaceBSDF WithoutPassThrough(SurfaceBSDF wall, float chance) {
    wall.gltf = WithoutPassThrough(wall.gltf, chance);
    wall.flags = wall.gltf.flags;
    return wall;
}

INLINE vec3 Evaluate(SurfaceBSDF bsdf, vec3 wi, bool isDelta, OUT(float) pdf, OUT(vec3) diffuse) {
    if (ActiveBrdf() == kBrdfLambert) {
        pdf = PDF(bsdf.lambert, bsdf.wo, wi);
        diffuse = f(bsdf.lambert, bsdf.wo, wi);
        return diffuse;
    }
    if (ActiveBrdf() == kBrdfLafortune) {
        pdf = PDF(bsdf.lafortune, bsdf.wo, wi);
        vec3 value = f(bsdf.lafortune, bsdf.wo, wi);
        diffuse = min(bsdf.lafortune.diffuse * kInvPi, value);
        return value;
    }
    return Evaluate(bsdf.gltf, wi, isDelta, pdf, diffuse);
}

// Samples as Sample_f does, without its evaluation: f and pdf of the sample come from Evaluate, unless
// isEvaluated is set.
INLINE BSDFSample SampleDirection(SurfaceBSDF bsdf, float uc, vec2 u, OUT(bool) isEvaluated) {
    isEvaluated = true;
    if (ActiveBrdf() == kBrdfLambert) return Sample_f(bsdf.lambert, bsdf.wo, uc, u);
    if (ActiveBrdf() == kBrdfLafortune) return Sample_f(bsdf.lafortune, bsdf.wo, uc, u);
    return SampleDirection(bsdf.gltf, uc, u, isEvaluated);
}

INLINE vec3 DiffuseOf(SurfaceBSDF bsdf, BSDFSample evaluated) {
    if (ActiveBrdf() == kBrdfLafortune) return min(bsdf.lafortune.diffuse * kInvPi, evaluated.f);
    // The others evaluate samples of only one lobe
    return (evaluated.flags & kBxDFDiffuse) != 0u ? evaluated.f : vec3(0.0f);
}

SHADING_END

#endif

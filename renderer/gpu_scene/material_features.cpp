#include "renderer/gpu_scene/material_features.h"

#include <algorithm>

#include "renderer/gpu_scene/scene_resources.h"
#include "shaders/shared/microfacet_models.h"

namespace raygraph {

namespace {

bool HasFilm(const gpu::MaterialRecord& material) {
    const glm::vec2 thickness = material.iridescenceThickness;
    const bool isTextured = material.iridescenceThicknessTexture != gpu::kNoTexture;
    return material.iridescence > 0.0f && (thickness.y > 0.0f || (isTextured && thickness.x > 0.0f));
}

// Returns the features of the lobes that the material may have; an unlit one has none.
TraceFeatures LobeFeatures(const gpu::MaterialRecord& material) {
    if ((material.flags & gpu::kMaterialUnlit) != 0u) return {};
    // Textures scale their factors down
    const bool isDielectric =
        material.metallic < 1.0f || material.metallicRoughnessTexture != gpu::kNoTexture;
    const bool isOpaque = material.transmission < 1.0f || material.transmissionTexture != gpu::kNoTexture;
    TraceFeatures features;
    if (isDielectric && material.transmission > 0.0f) features |= kTraceGlass;
    if (material.metallic > 0.0f) features |= kTraceMetals;
    if (isDielectric && isOpaque) features |= kTraceOpaque;
    if (isDielectric && isOpaque && material.diffuseTransmission > 0.0f)
        features |= kTraceDiffuseTransmission;
    if (MayBeSmooth(material.roughness, material.metallicRoughnessTexture)) features |= kTraceSmooth;
    if (material.clearcoat > 0.0f) {
        features |= kTraceClearcoat;
        if (MayBeSmooth(material.clearcoatRoughness, material.clearcoatRoughnessTexture))
            features |= kTraceSmooth;
    }
    if (material.sheenColor != glm::vec3(0.0f)) features |= kTraceSheen;
    if (material.dispersion > 0.0f && (material.flags & gpu::kMaterialVolume) != 0u)
        features |= kTraceDispersion;
    if (material.scattering != glm::vec3(0.0f) && (material.flags & gpu::kMaterialVolume) != 0u)
        features |= kTraceScattering;
    if (HasFilm(material)) features |= kTraceIridescence;
    if (material.anisotropy > 0.0f) features |= kTraceAnisotropy;
    if (material.retroreflection > 0.0f) features |= kTraceRetroreflection;
    return features;
}

// Whether light passes straight into the medium of some material: it has the index of air, or it or another
// one of its index scatters. That other pairs of media of one index touch is rare (two objects of glass), so
// their boundaries stop shadow rays like those of all glass.
bool HasMatchedMedia(const SceneResources& resources) {
    const auto isOpen = [](const gpu::MaterialRecord& material) {
        return (material.flags & (gpu::kMaterialVolume | gpu::kMaterialUnlit)) == gpu::kMaterialVolume &&
               material.transmission > 0.0f;
    };
    for (const uint32_t used : resources.usedMaterials) {
        const gpu::MaterialRecord& inner = resources.materials[used];
        if (!isOpen(inner)) continue;
        if (inner.ior == 1.0f) return true;
        for (const uint32_t other : resources.usedMaterials) {
            const gpu::MaterialRecord& outer = resources.materials[other];
            if (other != used && (outer.flags & gpu::kMaterialVolume) != 0u && outer.ior == inner.ior &&
                (inner.scattering != glm::vec3(0.0f) || outer.scattering != glm::vec3(0.0f)))
                return true;
        }
    }
    return false;
}

bool HasTextureTransform(const gpu::MaterialRecord& material) {
    const glm::mat3x2 none = scene::TextureTransform{}.Matrix();
    const auto isTransformed = [&](uint32_t texture, const glm::mat3x2& transform) {
        return texture != gpu::kNoTexture && transform != none;
    };
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) \
    if (isTransformed(material.name##Texture, material.name##Transform)) return true;
#include "shaders/shared/material_list.h"
    return false;
}

// Mask of gpu::kTangents*: the texture coordinate sets by which the material reads its directional maps.
uint32_t DirectionalSets(const gpu::MaterialRecord& material) {
    const auto setOf = [](uint32_t texture) {
        if (texture == gpu::kNoTexture) return 0u;
        return (texture & gpu::kSecondTexCoord) != 0u ? gpu::kTangentsOfSecondSet : gpu::kTangentsOfFirstSet;
    };
    uint32_t sets = setOf(material.normalTexture);
    if (material.clearcoat > 0.0f) sets |= setOf(material.clearcoatNormalTexture);
    if (material.anisotropy > 0.0f) sets |= setOf(material.anisotropyTexture);
    return sets;
}

// Whether some material may read a directional map by another texture coordinate set than that of the
// tangents.
bool MayNeedFrames(const SceneResources& resources) {
    uint32_t sets = 0;
    for (const uint32_t used : resources.usedMaterials) sets |= DirectionalSets(resources.materials[used]);
    const bool areMixed =
        (sets | resources.tangentSets) == (gpu::kTangentsOfFirstSet | gpu::kTangentsOfSecondSet);
    return areMixed && sets != 0 && resources.tangentSets != 0;
}

TraceFeatures TextureFeatures(const SceneResources& resources) {
    TraceFeatures features;
    if (resources.hasVertexColors) features |= kTraceVertexColors;
    if (!resources.textures || resources.textures->Count() == 0) return features;
    const bool areTransformed = std::ranges::any_of(resources.usedMaterials, [&](uint32_t used) {
        return HasTextureTransform(resources.materials[used]);
    });
    features |= kTraceTextures;
    if (areTransformed || MayNeedFrames(resources)) features |= kTraceTextureTransforms;
    return features;
}

}  // namespace

bool MayBeSmooth(float roughness, uint32_t texture) {
    return roughness * roughness < kSmoothAlpha || texture != gpu::kNoTexture;
}

TraceFeatures MaterialFeatures(const SceneResources& resources) {
    TraceFeatures features = TextureFeatures(resources);
    for (const uint32_t used : resources.usedMaterials) {
        const gpu::MaterialRecord& material = resources.materials[used];
        features |= LobeFeatures(material);
        if ((material.flags & gpu::kMaterialVolume) != 0u) features |= kTraceVolumes | kTraceProbeMedia;
    }
    if (HasMatchedMedia(resources)) features |= kTraceMatchedMedia;
    for (const GroupResources& group : resources.groups) {
        if (!group.kind.isOpaque) features |= kTraceAnyHit;
        if (group.kind.isThinWall) features |= kTraceThinWalls;
        if (group.kind.isRound) features |= kTraceCapsules;
    }
    return features;
}

}  // namespace raygraph

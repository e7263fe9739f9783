#include "renderer/gpu_scene/materials/material_features.h"

#include <algorithm>
#include <functional>
#include <map>
#include <vector>

#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "shaders/shared/microfacet_models.h"

namespace raygraph {

namespace {

using MaterialList = std::vector<std::reference_wrapper<const gpu::MaterialRecord>>;

bool HasFilm(const gpu::MaterialRecord& material) {
    const glm::vec2 thickness = material.iridescenceThickness;
    const bool isTextured = material.iridescenceThicknessTexture != gpu::kNoTexture;
    return material.iridescence > 0.0f && (thickness.y > 0.0f || (isTextured && thickness.x > 0.0f));
}

// Returns the features of the lobes that the material may have; an unlit one has none.
TraceFeatures LobeFeatures(const gpu::MaterialRecord& material) {
    if ((material.flags & gpu::kMaterialUnlit) != 0u) return {};
    // Textures may scale their factors down
    const bool isDielectric =
        material.metallic < 1.0f || material.metallicRoughnessTexture != gpu::kNoTexture;
    const bool isVolume = (material.flags & gpu::kMaterialVolume) != 0u;
    const bool scattersThinly = material.scatterStrength > 0.0f;
    const bool isOpaque =
        material.transmission < 1.0f || material.transmissionTexture != gpu::kNoTexture || scattersThinly;
    TraceFeatures features;
    if (isDielectric && (material.flags & gpu::kMaterialGlass) != 0u) features |= kTraceGlass;
    if (material.metallic > 0.0f) features |= kTraceMetals;
    if (isDielectric && isOpaque) features |= kTraceOpaque;
    if (isDielectric && isOpaque && material.diffuseTransmission > 0.0f)
        features |= kTraceDiffuseTransmission;
    if (isDielectric && scattersThinly) features |= kTraceThinScatter | kTraceDiffuseTransmission;
    if (MayBeSmooth(material.roughness, material.metallicRoughnessTexture)) features |= kTraceSmooth;
    if (material.clearcoat > 0.0f) {
        features |= kTraceClearcoat;
        if (MayBeSmooth(material.clearcoatRoughness, material.clearcoatRoughnessTexture))
            features |= kTraceSmooth;
    }
    if (material.sheenColor != glm::vec3(0.0f)) features |= kTraceSheen;
    if (material.dispersion > 0.0f && isVolume) features |= kTraceDispersion;
    if (material.scattering != glm::vec3(0.0f) && isVolume) features |= kTraceScattering;
    if (HasFilm(material)) features |= kTraceIridescence;
    if (material.anisotropy > 0.0f) features |= kTraceAnisotropy;
    if (material.retroreflection > 0.0f) features |= kTraceRetroreflection;
    return features;
}

// Tells whether light passes straight into the medium of some material: the medium has the index of air, or
// it or another one of the same index scatters. Other pairs of media with equal indices that touch are rare
// (two objects of glass), and their boundaries stop shadow rays like those of all glass.
bool HasMatchedMedia(const MaterialList& used) {
    struct Media {
        uint32_t count = 0;
        bool isAnyTransmissive = false;  // light enters it
        bool isAnyScattering = false;
    };
    std::map<float, Media> byIndex;
    for (const gpu::MaterialRecord& material : used) {
        if ((material.flags & gpu::kMaterialVolume) == 0u) continue;
        Media& media = byIndex[material.ior];
        ++media.count;
        media.isAnyTransmissive |=
            (material.flags & gpu::kMaterialUnlit) == 0u && material.transmission > 0.0f;
        media.isAnyScattering |= material.scattering != glm::vec3(0.0f);
    }
    return std::ranges::any_of(byIndex, [](const auto& of) {
        const auto& [ior, media] = of;
        return media.isAnyTransmissive && (ior == 1.0f || (media.count > 1 && media.isAnyScattering));
    });
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

// Returns a mask of gpu::kTangents*: the texture coordinate sets by which the material reads its directional
// maps.
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

// Tells whether some material may read a directional map by another texture coordinate set than that of the
// tangents.
bool MayNeedFrames(const MaterialList& used, uint32_t tangentSets) {
    uint32_t sets = 0;
    for (const gpu::MaterialRecord& material : used) sets |= DirectionalSets(material);
    const bool areMixed = (sets | tangentSets) == (gpu::kTangentsOfFirstSet | gpu::kTangentsOfSecondSet);
    return areMixed && sets != 0 && tangentSets != 0;
}

// Returns each material of the parts once.
MaterialList UsedMaterials(std::span<const gpu::MaterialRecord> materials,
                           std::span<const GroupResources> groups) {
    std::vector<bool> isUsed(materials.size());
    for (const GroupResources& group : groups)
        for (const GroupPart& part : group.parts) isUsed[part.material] = true;
    MaterialList used;
    for (size_t i = 0; i < materials.size(); ++i)
        if (isUsed[i]) used.emplace_back(materials[i]);
    return used;
}

}  // namespace

bool MayBeSmooth(float roughness, uint32_t texture) {
    return roughness * roughness < kSmoothAlpha || texture != gpu::kNoTexture;
}

TraceFeatures MaterialFeatures(std::span<const gpu::MaterialRecord> materials, uint32_t textureCount,
                               const SceneGeometry& geometry) {
    const MaterialList used = UsedMaterials(materials, geometry.groups);
    TraceFeatures features;
    if (geometry.hasVertexColors) features |= kTraceVertexColors;
    if (textureCount > 0) {
        const bool areTransformed = std::ranges::any_of(used, HasTextureTransform);
        features |= kTraceTextures;
        if (areTransformed || MayNeedFrames(used, geometry.tangentSets)) features |= kTraceTextureTransforms;
    }
    for (const gpu::MaterialRecord& material : used) {
        features |= LobeFeatures(material);
        if ((material.flags & gpu::kMaterialVolume) != 0u) features |= kTraceVolumes | kTraceProbeMedia;
    }
    if (HasMatchedMedia(used)) features |= kTraceMatchedMedia;
    for (const GroupResources& group : geometry.groups) {
        if (!group.kind.isOpaque) features |= kTraceAnyHit;
        if (group.kind.isThinWall) features |= kTraceThinWalls;
        if (group.kind.isRound) features |= kTraceCapsules;
    }
    return features;
}

}  // namespace raygraph

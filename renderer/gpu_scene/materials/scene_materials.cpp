#include "renderer/gpu_scene/materials/scene_materials.h"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/scene/model/scene_fields.h"
#include "shaders/shared/choice.h"

namespace raygraph {

SceneMaterials::SceneMaterials(rhi::Device& device, const rhi::Texture& defaultTexture,
                               const rhi::Sampler& defaultSampler, float maxAnisotropy)
    : m_records(device, "materials", "UploadMaterials"),
      m_textures(std::make_unique<TextureSet>(device, defaultTexture, defaultSampler, maxAnisotropy)) {}

std::vector<uint32_t> SceneMaterials::Add(std::span<const scene::Material> added,
                                          std::span<const uint32_t> textureNumbers) {
    std::vector<uint32_t> slots, numbers;
    for (const uint32_t texture : textureNumbers)
        slots.push_back(texture == scene::kNone ? 0 : m_textures->Slot(texture));
    const std::vector<gpu::MaterialRecord> records = MaterialRecords(added, slots);
    std::vector<Use> uses;
    std::vector<float> alphas(added.size(), 1.0f);
    for (const scene::Material& material : added) {
        Use& use = uses.emplace_back();
        for (const uint32_t texture : TexturesOf(material)) use.textures.push_back(textureNumbers[texture]);
        if (!material.baseColorTexture.IsPresent()) continue;
        const auto baseColor = static_cast<size_t>(material.baseColorTexture.texture);
        alphas[uses.size() - 1] = m_textures->Image(textureNumbers[baseColor]).lowestAlpha;
    }
    numbers.reserve(added.size());
    try {
        for (size_t i = 0; i < added.size(); ++i) numbers.push_back(m_slots.Allocate(1));
        m_records.Grow(m_slots.End());
        m_textureAlphas.resize(m_records.Size(), 1.0f);
        m_uses.resize(m_records.Size(), {.exists = false});
    } catch (...) {
        for (const uint32_t number : numbers) m_slots.Free(number, 1);
        throw;
    }
    for (size_t i = 0; i < added.size(); ++i) {
        for (const uint32_t texture : uses[i].textures) ++m_textureUses[texture];
        m_records.Edit(numbers[i]) = records[i];
        m_uses[numbers[i]] = std::move(uses[i]);
        m_textureAlphas[numbers[i]] = alphas[i];
    }
    return numbers;
}

std::vector<uint32_t> SceneMaterials::AddTextures(std::span<const SceneTexture> added) {
    m_textureUses.reserve(m_textures->Size() + added.size());
    std::vector<uint32_t> numbers = m_textures->Add(added);
    m_textureUses.resize(m_textures->Size());
    m_featuresDirty = true;
    return numbers;
}

void SceneMaterials::Remove(uint32_t material) noexcept {
    for (const uint32_t texture : m_uses[material].textures) --m_textureUses[texture];
    m_uses[material] = {.exists = false};
    m_slots.Free(material, 1);
}

void SceneMaterials::RemoveTexture(uint32_t texture) {
    m_textures->Remove(texture);
    m_featuresDirty = true;
}

std::vector<SceneMaterials::ChangedRecord> SceneMaterials::ChangedBySwap(std::span<const uint32_t> a,
                                                                         std::span<const uint32_t> b) const {
    std::map<uint32_t, uint32_t> now;             // by slot: the slot that takes its place
    std::map<uint32_t, const SceneImage*> shown;  // by new slot
    for (size_t i = 0; i < a.size(); ++i) {
        const uint32_t slots[] = {m_textures->Slot(a[i]), m_textures->Slot(b[i])};
        now[slots[0]] = slots[1];
        now[slots[1]] = slots[0];
        shown[slots[0]] = &m_textures->Image(a[i]);
        shown[slots[1]] = &m_textures->Image(b[i]);
    }
    std::vector<ChangedRecord> changed;
    for (uint32_t material = 0; material < Size(); ++material) {
        if (!Exists(material)) continue;
        gpu::MaterialRecord record = Records()[material];
        bool isChanged = false;
        const auto follow = [&](uint32_t& slot) {
            if (slot == gpu::kNoTexture) return;
            const auto found = now.find(slot & ~gpu::kSecondTexCoord);
            if (found == now.end()) return;
            slot = found->second | (slot & gpu::kSecondTexCoord);
            isChanged = true;
        };
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) follow(record.name##Texture);
#include "shaders/shared/material_list.h"
        if (!isChanged) continue;
        changed.push_back({material, record, m_textureAlphas[material]});
        if (const auto found = shown.find(record.baseColorTexture & ~gpu::kSecondTexCoord);
            record.baseColorTexture != gpu::kNoTexture && found != shown.end())
            changed.back().textureAlpha = found->second->lowestAlpha;
    }
    return changed;
}

void SceneMaterials::SwapTextures(std::span<const uint32_t> a, std::span<const uint32_t> b) noexcept {
    for (size_t i = 0; i < a.size(); ++i) m_textures->Swap(a[i], b[i]);
}

void SceneMaterials::Exchange(ChangedRecord& changed) noexcept {
    m_featuresDirty = true;
    std::swap(m_records.Edit(changed.material), changed.record);
    std::swap(m_textureAlphas[changed.material], changed.textureAlpha);
}

void SceneMaterials::CountUsers(std::span<const GroupResources> groups, int change) noexcept {
    m_featuresDirty = true;
    for (const GroupResources& group : groups)
        for (const GroupPart& part : group.parts) {
            if (part.variants.empty()) m_uses[part.material].partCount += change;
            for (const PartVariant& other : part.variants) m_uses[other.material].partCount += change;
        }
}

void SceneMaterials::Declare(Renderer& renderer, SceneIds& ids, const SceneGeometry& geometry) {
    ids.materials = m_records.Declare(renderer);
    ids.textures = renderer.Import("textures", m_textures->Table());
    if (m_featuresDirty) {
        m_features = MaterialFeatures(Records(), m_textures->Count(), geometry);
        m_featuresDirty = false;
        ++m_featureUpdates;
    }
    ids.features |= m_features;
}

// --- Trace features ---

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
    if ((material.flags & gpu::kMaterialShadowCatcher) != 0u) features |= kTraceShadowCatcher;
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

// --- Records ---

namespace {

// Returns the slot of a texture. Before slots are assigned, 0 marks any texture.
uint32_t TextureSlot(const scene::TextureRef& reference, std::span<const uint32_t> slots) {
    if (!reference.IsPresent()) return gpu::kNoTexture;
    const uint32_t slot = slots.empty() ? 0u : slots[static_cast<size_t>(reference.texture)];
    return slot | (reference.texCoord == 1 ? gpu::kSecondTexCoord : 0u);
}

}  // namespace

gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures) {
    gpu::MaterialRecord record = textures;
#define RAYGRAPH_MATERIAL_VALUE(type, name, field, object, key, quantity) record.name = values.field;
    // Transforms of textures that `values` does not name stay as they are
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) \
    if (values.name##Texture.IsPresent()) record.name##Transform = values.name##Texture.transform.Matrix();
#include "shaders/shared/material_list.h"
    record.emission = values.EmittedRadiance();
    record.alphaMode = static_cast<uint32_t>(values.alphaMode);
    record.flags = (values.IsBackCulled() ? 0u : gpu::kMaterialTwoSided) |
                   (values.isUnlit ? gpu::kMaterialUnlit : 0u) |
                   (values.BoundsMedium() ? gpu::kMaterialVolume : 0u) |
                   (values.isShadowCatcher ? gpu::kMaterialShadowCatcher : 0u);
    if (values.isSpecularGlossiness && record.specularColorTexture != gpu::kNoTexture)
        record.flags |= gpu::kMaterialGlossiness;
    record.ior = values.ior > 0.0f ? values.ior : gpu::kInfiniteIor;
    record.extinction = values.Extinction();
    record.scattering = values.Scattering();
    record.scatterAnisotropy = values.ScatteringMeanCosine();
    if (values.BoundsMedium() || values.transmissionFactor == 0.0f) record.scatterStrength = 0.0f;
    // KHR_materials_scatter replaces KHR_materials_diffuse_transmission on a sheet that has both.
    if (record.scatterStrength > 0.0f) record.diffuseTransmission = 0.0f;
    const bool scattersAll =
        record.scatterStrength >= 1.0f && record.scatterStrengthTexture == gpu::kNoTexture;
    if (values.transmissionFactor > 0.0f && !scattersAll) record.flags |= gpu::kMaterialGlass;
    if (values.isUnlit) record.clearcoat = 0.0f;
    record.iridescenceThickness = {values.iridescenceThicknessMinimum, values.iridescenceThicknessMaximum};
    return record;
}

std::vector<uint32_t> TexturesOf(const scene::Material& material) {
    std::vector<uint32_t> textures;
    scene::ForEachShownTexture(material, [&](const scene::TextureRef& reference) {
        textures.push_back(static_cast<uint32_t>(reference.texture));
    });
    std::ranges::sort(textures);
    textures.erase(std::unique(textures.begin(), textures.end()), textures.end());
    return textures;
}

std::vector<gpu::MaterialRecord> MaterialRecords(std::span<const scene::Material> materials,
                                                 std::span<const uint32_t> slots) {
    std::vector<gpu::MaterialRecord> records;
    for (const scene::Material& material : materials) {
        gpu::MaterialRecord fields{};
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) \
    fields.name##Texture = TextureSlot(material.name##Texture, slots);
#include "shaders/shared/material_list.h"
        records.push_back(ToRecord(material, fields));
    }
    return records;
}

}  // namespace raygraph

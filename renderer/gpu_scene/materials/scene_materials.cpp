#include "renderer/gpu_scene/materials/scene_materials.h"

#include <utility>

#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/materials/material_features.h"
#include "renderer/gpu_scene/materials/material_records.h"
#include "renderer/gpu_scene/scene_ids.h"

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
    for (const scene::Material& material : added) {
        Use& use = uses.emplace_back();
        for (const uint32_t texture : TexturesOf(material)) use.textures.push_back(textureNumbers[texture]);
        if (!material.baseColorTexture.IsPresent()) continue;
        const auto baseColor = static_cast<size_t>(material.baseColorTexture.texture);
        use.textureAlpha = m_textures->Image(textureNumbers[baseColor]).lowestAlpha;
    }
    numbers.reserve(added.size());
    try {
        for (size_t i = 0; i < added.size(); ++i) numbers.push_back(m_slots.Allocate(1));
        m_records.Grow(m_slots.End());
        m_uses.resize(m_records.Size(), {.exists = false});
    } catch (...) {
        for (const uint32_t number : numbers) m_slots.Free(number, 1);
        throw;
    }
    for (size_t i = 0; i < added.size(); ++i) {
        for (const uint32_t texture : uses[i].textures) ++m_textureUses[texture];
        m_records.Edit(numbers[i]) = records[i];
        m_uses[numbers[i]] = std::move(uses[i]);
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

gpu::MaterialRecord SceneMaterials::Set(uint32_t material, const gpu::MaterialRecord& record) noexcept {
    m_featuresDirty = true;
    return std::exchange(m_records.Edit(material), record);
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

}  // namespace raygraph

#include "renderer/gpu_scene/materials/material_records.h"

#include <algorithm>

#include "renderer/scene/model/material_fields.h"

namespace raygraph {

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
                   (values.BoundsMedium() ? gpu::kMaterialVolume : 0u);
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

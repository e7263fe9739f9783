#include "renderer/gpu_scene/material_records.h"

#include <algorithm>

namespace raygraph {

namespace {

// Until there is a slot, 0 stands for any.
uint32_t TextureSlot(const scene::TextureRef& reference, std::span<const uint32_t> slots) {
    if (!reference.IsPresent()) return gpu::kNoTexture;
    const uint32_t slot = slots.empty() ? 0u : slots[static_cast<size_t>(reference.texture)];
    return slot | (reference.texCoord == 1 ? gpu::kSecondTexCoord : 0u);
}

}  // namespace

gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures) {
    // Names all fields: one that is added to Material does not compile until it is added here, and to the
    // record, or to MaterialRecords if it is a texture
    const auto& [name, baseColorFactor, baseColorTexture, metallicFactor, roughnessFactor,
                 metallicRoughnessTexture, normalTexture, normalScale, occlusionTexture, occlusionStrength,
                 emissiveFactor, emissiveStrength, emissiveTexture, alphaMode, alphaCutoff, isDoubleSided,
                 ior, specularFactor, specularTexture, specularColorFactor, specularColorTexture,
                 transmissionFactor, transmissionTexture, thicknessFactor, attenuationColor,
                 attenuationDistance, isUnlit, clearcoatFactor, clearcoatTexture, clearcoatRoughnessFactor,
                 clearcoatRoughnessTexture, clearcoatNormalTexture, clearcoatNormalScale, sheenColorFactor,
                 sheenColorTexture, sheenRoughnessFactor, sheenRoughnessTexture, anisotropyStrength,
                 anisotropyRotation, anisotropyTexture, iridescenceFactor, iridescenceTexture, iridescenceIor,
                 iridescenceThicknessMinimum, iridescenceThicknessMaximum, iridescenceThicknessTexture,
                 dispersion, diffuseTransmissionFactor, diffuseTransmissionTexture,
                 diffuseTransmissionColorFactor, diffuseTransmissionColorTexture, retroreflectionFactor,
                 retroreflectionTexture, multiscatterColorFactor, scatterAnisotropy, isSpecularGlossiness,
                 priority] = values;
    gpu::MaterialRecord record = textures;
    // Textures that `values` does not name stay as they are
#define RAYGRAPH_TRANSFORM(name) \
    if (name##Texture.IsPresent()) record.name##Transform = name##Texture.transform.Matrix();
    RAYGRAPH_MATERIAL_TEXTURES(RAYGRAPH_TRANSFORM)
#undef RAYGRAPH_TRANSFORM
    record.baseColor = baseColorFactor;
    record.emission = values.EmittedRadiance();
    record.metallic = metallicFactor;
    record.roughness = roughnessFactor;
    record.normalScale = normalScale;
    record.alphaCutoff = alphaCutoff;
    record.alphaMode = static_cast<uint32_t>(alphaMode);
    record.flags = (values.IsBackCulled() ? 0u : gpu::kMaterialTwoSided) |
                   (isUnlit ? gpu::kMaterialUnlit : 0u) | (values.BoundsMedium() ? gpu::kMaterialVolume : 0u);
    if (isSpecularGlossiness && record.specularColorTexture != gpu::kNoTexture)
        record.flags |= gpu::kMaterialGlossiness;
    record.ior = ior > 0.0f ? ior : gpu::kInfiniteIor;
    record.specular = specularFactor;
    record.specularColor = specularColorFactor;
    record.transmission = transmissionFactor;
    record.extinction = values.Extinction();
    record.priority = priority;
    record.clearcoat = isUnlit ? 0.0f : clearcoatFactor;
    record.clearcoatRoughness = clearcoatRoughnessFactor;
    record.clearcoatNormalScale = clearcoatNormalScale;
    record.sheenColor = sheenColorFactor;
    record.sheenRoughness = sheenRoughnessFactor;
    record.anisotropy = anisotropyStrength;
    record.anisotropyRotation = anisotropyRotation;
    record.iridescence = iridescenceFactor;
    record.iridescenceIor = iridescenceIor;
    record.iridescenceThickness = {iridescenceThicknessMinimum, iridescenceThicknessMaximum};
    record.dispersion = dispersion;
    record.diffuseTransmission = diffuseTransmissionFactor;
    record.diffuseTransmissionColor = diffuseTransmissionColorFactor;
    record.retroreflection = retroreflectionFactor;
    record.scattering = values.Scattering();
    record.scatterAnisotropy = scatterAnisotropy;
    record.thickness = thicknessFactor;
    return record;
}

std::vector<uint32_t> TexturesOf(const scene::Material& material) {
    std::vector<uint32_t> textures;
#define RAYGRAPH_ADD(name)                  \
    if (material.name##Texture.IsPresent()) \
        textures.push_back(static_cast<uint32_t>(material.name##Texture.texture));
    RAYGRAPH_MATERIAL_TEXTURES(RAYGRAPH_ADD)
#undef RAYGRAPH_ADD
    std::ranges::sort(textures);
    textures.erase(std::unique(textures.begin(), textures.end()), textures.end());
    return textures;
}

std::vector<gpu::MaterialRecord> MaterialRecords(std::span<const scene::Material> materials,
                                                 std::span<const uint32_t> slots) {
    std::vector<gpu::MaterialRecord> records;
    for (const scene::Material& material : materials) {
        gpu::MaterialRecord fields{};
#define RAYGRAPH_SLOT(name) fields.name##Texture = TextureSlot(material.name##Texture, slots);
        RAYGRAPH_MATERIAL_TEXTURES(RAYGRAPH_SLOT)
#undef RAYGRAPH_SLOT
        records.push_back(ToRecord(material, fields));
    }
    return records;
}

}  // namespace raygraph

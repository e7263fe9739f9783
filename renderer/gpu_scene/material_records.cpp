#include "renderer/gpu_scene/material_records.h"

#include <algorithm>

#include "renderer/scene/fields.h"

namespace raygraph {

namespace {

// Until there is a slot, 0 stands for any.
uint32_t TextureSlot(const scene::TextureRef& reference, std::span<const uint32_t> slots) {
    if (!reference.IsPresent()) return gpu::kNoTexture;
    const uint32_t slot = slots.empty() ? 0u : slots[static_cast<size_t>(reference.texture)];
    return slot | (reference.texCoord == 1 ? gpu::kSecondTexCoord : 0u);
}

// The fields that a record has by their names, and without the "Factor" at their end.
#define RAYGRAPH_MATERIAL_VALUES(X)                                                              \
    X(normalScale), X(alphaCutoff), X(priority), X(clearcoatNormalScale), X(anisotropyRotation), \
        X(iridescenceIor), X(dispersion), X(scatterAnisotropy)
#define RAYGRAPH_MATERIAL_FACTORS(X)                                                                       \
    X(baseColor), X(metallic), X(roughness), X(specular), X(specularColor), X(transmission), X(thickness), \
        X(clearcoat), X(clearcoatRoughness), X(sheenColor), X(sheenRoughness), X(iridescence),             \
        X(diffuseTransmission), X(diffuseTransmissionColor), X(retroreflection)

// One that is added to Material does not compile until it is in a list, or here and in ToRecord.
using M = scene::Material;
#define RAYGRAPH_VALUE(name)   &M::name
#define RAYGRAPH_FACTOR(name)  &M::name##Factor
#define RAYGRAPH_TEXTURE(name) &M::name##Texture,
static_assert(scene::IsEachFieldOf<M>(
    RAYGRAPH_MATERIAL_TEXTURES(RAYGRAPH_TEXTURE) RAYGRAPH_MATERIAL_VALUES(RAYGRAPH_VALUE),
    RAYGRAPH_MATERIAL_FACTORS(RAYGRAPH_FACTOR), &M::emissiveFactor, &M::emissiveStrength, &M::alphaMode,
    &M::isDoubleSided, &M::ior, &M::attenuationColor, &M::attenuationDistance, &M::isUnlit,
    &M::anisotropyStrength, &M::iridescenceThicknessMinimum, &M::iridescenceThicknessMaximum,
    &M::multiscatterColorFactor, &M::isSpecularGlossiness,
    // Not in the record: pictures do not depend on them
    &M::name, &M::occlusionTexture, &M::occlusionStrength));
#undef RAYGRAPH_VALUE
#undef RAYGRAPH_FACTOR
#undef RAYGRAPH_TEXTURE

}  // namespace

gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures) {
    gpu::MaterialRecord record = textures;
    // Textures that `values` does not name stay as they are
#define RAYGRAPH_TRANSFORM(name) \
    if (values.name##Texture.IsPresent()) record.name##Transform = values.name##Texture.transform.Matrix();
    RAYGRAPH_MATERIAL_TEXTURES(RAYGRAPH_TRANSFORM)
#undef RAYGRAPH_TRANSFORM
#define RAYGRAPH_COPY(name) record.name = values.name
    RAYGRAPH_MATERIAL_VALUES(RAYGRAPH_COPY);
#undef RAYGRAPH_COPY
#define RAYGRAPH_COPY(name) record.name = values.name##Factor
    RAYGRAPH_MATERIAL_FACTORS(RAYGRAPH_COPY);
#undef RAYGRAPH_COPY
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
    if (values.isUnlit) record.clearcoat = 0.0f;
    record.anisotropy = values.anisotropyStrength;
    record.iridescenceThickness = {values.iridescenceThicknessMinimum, values.iridescenceThicknessMaximum};
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

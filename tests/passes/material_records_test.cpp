// A material as the device reads it: each number from the field that it is named after.
#include "renderer/gpu_scene/materials/material_records.h"

#include <gtest/gtest.h>

#include <string>
#include <type_traits>

#include "renderer/scene/model/material_fields.h"

namespace raygraph::material_records_test {
namespace {

using scene::Material;

// Numbers that no two fields share.
Material WithDistinctNumbers() {
    Material material;
    float number = 0.0f;
    scene::ForEachMaterialField([&](const auto& field) {
        using Value = typename std::decay_t<decltype(field)>::Value;
        number += 1.0f / 256.0f;
        if constexpr (std::is_same_v<Value, float>)
            material.*field.member = number;
        else if constexpr (std::is_same_v<Value, glm::vec3>)
            material.*field.member = {number, number + 1.0f, number + 2.0f};
        else if constexpr (std::is_same_v<Value, glm::vec4>)
            material.*field.member = {number, number + 1.0f, number + 2.0f, number + 3.0f};
    });
    material.priority = 5;
    return material;
}

TEST(MaterialRecords, HaveEachNumberFromItsField) {
    const Material material = WithDistinctNumbers();
    const gpu::MaterialRecord record = ToRecord(material, {});
    EXPECT_EQ(record.baseColor, material.baseColorFactor);
    EXPECT_EQ(record.emission, material.emissiveFactor * material.emissiveStrength);
    EXPECT_EQ(record.metallic, material.metallicFactor);
    EXPECT_EQ(record.roughness, material.roughnessFactor);
    EXPECT_EQ(record.normalScale, material.normalScale);
    EXPECT_EQ(record.alphaCutoff, material.alphaCutoff);
    EXPECT_EQ(record.ior, material.ior);
    EXPECT_EQ(record.specular, material.specularFactor);
    EXPECT_EQ(record.specularColor, material.specularColorFactor);
    EXPECT_EQ(record.transmission, material.transmissionFactor);
    EXPECT_EQ(record.thickness, material.thicknessFactor);
    EXPECT_EQ(record.extinction, material.Extinction());
    EXPECT_EQ(record.scattering, material.Scattering());
    EXPECT_EQ(record.scatterAnisotropy, material.scatterMeanCosine) << "strength is not 0";
    Material without = material;
    without.scatterStrengthFactor = 0.0f;
    EXPECT_EQ(ToRecord(without, {}).scatterAnisotropy, material.scatterAnisotropy);
    EXPECT_EQ(record.priority, 5u);
    EXPECT_EQ(record.clearcoat, material.clearcoatFactor);
    EXPECT_EQ(record.clearcoatRoughness, material.clearcoatRoughnessFactor);
    EXPECT_EQ(record.clearcoatNormalScale, material.clearcoatNormalScale);
    EXPECT_EQ(record.sheenColor, material.sheenColorFactor);
    EXPECT_EQ(record.sheenRoughness, material.sheenRoughnessFactor);
    EXPECT_EQ(record.anisotropy, material.anisotropyStrength);
    EXPECT_EQ(record.anisotropyRotation, material.anisotropyRotation);
    EXPECT_EQ(record.iridescence, material.iridescenceFactor);
    EXPECT_EQ(record.iridescenceIor, material.iridescenceIor);
    EXPECT_EQ(record.iridescenceThickness.x, material.iridescenceThicknessMinimum);
    EXPECT_EQ(record.iridescenceThickness.y, material.iridescenceThicknessMaximum);
    EXPECT_EQ(record.dispersion, material.dispersion);
    EXPECT_EQ(record.diffuseTransmission, material.diffuseTransmissionFactor);
    EXPECT_EQ(record.diffuseTransmissionColor, material.diffuseTransmissionColorFactor);
    EXPECT_EQ(record.retroreflection, material.retroreflectionFactor);
    EXPECT_EQ(record.scatterStrength, 0.0f) << "it bounds a medium";
}

TEST(MaterialRecords, SheetsScatterByOneExtension) {
    Material material = WithDistinctNumbers();
    material.thicknessFactor = 0.0f;
    const gpu::MaterialRecord sheet = ToRecord(material, {});
    EXPECT_EQ(sheet.scatterStrength, material.scatterStrengthFactor);
    EXPECT_EQ(sheet.diffuseTransmission, 0.0f);
    material.transmissionFactor = 0.0f;
    const gpu::MaterialRecord leaf = ToRecord(material, {});
    EXPECT_EQ(leaf.scatterStrength, 0.0f) << "there is nothing to scatter";
    EXPECT_EQ(leaf.diffuseTransmission, material.diffuseTransmissionFactor);
}

TEST(MaterialRecords, UnlitOnesHaveNoCoatAndNoEmission) {
    Material material = WithDistinctNumbers();
    material.isUnlit = true;
    const gpu::MaterialRecord record = ToRecord(material, {});
    EXPECT_EQ(record.clearcoat, 0.0f);
    EXPECT_EQ(record.emission, glm::vec3(0.0f));
    EXPECT_NE(record.flags & gpu::kMaterialUnlit, 0u);
}

TEST(MaterialRecords, HaveATransformOfEachTexture) {
    Material material;
    float turn = 0.0f;
    scene::ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), scene::TextureRef Material::*>)
            material.*field.member = {.texture = 0, .texCoord = 0, .transform = {.rotation = turn += 0.125f}};
    });
    const gpu::MaterialRecord record = ToRecord(material, {});
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) \
    EXPECT_EQ(record.name##Transform, material.name##Texture.transform.Matrix());
#include "shaders/shared/material_list.h"
}

}  // namespace
}  // namespace raygraph::material_records_test

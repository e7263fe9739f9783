// Tests how the inspector shows fields of materials and lights, and which values edits give them.
#include "editor/app/scene_panels.h"

#include <gtest/gtest.h>

#include <vector>

#include "renderer/scene/model/scene_fields.h"

namespace raygraph::editor::inspector_fields_test {

using scene::FieldOf;
using scene::Light;
using scene::LightType;
using scene::Material;

namespace {

template <typename Field>
NumberStyle Style(float value, const Field& field) {
    return StyleOf(value, field.range, field.unit, field.ZeroIsInfinite());
}

}  // namespace

TEST(InspectorFields, LabelsAreWords) {
    EXPECT_EQ(LabelOf("baseColorFactor"), "base color");
    EXPECT_EQ(LabelOf("isDoubleSided"), "double sided");
    EXPECT_EQ(LabelOf("alphaMode"), "alpha");
}

TEST(InspectorFields, SpecularColorMayBeAboveOne) {
    const auto range = FieldOf(&Material::specularColorFactor).range;
    EXPECT_EQ(Bounded(glm::vec3(1.0f), glm::vec3(2.5f, 1.0f, -1.0f), range), glm::vec3(2.5f, 1.0f, 0.0f));
}

TEST(InspectorFields, ColorsBesideAStrengthGoToOneAndKeepWhatAFileHas) {
    for (const scene::FieldRange& range :
         {FieldOf(&Material::emissiveFactor).range, FieldOf(&Light::color).range}) {
        EXPECT_EQ(Bounded(glm::vec3(0.5f), glm::vec3(2.5f, 1.0f, -1.0f), range), glm::vec3(1.0f, 1.0f, 0.0f));
        EXPECT_EQ(Bounded(glm::vec3(3.0f, 0.5f, 0.5f), glm::vec3(3.0f, 2.0f, 0.25f), range),
                  glm::vec3(3.0f, 1.0f, 0.25f));
    }
}

TEST(InspectorFields, SharesStayBelowOne) {
    const auto range = FieldOf(&Material::baseColorFactor).range;
    EXPECT_EQ(Bounded(glm::vec4(1.0f), glm::vec4(2.0f, 0.5f, -1.0f, 1.0f), range),
              glm::vec4(1.0f, 0.5f, 0.0f, 1.0f));
    EXPECT_TRUE(Style(0.5f, FieldOf(&Material::metallicFactor)).isSlider);
    EXPECT_FALSE(Style(0.0f, FieldOf(&Material::metallicFactor)).isInfinite);
}

// A number that scales a texture has an effect if the material has the texture, wherever glTF stores it.
TEST(InspectorFields, ScalesOfTexturesCountWhereTheTextureIs) {
    const auto counts = [](const Material& material, const auto& field) {
        return Counts(material, field.object, field.key, field.name);
    };
    const auto expectWith = [&](const auto& field, scene::TextureRef Material::*texture) {
        Material material;
        for (scene::TextureRef Material::*other :
             {&Material::normalTexture, &Material::occlusionTexture, &Material::clearcoatNormalTexture})
            if (other != texture) (material.*other).texture = 0;
        EXPECT_FALSE(counts(material, field)) << field.name;
        (material.*texture).texture = 0;
        EXPECT_TRUE(counts(material, field)) << field.name;
    };
    expectWith(FieldOf(&Material::normalScale), &Material::normalTexture);
    expectWith(FieldOf(&Material::occlusionStrength), &Material::occlusionTexture);
    expectWith(FieldOf(&Material::clearcoatNormalScale), &Material::clearcoatNormalTexture);
    EXPECT_TRUE(counts(Material(), FieldOf(&Material::clearcoatFactor)));
    EXPECT_TRUE(counts(Material(), FieldOf(&Material::baseColorFactor)));
    EXPECT_FALSE(counts(Material(), FieldOf(&Material::attenuationDistance)));
}

TEST(InspectorFields, InfinityIsShownAsAWordAndNotAsZero) {
    const auto expectInfinite = [](const auto& field, const char* finiteFormat) {
        const NumberStyle infinite = Style(0.0f, field);
        EXPECT_TRUE(infinite.isInfinite) << field.name;
        EXPECT_EQ(infinite.format, "infinite");
        const NumberStyle finite = Style(2.0f, field);
        EXPECT_FALSE(finite.isInfinite);
        EXPECT_EQ(finite.format, finiteFormat);
        EXPECT_GT(finite.min, 0.0f) << "dragging does not end there";
    };
    expectInfinite(FieldOf(&Material::ior), "%.3f");
    expectInfinite(FieldOf(&Material::attenuationDistance), "%.3f m");
    expectInfinite(FieldOf(&Light::range), "%.3f m");
    EXPECT_EQ(Style(1.5f, FieldOf(&Material::ior)).min, 1.0f);
    EXPECT_EQ(Style(0.0f, FieldOf(&Material::thicknessFactor)).format, "%.3f m") << "a zero that is one";
    EXPECT_EQ(Style(0.0f, FieldOf(&Light::intensity)).format, "%.3f cd");
}

TEST(InspectorFields, WhatIsInfiniteNoMoreHasAValueThatItMayHave) {
    EXPECT_EQ(FiniteValue(FieldOf(&Material::ior)), 1.5f);
    EXPECT_EQ(FiniteValue(FieldOf(&Material::attenuationDistance)), 1.0f);
    EXPECT_EQ(FiniteValue(FieldOf(&Light::range)), 1.0f);
}

TEST(InspectorFields, AnglesAreShownInDegrees) {
    const NumberStyle style = Style(0.5f, FieldOf(&Light::outerConeAngle));
    EXPECT_TRUE(style.isAngle);
    EXPECT_EQ(style.format, "%.1f deg");
}

TEST(InspectorFields, EachKindOfLightShowsWhatItHas) {
    const auto fieldsOf = [](LightType type) {
        std::vector<std::string> names;
        scene::ForEachLightField(type, [&](const auto& field) { names.push_back(field.name); });
        return names;
    };
    using Names = std::vector<std::string>;
    EXPECT_EQ(fieldsOf(LightType::Directional), (Names{"color", "intensity"}));
    EXPECT_EQ(fieldsOf(LightType::Point), (Names{"color", "intensity", "range"}));
    EXPECT_EQ(fieldsOf(LightType::Spot),
              (Names{"color", "intensity", "range", "innerConeAngle", "outerConeAngle"}));
}

}  // namespace raygraph::editor::inspector_fields_test

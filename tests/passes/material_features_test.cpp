// What a material needs of pipelines: a feature too few leaves a lobe out of the picture.
#include "renderer/gpu_scene/materials/material_features.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "renderer/gpu_scene/deform/deform_resources.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/instances/group_kinds.h"
#include "renderer/gpu_scene/materials/material_records.h"
#include "shaders/shared/trace_options.h"

namespace raygraph::material_features_test {
namespace {

using scene::Material;

TraceFeatures FeaturesOf(const std::vector<Material>& materials) {
    SceneGeometry geometry;
    for (uint32_t i = 0; i < materials.size(); ++i)
        geometry.groups.emplace_back().parts.push_back({.material = i});
    return MaterialFeatures(MaterialRecords(materials, {}), 0, geometry);
}

// Rough plastic, but for what `change` makes of it.
TraceFeatures FeaturesWith(const std::function<void(Material&)>& change) {
    Material material;
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.5f;
    change(material);
    return FeaturesOf({material});
}

constexpr scene::TextureRef kSomeTexture{.texture = 0};

TEST(MaterialFeatures, AreThoseOfTheLobesThatAMaterialMayHave) {
    struct Row {
        const char* what;
        std::function<void(Material&)> change;
        TraceFeatures features;
    };
    const auto smoothCoat = [](Material& m) {
        m.clearcoatFactor = 0.5f;
        m.clearcoatRoughnessFactor = 0.0f;
    };
    const auto film = [](Material& m) {
        m.iridescenceFactor = 0.5f;
        m.iridescenceThicknessMinimum = 100.0f;
        m.iridescenceThicknessMaximum = 400.0f;
    };
    const Row rows[] = {
        {"plastic", [](Material&) {}, kTraceOpaque},
        {"unlit", [](Material& m) { m.isUnlit = true; }, 0},
        {"metal", [](Material& m) { m.metallicFactor = 1.0f; }, kTraceMetals},
        {"half metal", [](Material& m) { m.metallicFactor = 0.5f; }, kTraceMetals | kTraceOpaque},
        {"metal by a texture, which may say that it is rough or smooth",
         [](Material& m) {
             m.metallicFactor = 1.0f;
             m.metallicRoughnessTexture = kSomeTexture;
         },
         kTraceMetals | kTraceOpaque | kTraceSmooth},
        {"smooth", [](Material& m) { m.roughnessFactor = 0.0f; }, kTraceOpaque | kTraceSmooth},
        {"glass", [](Material& m) { m.transmissionFactor = 1.0f; }, kTraceGlass},
        {"half glass", [](Material& m) { m.transmissionFactor = 0.5f; }, kTraceGlass | kTraceOpaque},
        {"glass by a texture",
         [](Material& m) {
             m.transmissionFactor = 1.0f;
             m.transmissionTexture = kSomeTexture;
         },
         kTraceGlass | kTraceOpaque},
        {"metal, whose transmission is nothing",
         [](Material& m) { m.metallicFactor = m.transmissionFactor = 1.0f; }, kTraceMetals},
        {"rough coat", [](Material& m) { m.clearcoatFactor = m.clearcoatRoughnessFactor = 0.5f; },
         kTraceOpaque | kTraceClearcoat},
        {"smooth coat", smoothCoat, kTraceOpaque | kTraceClearcoat | kTraceSmooth},
        {"coat whose roughness a texture scales down",
         [](Material& m) {
             m.clearcoatFactor = m.clearcoatRoughnessFactor = 0.5f;
             m.clearcoatRoughnessTexture = kSomeTexture;
         },
         kTraceOpaque | kTraceClearcoat | kTraceSmooth},
        {"sheen", [](Material& m) { m.sheenColorFactor.y = 0.1f; }, kTraceOpaque | kTraceSheen},
        {"film", film, kTraceOpaque | kTraceIridescence},
        {"film on metal",
         [&](Material& m) {
             film(m);
             m.metallicFactor = 1.0f;
         },
         kTraceMetals | kTraceIridescence},
        {"film without thickness",
         [&](Material& m) {
             film(m);
             m.iridescenceThicknessMaximum = 0.0f;
         },
         kTraceOpaque},
        {"film as thick as a texture says",
         [&](Material& m) {
             film(m);
             m.iridescenceThicknessMaximum = 0.0f;
             m.iridescenceThicknessTexture = kSomeTexture;
         },
         kTraceOpaque | kTraceIridescence},
        {"stretched highlights", [](Material& m) { m.anisotropyStrength = 0.1f; },
         kTraceOpaque | kTraceAnisotropy},
        {"leaf", [](Material& m) { m.diffuseTransmissionFactor = 0.1f; },
         kTraceOpaque | kTraceDiffuseTransmission},
        {"leaf of metal",
         [](Material& m) {
             m.metallicFactor = 1.0f;
             m.diffuseTransmissionFactor = 0.1f;
         },
         kTraceMetals},
        {"sheet that scatters a part",
         [](Material& m) {
             m.transmissionFactor = 1.0f;
             m.scatterStrengthFactor = 0.5f;
         },
         kTraceGlass | kTraceOpaque | kTraceThinScatter | kTraceDiffuseTransmission},
        {"sheet that scatters all",
         [](Material& m) { m.transmissionFactor = m.scatterStrengthFactor = 1.0f; },
         kTraceOpaque | kTraceThinScatter | kTraceDiffuseTransmission},
        {"sheet that scatters as much as a texture says",
         [](Material& m) {
             m.transmissionFactor = m.scatterStrengthFactor = 1.0f;
             m.scatterStrengthTexture = kSomeTexture;
         },
         kTraceGlass | kTraceOpaque | kTraceThinScatter | kTraceDiffuseTransmission},
        {"sheet that has nothing to scatter", [](Material& m) { m.scatterStrengthFactor = 1.0f; },
         kTraceOpaque},
        {"retroreflector", [](Material& m) { m.retroreflectionFactor = 0.1f; },
         kTraceOpaque | kTraceRetroreflection},
        {"dispersion without a medium", [](Material& m) { m.dispersion = 1.0f; }, kTraceOpaque},
    };
    for (const Row& row : rows) EXPECT_EQ(FeaturesWith(row.change), row.features) << row.what;
}

TEST(GroupKinds, SheetThatScattersAllIsNoThinWall) {
    Material sheet;
    sheet.metallicFactor = sheet.roughnessFactor = 0.0f;
    sheet.transmissionFactor = 1.0f;
    const auto isThinWall = [&] {
        const GroupPart part;
        return KindOf({&part, 1}, MaterialRecords({&sheet, 1}, {})).isThinWall;
    };
    EXPECT_TRUE(isThinWall());
    sheet.scatterStrengthFactor = 0.5f;
    EXPECT_TRUE(isThinWall());
    sheet.scatterStrengthFactor = 1.0f;
    EXPECT_FALSE(isThinWall());
    sheet.scatterStrengthTexture = kSomeTexture;
    EXPECT_TRUE(isThinWall());
}

TEST(MaterialFeatures, OfASceneAreThoseOfAllItsMaterials) {
    Material metal, glass;
    metal.metallicFactor = metal.roughnessFactor = 1.0f;
    glass.metallicFactor = 0.0f;
    glass.roughnessFactor = 1.0f;
    glass.transmissionFactor = 1.0f;
    EXPECT_EQ(FeaturesOf({metal, glass}), kTraceMetals | kTraceGlass);
    EXPECT_EQ(FeaturesOf({}), TraceFeatures{});
}

Material Medium(float ior, bool isEntered, bool scatters) {
    Material medium;
    medium.thicknessFactor = 1.0f;
    medium.metallicFactor = 0.0f;
    medium.roughnessFactor = 1.0f;
    medium.ior = ior;
    (isEntered ? medium.transmissionFactor : medium.diffuseTransmissionFactor) = 1.0f;
    if (scatters) medium.multiscatterColorFactor = glm::vec3(0.5f);
    if (scatters) medium.attenuationColor = glm::vec3(0.5f);
    if (scatters) medium.attenuationDistance = 1.0f;
    return medium;
}

TEST(MaterialFeatures, LightPassesStraightIntoAirAndBetweenMediaOfOneIndexThatScatter) {
    struct Row {
        const char* what;
        std::vector<Material> media;
        bool isMatched;
    };
    const Row rows[] = {
        {"glass", {Medium(1.5f, true, false)}, false},
        {"fog", {Medium(1.0f, true, true)}, true},
        {"air that nothing enters", {Medium(1.0f, false, true)}, false},
        {"milk", {Medium(1.33f, true, true)}, false},
        {"milk in water", {Medium(1.33f, true, false), Medium(1.33f, true, true)}, true},
        {"milk beside what nothing enters", {Medium(1.33f, true, true), Medium(1.33f, false, false)}, true},
        {"milk that nothing enters in water", {Medium(1.33f, false, true), Medium(1.33f, true, false)}, true},
        {"milk in glass", {Medium(1.5f, true, false), Medium(1.33f, true, true)}, false},
        {"two of glass", {Medium(1.5f, true, false), Medium(1.5f, true, false)}, false},
        {"none entered", {Medium(1.33f, false, true), Medium(1.33f, false, true)}, false},
        {"the last pair of many",
         {Medium(1.1f, true, true), Medium(1.5f, true, false), Medium(1.2f, true, true),
          Medium(1.3f, true, false), Medium(1.5f, true, true)},
         true},
    };
    for (const Row& row : rows)
        EXPECT_EQ(FeaturesOf(row.media).Has(kTraceMatchedMedia), row.isMatched) << row.what;
}

}  // namespace
}  // namespace raygraph::material_features_test

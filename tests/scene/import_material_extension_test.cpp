#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/scene/gltf_document.h"
#include "tests/support/h_function.h"

namespace raygraph::test::import_material_extension_test {
namespace {

using glm::vec3;

GltfDocument WithMaterial(const Json& material) {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial(material);
    return document;
}

scene::SceneData LoadExtensions(const Json& extensions) {
    return Load(WithMaterial({{"extensions", extensions}}));
}

scene::Material MaterialWith(const Json& extensions) {
    const scene::SceneData scene = LoadExtensions(extensions);
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    return scene.materials.at(0);
}

void AddTexture(GltfDocument& document, uint32_t width) {
    const size_t image = document.Add("images", {{"uri", DataUri(MakePng(width, 1, {1, 2, 3, 4}))}});
    document.Add("textures", {{"source", image}});
}

// Every property of every material extension, each with a value of its own; textures 0 to 3.
Json AllExtensions() {
    return R"({
        "KHR_materials_emissive_strength": {"emissiveStrength": 7},
        "KHR_materials_ior": {"ior": 1.25},
        "KHR_materials_specular": {"specularFactor": 0.75, "specularTexture": {"index": 0},
                                   "specularColorFactor": [0.5, 1.5, 2],
                                   "specularColorTexture": {"index": 1, "texCoord": 1}},
        "KHR_materials_transmission": {"transmissionFactor": 0.25, "transmissionTexture": {"index": 2}},
        "KHR_materials_volume": {"thicknessFactor": 0.5, "thicknessTexture": {"index": 3},
                                 "attenuationDistance": 2, "attenuationColor": [0.125, 0.25, 0.5]},
        "KHR_materials_unlit": {}
    })"_json;
}

GltfDocument WithAllExtensions() {
    GltfDocument document = WithMaterial({{"extensions", AllExtensions()}});
    for (uint32_t width = 1; width <= 4; ++width) AddTexture(document, width);
    return document;
}

TEST(MaterialExtensions, ValuesAreRead) {
    const scene::SceneData scene = Load(WithAllExtensions());
    EXPECT_TRUE(scene.warnings.empty());
    const scene::Material& material = scene.materials.at(0);
    EXPECT_EQ(material.emissiveStrength, 7.0f);
    EXPECT_EQ(material.ior, 1.25f);
    EXPECT_EQ(material.specularFactor, 0.75f);
    EXPECT_EQ(material.specularColorFactor, vec3(0.5f, 1.5f, 2.0f)) << "not bounded by 1";
    EXPECT_EQ(material.transmissionFactor, 0.25f);
    EXPECT_EQ(material.thicknessFactor, 0.5f);
    EXPECT_EQ(material.attenuationDistance, 2.0f);
    EXPECT_EQ(material.attenuationColor, vec3(0.125f, 0.25f, 0.5f));
    EXPECT_TRUE(material.isUnlit);

    const auto texture = [&](const scene::TextureRef& ref) {
        return scene.textures.at(static_cast<size_t>(ref.texture));
    };
    EXPECT_EQ(scene.images.at(texture(material.specularTexture).image).width, 1u);
    EXPECT_EQ(scene.images.at(texture(material.specularColorTexture).image).width, 2u);
    EXPECT_EQ(scene.images.at(texture(material.transmissionTexture).image).width, 3u);
    EXPECT_EQ(texture(material.specularTexture).colorSpace, scene::ColorSpace::Linear);
    EXPECT_EQ(texture(material.specularColorTexture).colorSpace, scene::ColorSpace::Srgb);
    EXPECT_EQ(texture(material.transmissionTexture).colorSpace, scene::ColorSpace::Linear);
    EXPECT_EQ(material.specularColorTexture.texCoord, 1);
}

TEST(MaterialExtensions, ThicknessTextureIsNotOpened) {
    EXPECT_EQ(Load(WithAllExtensions()).images.size(), 3u);
    GltfDocument document = WithAllExtensions();
    document.json["materials"][0]["extensions"]["KHR_materials_volume"]["thicknessTexture"]["index"] = 9;
    EXPECT_EQ(LoadError(document), "loaded");
}

TEST(MaterialExtensions, TextureOfAMediumIsCheckedAndNotReadWithAWarning) {
    GltfDocument document = WithMaterial(
        {{"extensions",
          {{"KHR_materials_volume_scatter",
            {{"multiscatterColorFactor", {0.5, 0.5, 0.5}}, {"multiscatterColorTexture", {{"index", 0}}}}}}}});
    EXPECT_THAT(LoadError(document), ::testing::HasSubstr("multiscatterColorTexture.index: is 0, but"));
    AddTexture(document, 2);
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.textures.empty());
    EXPECT_THAT(
        scene.warnings,
        ::testing::ElementsAre(::testing::HasSubstr("volume_scatter.multiscatterColorTexture: is not read")));
}

TEST(MaterialExtensions, AbsentAndEmptyOnesMeanTheDefaults) {
    const Json empty = R"({"KHR_materials_ior": {}, "KHR_materials_specular": {},
                           "KHR_materials_transmission": {}, "KHR_materials_volume": {}})"_json;
    for (const Json& extensions : {Json::object(), empty}) {
        const scene::Material material = MaterialWith(extensions);
        EXPECT_EQ(material.ior, 1.5f);
        EXPECT_EQ(material.specularFactor, 1.0f);
        EXPECT_EQ(material.specularColorFactor, vec3(1.0f));
        EXPECT_FALSE(material.specularTexture.IsPresent());
        EXPECT_FALSE(material.specularColorTexture.IsPresent());
        EXPECT_EQ(material.transmissionFactor, 0.0f);
        EXPECT_FALSE(material.transmissionTexture.IsPresent());
        EXPECT_FALSE(material.IsTransmissive());
        EXPECT_FALSE(material.BoundsMedium());
        EXPECT_EQ(material.Extinction(), vec3(0.0f));
        EXPECT_FALSE(material.isUnlit);
        EXPECT_EQ(material.priority, 0u);
    }
}

TEST(MaterialExtensions, AreAcceptedWhenTheFileRequiresThem) {
    GltfDocument document = WithAllExtensions();
    const Json extensions = AllExtensions();
    for (const auto& entry : extensions.items()) {
        document.json["extensionsRequired"].push_back(entry.key());
        document.json["extensionsUsed"].push_back(entry.key());
    }
    EXPECT_TRUE(Load(document).warnings.empty());
}

TEST(MaterialExtensions, MalformedOnesAreRefused) {
    const struct {
        const char* extension;
        Json value;
        const char* message;
    } rows[] = {
        {"ior", 1.5, ": is 1.5, must be an object"},
        {"ior", {{"ior", "glass"}}, ".ior: is \"glass\", must be a number"},
        {"specular",
         {{"specularColorFactor", {1e60, 1, 1}}},
         ".specularColorFactor[0]: is 1e+60, too large for a float"},
        {"specular", {{"specularFactor", nullptr}}, ".specularFactor: is null, must be a number"},
        {"specular", {{"specularColorFactor", {1, 1}}}, ".specularColorFactor: has 2 elements, must have 3"},
        {"specular",
         {{"specularTexture", {{"index", 0}}}},
         ".specularTexture.index: is 0, but there are 0 textures"},
        {"specular",
         {{"specularColorTexture", {{"index", -1}}}},
         ".specularColorTexture.index: is -1, must be a whole number of at least 0"},
        {"transmission", {{"transmissionFactor", true}}, ".transmissionFactor: is true, must be a number"},
        {"transmission",
         {{"transmissionTexture", Json::object()}},
         ".transmissionTexture.index: is absent, must be a whole number of at least 0"},
        {"volume", {{"thicknessFactor", "1"}}, ".thicknessFactor: is \"1\", must be a number"},
        {"volume", {{"attenuationColor", "red"}}, ".attenuationColor: is \"red\", must be an array"},
        {"volume",
         {{"attenuationDistance", Json::array()}},
         ".attenuationDistance: is an array, must be a number"},
        {"unlit", true, ": is true, must be an object"},
    };
    for (const auto& [extension, value, message] : rows) {
        const std::string name = std::string("KHR_materials_") + extension;
        EXPECT_EQ(LoadError(WithMaterial({{"extensions", {{name, value}}}})),
                  "scene.gltf: materials[0].extensions." + name + message);
    }
}

TEST(MaterialExtensions, FactorsOutOfRangeAreClampedWithAWarning) {
    const auto clamped = [](const char* extension, const Json& value) {
        const scene::SceneData scene = LoadExtensions({{extension, value}});
        EXPECT_EQ(scene.warnings.size(), 1u) << value;
        return scene.materials.at(0);
    };
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", 0.5}}).ior, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", -2}}).ior, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", 1e30}}).ior, 1e4f);
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", 1e60}}).ior, 1e4f);
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", -1e60}}).ior, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_specular", {{"specularFactor", 2}}).specularFactor, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_specular", {{"specularColorFactor", {-1, 1, 3}}}).specularColorFactor,
              vec3(0, 1, 3));
    EXPECT_EQ(clamped("KHR_materials_transmission", {{"transmissionFactor", 1.5}}).transmissionFactor, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_volume", {{"thicknessFactor", -1}}).thicknessFactor, 0.0f);
    EXPECT_EQ(clamped("KHR_materials_volume", {{"attenuationColor", {0.5, 2, -1}}}).attenuationColor,
              vec3(0.5f, 1.0f, 0.0f));
    EXPECT_EQ(clamped("KHR_materials_volume", {{"attenuationDistance", 0}}).attenuationDistance, 0.0f);
    EXPECT_EQ(clamped("KHR_materials_volume", {{"attenuationDistance", -3}}).attenuationDistance, 0.0f);
}

// Exporters write these values for infinity, which JSON does not have.
TEST(MaterialExtensions, InfiniteDistanceIsNullOrTheLargestDouble) {
    for (const Json& infinite : {Json(nullptr), Json(std::numeric_limits<double>::max())}) {
        const scene::SceneData scene = LoadExtensions(
            {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
             {"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", infinite}}}});
        EXPECT_EQ(scene.materials.at(0).attenuationDistance, 0.0f) << infinite;
        EXPECT_EQ(scene.materials.at(0).thicknessFactor, 1.0f) << infinite;
        ASSERT_EQ(scene.warnings.size(), 1u) << infinite;
        EXPECT_THAT(scene.warnings[0], ::testing::HasSubstr("taken as infinite")) << infinite;
    }
}

TEST(MaterialExtensions, IorZeroIsLegal) {
    EXPECT_EQ(MaterialWith({{"KHR_materials_ior", {{"ior", 0}}}}).ior, 0.0f);
}

TEST(MaterialExtensions, MediumTurnsWhiteIntoItsColorOverItsDistance) {
    const scene::Material material = MaterialWith(
        {{"KHR_materials_volume",
          {{"thicknessFactor", 1}, {"attenuationColor", {0.25, 1, 0.5}}, {"attenuationDistance", 0.1}}}});
    const vec3 passed = glm::exp(-material.Extinction() * 0.1f);
    EXPECT_NEAR(passed.x, 0.25f, 1e-6f);
    EXPECT_EQ(passed.y, 1.0f);
    EXPECT_NEAR(passed.z, 0.5f, 1e-6f);
}

TEST(MaterialExtensions, AbsorptionIsFiniteWhateverTheColorAndDistance) {
    scene::Material material;
    material.attenuationColor = vec3(0.0f, 1e-45f, 1.0f);
    for (const float distance : {1e-45f, 1e-30f, 1.0f, 1e38f}) {
        material.attenuationDistance = distance;
        const vec3 extinction = material.Extinction();
        EXPECT_EQ(extinction.x, scene::Material::kMaxExtinction) << "color 0 is black over any distance";
        EXPECT_TRUE(std::isfinite(extinction.y));
        EXPECT_EQ(extinction.z, 0.0f);
    }
    material.attenuationDistance = 0.0f;
    EXPECT_EQ(material.Extinction(), vec3(0.0f)) << "an infinite distance attenuates nothing";
}

TEST(MaterialExtensions, UnlitMaterialsHaveNoEmissionOfTheirOwn) {
    scene::Material material;
    material.emissiveFactor = vec3(1.0f);
    EXPECT_EQ(material.EmittedRadiance(), vec3(1.0f));
    material.isUnlit = true;
    EXPECT_EQ(material.EmittedRadiance(), vec3(0.0f));
}

TEST(MaterialExtensions, OnlySingleSidedSurfacesThatNoLightPassesAreCulled) {
    scene::Material material;
    EXPECT_TRUE(material.IsBackCulled());
    for (const scene::AlphaMode mode : {scene::AlphaMode::Mask, scene::AlphaMode::Blend}) {
        material.alphaMode = mode;
        EXPECT_TRUE(material.IsBackCulled());
    }
    material.isDoubleSided = true;
    EXPECT_FALSE(material.IsBackCulled());
    material = {};
    material.transmissionFactor = 0.5f;
    EXPECT_FALSE(material.IsBackCulled());
    material = {};
    material.thicknessFactor = 0.5f;
    EXPECT_TRUE(material.IsBackCulled()) << "a volume that no light enters";
    material.transmissionFactor = 0.5f;
    EXPECT_FALSE(material.IsBackCulled());
    material.transmissionFactor = 0.0f;
    EXPECT_FALSE(material.BoundsMedium());
    material.diffuseTransmissionFactor = 0.5f;
    EXPECT_FALSE(material.IsBackCulled()) << "light passes diffusely";
    EXPECT_TRUE(material.BoundsMedium());
    material.thicknessFactor = 0.0f;
    EXPECT_FALSE(material.IsBackCulled());
    EXPECT_FALSE(material.BoundsMedium());
}

TEST(MaterialPriority, IsReadFromExtras) {
    const scene::SceneData scene = Load(WithMaterial({{"extras", {{"priority", 7}, {"author", "x"}}}}));
    EXPECT_EQ(scene.materials.at(0).priority, 7u);
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(MaterialPriority, WhatOthersPutIntoExtrasRefusesNoFile) {
    for (const Json& extras : {Json(3), Json("priority"), Json::array({1}), Json(nullptr), Json::object()}) {
        const scene::SceneData scene = Load(WithMaterial({{"extras", extras}}));
        EXPECT_EQ(scene.materials.at(0).priority, 0u);
        EXPECT_TRUE(scene.warnings.empty()) << extras;
    }
    for (const Json& priority : {Json(-1), Json(0.5), Json("high"), Json(4294967296u), Json(1e300)}) {
        const scene::SceneData scene = Load(WithMaterial({{"extras", {{"priority", priority}}}}));
        EXPECT_EQ(scene.materials.at(0).priority, 0u);
        EXPECT_EQ(scene.warnings,
                  std::vector<std::string>{"scene.gltf: materials[0].extras.priority: is " +
                                           (priority.is_string() ? "\"high\"" : priority.dump()) +
                                           ", must be a whole number of 0 to 4294967295, taken as 0"});
    }
}

// The color that a file gives is about what a half space of the medium returns of light from all sides.
TEST(MaterialExtensions, MultiscatterColorIsTheAlbedoOfAHalfSpace) {
    const auto albedoOf = [](float color, float anisotropy) {
        const Json volume = {
            {"thicknessFactor", 1}, {"attenuationDistance", 2}, {"attenuationColor", {0.5, 0.5, 0.5}}};
        const scene::Material material = MaterialWith(
            {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
             {"KHR_materials_volume", volume},
             {"KHR_materials_volume_scatter",
              {{"multiscatterColorFactor", {color, 0, color}}, {"scatterAnisotropy", anisotropy}}}});
        EXPECT_EQ(material.Scattering().y, 0.0f);
        return double{material.Scattering().x} / double{material.Extinction().x};
    };
    for (const float color : {0.05f, 0.2f, 0.5f, 0.8f, 0.95f}) {
        const double albedo = albedoOf(color, 0.0f);
        EXPECT_NEAR(raygraph::testing::HFunction(albedo).ReflectedToAll(), color, 0.02) << color;
        // By similarity, a medium of mean cosine g with 1 / (1 - g) times the scattering coefficient looks
        // the same
        const double forward = albedoOf(color, 0.75f);
        EXPECT_NEAR(forward * 0.25 / (1.0 - 0.75 * forward), albedo, 1e-3) << color;
    }
    EXPECT_NEAR(albedoOf(1.0f, 0.0f), 1.0, 1e-4);
}

}  // namespace
}  // namespace raygraph::test::import_material_extension_test

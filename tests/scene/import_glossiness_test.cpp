// KHR_materials_pbrSpecularGlossiness: what it stands for, and where its values are saved.
#include <gtest/gtest.h>

#include <cmath>

#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/scene/gltf_document.h"
#include "tests/scene/same_scene.h"
#include "tests/support/error_of.h"

namespace raygraph::test::import_glossiness_test {
namespace {

using scene::Material, scene::SceneData;

constexpr const char* kExtension = "KHR_materials_pbrSpecularGlossiness";

// A triangle of one material, of which this is the extension.
GltfDocument Glossy(const Json& extension) {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial({{"extensions", {{kExtension, extension}}}});
    return document;
}

// Makes a document with the extension's two textures, and two of pbrMetallicRoughness.
GltfDocument Textured() {
    GltfDocument document = Glossy(
        {{"diffuseTexture", {{"index", 0}}}, {"specularGlossinessTexture", {{"index", 1}, {"texCoord", 1}}}});
    for (uint32_t i = 0; i < 4; ++i) {
        document.Add("images", {{"uri", DataUri(MakePng(i + 1, 1, {1, 2, 3, 4}))}});
        document.Add("textures", {{"source", i}});
    }
    document.json["materials"][0]["pbrMetallicRoughness"] = {{"baseColorFactor", {0.1, 0.1, 0.1, 0.1}},
                                                             {"metallicFactor", 0.75},
                                                             {"roughnessFactor", 0.75},
                                                             {"baseColorTexture", {{"index", 2}}},
                                                             {"metallicRoughnessTexture", {{"index", 3}}}};
    return document;
}

Json Saved(const GltfDocument& document, const SceneData& edited, SceneData& saved) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", document.Text());
    const std::filesystem::path target = folder.Path() / "saved.gltf";
    scene::SaveGltf(source, edited, target);
    saved = scene::LoadGltf(target);
    const Bytes text = folder.Read(target, 1 << 20);
    const auto* begin = reinterpret_cast<const char*>(text.data());
    return Json::parse(begin, begin + text.size());
}

TEST(Glossiness, FactorsAreThoseOfTheSameMaterialSaidOtherwise) {
    const SceneData scene = Load(Glossy({{"diffuseFactor", {0.1, 0.2, 0.3, 0.4}},
                                         {"specularFactor", {0.5, 0.6, 0.7}},
                                         {"glossinessFactor", 0.75}}));
    EXPECT_TRUE(scene.warnings.empty());
    const Material& read = scene.materials.at(0);
    EXPECT_TRUE(read.isSpecularGlossiness);
    EXPECT_EQ(read.baseColorFactor, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
    EXPECT_EQ(read.specularColorFactor, glm::vec3(0.5f, 0.6f, 0.7f));
    EXPECT_EQ(read.roughnessFactor, 0.25f);
    EXPECT_EQ(read.metallicFactor, 0.0f);
    EXPECT_EQ(read.ior, 0.0f) << "it reflects all of the specular color";
    EXPECT_EQ(read.specularFactor, 1.0f);
    // The extension's defaults: white, and as smooth as can be
    const Material bare = Load(Glossy(Json::object())).materials.at(0);
    EXPECT_EQ(bare.baseColorFactor, glm::vec4(1.0f));
    EXPECT_EQ(bare.specularColorFactor, glm::vec3(1.0f));
    EXPECT_EQ(bare.roughnessFactor, 0.0f);
    EXPECT_FALSE(Material().isSpecularGlossiness);
}

TEST(Glossiness, CountsBeforeAllElseThatSaysTheSame) {
    GltfDocument document = Textured();
    SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty()) << "files have pbrMetallicRoughness for readers without";
    const Material& read = scene.materials.at(0);
    EXPECT_EQ(read.baseColorFactor, glm::vec4(1.0f));
    EXPECT_EQ(read.metallicFactor, 0.0f);
    EXPECT_EQ(read.roughnessFactor, 0.0f);
    EXPECT_FALSE(read.metallicRoughnessTexture.IsPresent());
    ASSERT_EQ(scene.textures.size(), 2u) << "no others are loaded";
    const auto texture = [&](const scene::TextureRef& of) {
        return scene.textures.at(static_cast<size_t>(of.texture));
    };
    EXPECT_EQ(scene.images.at(texture(read.baseColorTexture).image).width, 1u);
    EXPECT_EQ(scene.images.at(texture(read.specularColorTexture).image).width, 2u);
    EXPECT_EQ(texture(read.baseColorTexture).colorSpace, scene::ColorSpace::Srgb);
    EXPECT_EQ(texture(read.specularColorTexture).colorSpace, scene::ColorSpace::Srgb);
    EXPECT_EQ(read.specularColorTexture.texCoord, 1);
    document.json["materials"][0]["extensions"]["KHR_materials_ior"]["ior"] = 1.25;
    document.json["materials"][0]["extensions"]["KHR_materials_specular"] = {
        {"specularFactor", 0.5}, {"specularColorFactor", {0.5, 0.5, 0.5}}};
    document.json["materials"][0]["extensions"]["KHR_materials_clearcoat"]["clearcoatFactor"] = 0.5;
    scene = Load(document);
    EXPECT_EQ(scene.warnings,
              std::vector<std::string>{
                  "scene.gltf: materials[0].extensions.KHR_materials_ior: has no effect: the material is one "
                  "of KHR_materials_pbrSpecularGlossiness (and 1 more)"});
    EXPECT_EQ(scene.materials.at(0).ior, 0.0f);
    EXPECT_EQ(scene.materials.at(0).specularFactor, 1.0f);
    EXPECT_EQ(scene.materials.at(0).specularColorFactor, glm::vec3(1.0f));
    EXPECT_EQ(scene.materials.at(0).clearcoatFactor, 0.5f) << "which says something else";
}

TEST(Glossiness, BadValuesAreRefusedOrPutIntoTheirRange) {
    const std::string extension = "/materials/0/extensions/" + std::string(kExtension);
    const std::string at = "materials[0].extensions." + std::string(kExtension);
    const auto place = [&](const char* key) { return extension + "/" + key; };
    const std::string places[] = {place("diffuseFactor"), place("specularFactor"), place("glossinessFactor"),
                                  place("specularGlossinessTexture/index")};
    const std::string messages[] = {at + ".diffuseFactor: has 3 elements, must have 4",
                                    at + ".specularFactor[1]: is \"x\", must be a number",
                                    at + ".glossinessFactor: is true, must be a number",
                                    at + ".specularGlossinessTexture.index: is 4, but there are 4 textures"};
    ExpectRefused(Textured(), {{places[0].c_str(), {1, 1, 1}, messages[0].c_str()},
                               {places[1].c_str(), {1, "x", 1}, messages[1].c_str()},
                               {places[2].c_str(), true, messages[2].c_str()},
                               {places[3].c_str(), 4, messages[3].c_str()}});
    const SceneData scene = Load(Glossy(
        {{"diffuseFactor", {2, 0.5, 0.5, 0.5}}, {"specularFactor", {-1, 0.5, 2}}, {"glossinessFactor", 3}}));
    EXPECT_EQ(scene.materials.at(0).baseColorFactor.x, 1.0f);
    EXPECT_EQ(scene.materials.at(0).specularColorFactor, glm::vec3(0.0f, 0.5f, 1.0f));
    EXPECT_EQ(scene.materials.at(0).roughnessFactor, 0.0f);
    EXPECT_EQ(scene.warnings.size(), 1u) << "of all of them";
    // No file can contain these values
    Material material = scene.materials.at(0);
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::Check(material, "paint"); }), "accepted");
    material.specularColorFactor.y = 1.5f;
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::Check(material, "paint"); }),
              "paint: specularColorFactor is 1.5, must be 0 to 1");
}

TEST(Glossiness, EditsAreSavedInTheExtension) {
    const GltfDocument document = Textured();
    SceneData edited = Load(document);
    Material& material = edited.materials.at(0);
    material.baseColorFactor = {0.25f, 0.5f, 0.75f, 0.875f};
    material.specularColorFactor = {0.5f, 0.25f, 0.125f};
    material.roughnessFactor = 0.3f;
    material.specularColorTexture.transform.rotation = 0.5f;
    material.clearcoatFactor = 0.5f;
    SceneData saved;
    const Json json = Saved(document, edited, saved);
    ExpectSame(edited, saved);
    Json expected = document.json;
    Json& extensions = expected["materials"][0]["extensions"];
    extensions["KHR_materials_clearcoat"]["clearcoatFactor"] = 0.5;
    extensions[kExtension]["diffuseFactor"] = {0.25, 0.5, 0.75, 0.875};
    extensions[kExtension]["specularFactor"] = {0.5, 0.25, 0.125};
    extensions[kExtension]["glossinessFactor"] = 0.7;
    extensions[kExtension]["specularGlossinessTexture"]["extensions"]["KHR_texture_transform"]["rotation"] =
        0.5;
    expected["extensionsUsed"] = json["extensionsUsed"];
    EXPECT_EQ(json, expected) << "and nothing in another place";
}

// 1 - g has other digits than g.
TEST(Glossiness, RoughnessComesBackToTheBit) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", Glossy(Json::object()).Text());
    const std::filesystem::path target = folder.Path() / "saved.gltf";
    SceneData edited = scene::LoadGltf(source);
    const auto savedAs = [&](float roughness) {
        edited.materials[0].roughnessFactor = roughness;
        scene::SaveGltf(source, edited, target);
        return scene::LoadGltf(target).materials[0].roughnessFactor;
    };
    for (const float roughness : {1.0f, 0.1f, 0.3f, 1.0f / 3.0f, 0.0001f, 1e-7f, std::nextafter(1.0f, 0.0f)})
        EXPECT_EQ(savedAs(roughness), roughness);
    // Glossiness has no digits for these
    for (const float roughness : {1e-12f, std::nextafter(0.0f, 1.0f)})
        EXPECT_NEAR(savedAs(roughness), roughness, 1e-16f);
}

TEST(Glossiness, MaterialStaysOneOfTheExtension) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", Textured().Text());
    const auto refusal = [&](const auto& change) {
        SceneData edited = scene::LoadGltf(source);
        change(edited.materials[0]);
        return testing::ErrorTextOf([&] { scene::SaveGltf(source, edited, folder.Path() / "saved.gltf"); });
    };
    const std::string start = "scene.gltf: materials[0]: ";
    EXPECT_EQ(refusal([](Material& material) { material.isSpecularGlossiness = false; }),
              start + "whether it is one of KHR_materials_pbrSpecularGlossiness cannot be changed");
    EXPECT_EQ(refusal([](Material& material) { material.metallicFactor = 0.5f; }),
              start + "its metallicFactor cannot be changed, KHR_materials_pbrSpecularGlossiness has none");
    EXPECT_EQ(refusal([](Material& material) { material.ior = 1.5f; }),
              start + "its ior cannot be changed, KHR_materials_pbrSpecularGlossiness has none");
    EXPECT_EQ(refusal([](Material& material) { material.roughnessFactor = 0.5f; }), "accepted");
}

}  // namespace
}  // namespace raygraph::test::import_glossiness_test

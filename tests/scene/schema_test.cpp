// What the table of properties says of a document, beyond what the tests of the properties show.
#include <gtest/gtest.h>

#include "tests/scene/gltf_document.h"

namespace raygraph::test {
namespace {

TEST(Schema, WhatHasNoRowMayBeAnything) {
    GltfDocument document;
    document.AddTriangle()["attributes"]["_ACME"] = "anything";
    document.json["nodes"][0]["weights"] = "anything";
    document.json["nodes"][0]["extras"] = {{"mesh", -1}};
    document.json["nodes"][0]["extensions"]["ACME_node"] = 7;
    document.json["accessors"][0]["min"] = nullptr;
    document.json["extras"] = true;
    document.json["extensions"]["ACME_root"] = Json::array();
    EXPECT_EQ(LoadError(document), "loaded");
}

TEST(Schema, WholeNumbersMayBeWrittenWithAPoint) {
    GltfDocument document;
    document.AddTriangle()["attributes"]["POSITION"] = 0.0;
    document.json["accessors"][0]["count"] = 3.0;
    document.json["nodes"][0]["mesh"] = 0.0;
    document.json["scene"] = 0.0;
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(OnlyPrimitive(scene).positions.size(), 3u);
}

TEST(Schema, DescriptionOfAnotherTypeIsNotRead) {
    GltfDocument document;
    document.AddNode({{"camera", 0}});
    document.Add("cameras", {{"type", "perspective"},
                             {"perspective", {{"yfov", 1}, {"znear", 0.1}}},
                             {"orthographic", "another program's"}});
    EXPECT_EQ(Load(document).cameras.size(), 1u);
    document.json["cameras"][0]["type"] = "orthographic";
    EXPECT_EQ(LoadError(document),
              "scene.gltf: cameras[0].orthographic: is \"another program's\", must be an object");
}

TEST(Schema, RequiredPropertiesOfAnExtensionAreRequired) {
    GltfDocument document;
    document.AddNode({{"extensions", {{"KHR_lights_punctual", Json::object()}}}});
    EXPECT_EQ(
        LoadError(document),
        "scene.gltf: nodes[0].extensions.KHR_lights_punctual.light: is absent, must be a whole number of "
        "at least 0");
}

// tinygltf refuses some of what follows, cuts or drops the rest: it is never given it.

TEST(Model, IndicesWithoutABufferViewAreZeros) {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["indices"] =
        document.Add("accessors", {{"componentType", kUint8}, {"count", 3}, {"type", "SCALAR"}});
    EXPECT_EQ(OnlyPrimitive(Load(document)).indices, (std::vector<uint32_t>{0, 0, 0}));
}

TEST(Model, OrthographicCameraMayLackItsNearPlane) {
    GltfDocument document;
    document.AddNode({{"camera", 0}});
    document.Add("cameras",
                 {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", 1}, {"zfar", 10}}}});
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.cameras.at(0).zNear, 0.0f);
    EXPECT_EQ(scene.cameras.at(0).xMag, 2.0f);
}

TEST(Model, WholeNumbersOfExtensionsMayBeGreaterThanAnInt) {
    GltfDocument document;
    document.AddMaterial(
        {{"extensions",
          {{"KHR_materials_emissive_strength", {{"emissiveStrength", 3000000000u}}},
           {"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", 9000000000000u}}},
           {"KHR_materials_specular", {{"specularColorFactor", {1, 5000000000u, 0}}}}}},
         {"extras", {{"priority", 4294967295u}}}});
    const scene::SceneData scene = Load(document);
    const scene::Material& material = scene.materials.at(0);
    EXPECT_EQ(material.emissiveStrength, 3e9f);
    EXPECT_EQ(material.attenuationDistance, 9e12f);
    EXPECT_EQ(material.specularColorFactor, glm::vec3(1.0f, 5e9f, 0.0f));
    EXPECT_EQ(material.priority, 4294967295u);
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(Model, PrimitiveThatCannotBeReadRefusesTheFile) {
    GltfDocument document;
    document.AddTriangle();
    document.json["meshes"][0]["primitives"].push_back({{"mode", 4}});
    EXPECT_EQ(LoadError(document),
              "scene.gltf: meshes[0].primitives[1].attributes: is absent, must be an object");
}

TEST(Model, ManyEmptyObjectsAreRefusedBeforeTheyTakeMemory) {
    GltfDocument document;
    document.json["materials"] = Json::array();
    for (int i = 0; i < 10000; ++i) document.json["materials"].push_back(Json::object());
    scene::LoadOptions options;
    EXPECT_EQ(Load(document, options).materials.size(), 10000u);
    options.limits.maxGeometryBytes = 1 << 20;
    const std::string message = LoadError(document, options);
    EXPECT_EQ(message.find("scene.gltf: a model of its objects exceeds the limit of "), 0u) << message;
}

TEST(Model, NamesInUrisAreTakenAsTheyAre) {
    GltfDocument document;
    document.AddTriangle();
    SceneFolder folder;
    folder.Write("a+b.bin", BytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}));
    document.json["buffers"][0]["uri"] = "a+b.bin";
    EXPECT_EQ(OnlyPrimitive(folder.Load(document)).positions.size(), 3u);
}

}  // namespace
}  // namespace raygraph::test

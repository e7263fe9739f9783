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

}  // namespace
}  // namespace raygraph::test

// The schema tables: what the tests of the properties do not cover.
#include <gtest/gtest.h>

#include <limits>

#include "renderer/scene/gltf/schema.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/peak_memory.h"

namespace raygraph::test::schema_test {
namespace {

// A property of the type that the checker does not support cannot be declared.
template <typename Row>
concept CanBePutIntoRange = requires(const Row& row) {
    row.ClampToRange();
};
template <typename Row>
concept CanBeLeftOut = requires(const Row& row) {
    row.OrOmitted("", "");
};
using scene::schema::NumberRow, scene::schema::NumbersRow, scene::schema::WholeRow, scene::schema::TextRow;
static_assert(CanBePutIntoRange<NumberRow> && CanBePutIntoRange<NumbersRow>);
static_assert(!CanBePutIntoRange<WholeRow> && !CanBePutIntoRange<TextRow>);
static_assert(CanBeLeftOut<NumberRow> && CanBeLeftOut<WholeRow>);
static_assert(!CanBeLeftOut<NumbersRow> && !CanBeLeftOut<TextRow> && !CanBeLeftOut<scene::schema::ObjectRow>);

TEST(Schema, RowsThatContradictThemselvesAreNoConstants) {
    using namespace scene::schema;
    EXPECT_ANY_THROW(Number("a").Required().OrOmitted("", ""));
    EXPECT_ANY_THROW(Whole("a").OrOmittedIfInvalid("", "").Required());
    EXPECT_ANY_THROW(Number("a").Above(0.0f).ClampToRange());
    EXPECT_ANY_THROW(Number("a").ClampToRange().Below(1.0f));
    EXPECT_NO_THROW(Number("a").Between(0.0f, 1.0f).ClampToRange().Required());
}

TEST(Schema, WhatHasNoRowMayBeAnything) {
    GltfDocument document;
    document.AddTriangle()["attributes"]["_ACME"] = "anything";
    document.json["nodes"][0]["weight"] = "anything";
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
    const std::string refusal = "scene.gltf: a model of its objects exceeds the limit of ";
    EXPECT_EQ(LoadError(document, options).substr(0, refusal.size()), refusal);
    // Bytes that are not text do not raise the limit
    const Bytes binary(1 << 20);
    SceneFolder folder;
    EXPECT_EQ(folder.LoadError(MakeGlb(document.Text(), &binary), options).substr(0, refusal.size()),
              refusal);
    options.limits.maxGeometryBytes = std::numeric_limits<uint64_t>::max();
    EXPECT_EQ(Load(document, options).materials.size(), 10000u) << "the limit does not begin again at 0";
}

// Many elements of any list are refused, or take memory that is bounded by the length of the text.
TEST(Model, EachListIsCounted) {
    const Json empty = Json::object();
    const Json triangle = {{"primitives", {{{"attributes", empty}}}}};
    struct Many {
        const char* where;
        const char* list;  // a JSON pointer
        Json element;
        Json around = Json::object();
    };
    const std::vector<Many> all{
        {"accessors", "/accessors", {{"componentType", 5121}, {"count", 1}, {"type", "SCALAR"}}},
        {"bufferViews",
         "/bufferViews",
         {{"buffer", 0}, {"byteLength", 1}},
         {{"buffers", {{{"byteLength", 1}}}}}},
        {"buffers", "/buffers", {{"byteLength", 1}}},
        {"cameras", "/cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}},
        {"images", "/images", {{"uri", ""}}},
        {"lights", "/extensions/KHR_lights_punctual/lights", {{"type", "point"}}},
        {"materials", "/materials", empty},
        {"extensions of materials", "/materials", {{"extensions", {{"KHR_materials_ior", empty}}}}},
        {"extras of materials", "/materials", {{"extras", {{"priority", 1}}}}},
        {"meshes", "/meshes", {{"primitives", Json::array()}}},
        {"primitives", "/meshes/0/primitives", {{"attributes", empty}}, {{"meshes", {triangle}}}},
        {"targets", "/meshes/0/primitives/0/targets", empty, {{"meshes", {triangle}}}},
        {"nodes", "/nodes", empty},
        {"samplers", "/samplers", empty},
        {"scenes", "/scenes", empty},
        {"textures", "/textures", empty},
    };
    scene::LoadOptions options;
    options.limits.maxGeometryBytes = 0;
    for (const Many& many : all) {
        SCOPED_TRACE(many.where);
        GltfDocument document;
        document.json.merge_patch(many.around);
        Json list = Json::array();
        for (int i = 0; i < 20000; ++i) list.push_back(many.element);
        document.json[Json::json_pointer(many.list)] = std::move(list);
        const std::string text = document.Text();
        SceneFolder folder;
        const testing::PeakMemory peak;
        const std::string outcome = folder.LoadError(ToBytes(text), options);
        const double bytesPerCharacter = double(peak.Bytes()) / double(text.size());
        RecordProperty(many.where, std::to_string(bytesPerCharacter) + " " + outcome);
        EXPECT_LT(bytesPerCharacter, 64.0 + 48.0) << outcome;
    }
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
}  // namespace raygraph::test::schema_test

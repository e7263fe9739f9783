// Tangents that the importer makes of glTF's texture coordinates where a file has none.
#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>

#include "tests/scene/gltf_document.h"

namespace raygraph::test::import_tangents_test {
namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;

// A quad with a normal map, as a file.
GltfDocument QuadWithNormalMap(uint32_t texCoord) {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["attributes"]["TEXCOORD_0"] = document.AddAccessor<float>({0, 1, 1, 1, 0, 0}, 2);
    primitive["attributes"]["TEXCOORD_1"] = document.AddAccessor<float>({1, 1, 0, 1, 1, 0}, 2);
    document.Add("images", {{"uri", DataUri(MakePng(1, 1, {128, 128, 255, 255}))}});
    document.Add("textures", {{"source", 0}});
    primitive["material"] = document.AddMaterial({{"normalTexture", {{"index", 0}, {"texCoord", texCoord}}}});
    return document;
}

TEST(ImportTangents, AreMadeForTheTextureCoordinatesOfTheNormalMap) {
    const scene::SceneData first = Load(QuadWithNormalMap(0));
    EXPECT_EQ(OnlyPrimitive(first).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
    const scene::SceneData second = Load(QuadWithNormalMap(1));
    EXPECT_EQ(OnlyPrimitive(second).tangents, std::vector<vec4>(3, vec4(-1, 0, 0, -1)));
}

// A transform may be edited or animated, so that it turns the frame where the map is read, not the tangents.
TEST(ImportTangents, TransformOfTheNormalMap_ChoosesTheSetAndTurnsNothing) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& map = document.json["materials"][0]["normalTexture"];
    map["extensions"]["KHR_texture_transform"] = {{"rotation", glm::half_pi<double>()}};
    for (const Json& kept : {Json{{"rotation", glm::half_pi<double>()}}, Json{{"scale", {-1, 1}}}}) {
        map["extensions"]["KHR_texture_transform"] = kept;
        const scene::SceneData scene = Load(document);
        EXPECT_EQ(OnlyPrimitive(scene).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
        EXPECT_EQ(OnlyPrimitive(scene).tangentTexCoord, 0u);
    }
    map["extensions"]["KHR_texture_transform"] = {{"texCoord", 1}};
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).tangents, std::vector<vec4>(3, vec4(-1, 0, 0, -1)));
    EXPECT_EQ(OnlyPrimitive(scene).tangentTexCoord, 1u);
}

// A map whose texture coordinates the primitive lacks determines no tangents; the next map does.
TEST(ImportTangents, MapWithoutCoordinates_LeavesThemToTheNext) {
    GltfDocument document = QuadWithNormalMap(1);
    document.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_1");
    EXPECT_TRUE(OnlyPrimitive(Load(document)).tangents.empty());
    document.json["materials"][0]["extensions"]["KHR_materials_clearcoat"] = {
        {"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}}}};
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
    EXPECT_EQ(OnlyPrimitive(scene).tangentTexCoord, 0u);
}

TEST(ImportTangents, AreLeftOutWithoutANormalMapOrItsTextureCoordinates) {
    GltfDocument document = QuadWithNormalMap(0);
    document.json["materials"][0] = Json::object();
    EXPECT_TRUE(OnlyPrimitive(Load(document)).tangents.empty());
    document = QuadWithNormalMap(0);
    document.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
    EXPECT_TRUE(OnlyPrimitive(Load(document)).tangents.empty());
}

// Stretched highlights lie along the tangents of the normal map; without one of their own texture, and without
// that of the first texture coordinates.
TEST(ImportTangents, AreMadeForAnisotropicMaterials) {
    const vec4 first(1, 0, 0, 1), second(-1, 0, 0, -1);
    const auto made = [](const Json& anisotropy, bool hasNormalMap) {
        GltfDocument document = QuadWithNormalMap(0);
        Json& material = document.json["materials"][0];
        if (!hasNormalMap) material = Json::object();
        material["extensions"]["KHR_materials_anisotropy"] = anisotropy;
        return OnlyPrimitive(Load(document)).tangents;
    };
    const Json texture{{"index", 0}, {"texCoord", 1}};
    EXPECT_EQ(made({{"anisotropyStrength", 0.5}}, false), std::vector<vec4>(3, first));
    EXPECT_EQ(made({{"anisotropyStrength", 0.5}, {"anisotropyTexture", texture}}, false),
              std::vector<vec4>(3, second));
    EXPECT_EQ(made({{"anisotropyStrength", 0.5}, {"anisotropyTexture", texture}}, true),
              std::vector<vec4>(3, first));
    EXPECT_TRUE(made({{"anisotropyTexture", texture}}, false).empty()) << "a strength of 0 wants none";
}

TEST(ImportTangents, GivenOnesAreUsed) {
    GltfDocument document = QuadWithNormalMap(0);
    document.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] =
        document.AddAccessor<float>({0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, 4);
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).tangents, std::vector<vec4>(3, vec4(0, 1, 0, -1)));
    EXPECT_EQ(OnlyPrimitive(scene).tangentTexCoord, scene::kNone);
}

TEST(ImportTangents, GivenOnesAreNotUsedWithNormalsThatAreMade) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& attributes = document.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TANGENT"] = document.AddAccessor<float>({0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, 4);
    attributes.erase("NORMAL");
    EXPECT_EQ(OnlyPrimitive(Load(document)).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
}

// The map of a coat reads the other set: frameTurns has the angle from the base's tangents to those of that
// set, if both are generated.
TEST(ImportTangents, MapOfTheOtherSet_HasAnglesToTheFirst) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& primitive = document.json["meshes"][0]["primitives"][0];
    Json& coat = document.json["materials"][0]["extensions"]["KHR_materials_clearcoat"];
    coat = {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}}}};
    EXPECT_TRUE(OnlyPrimitive(Load(document)).frameTurns.empty()) << "of the same set";
    coat["clearcoatNormalTexture"]["texCoord"] = 1;
    // u of the second set grows to the top, v grows to the right
    primitive["attributes"]["TEXCOORD_1"] = document.AddAccessor<float>({0, 0, 0, 1, 1, 0}, 2);
    const auto turned = [&] { return OnlyPrimitive(Load(document)).frameTurns; };
    EXPECT_EQ(turned(), std::vector<vec2>(3, vec2(0, 1)));
    EXPECT_EQ(OnlyPrimitive(Load(document)).tangents, std::vector<vec4>(3, vec4(1, 0, 0, 1)));
    primitive["attributes"]["TANGENT"] =
        document.AddAccessor<float>({0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, 4);
    EXPECT_TRUE(turned().empty()) << "given tangents are those of all maps";
    primitive["attributes"].erase("TANGENT");
    primitive["targets"] = {{{"POSITION", document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3)}}};
    EXPECT_TRUE(turned().empty()) << "targets change the angles";
}

// A vertex may have one tangent along the first set, and two along the second.
TEST(ImportTangents, MapOfTheOtherSet_SplitsVerticesOfTheFirst) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& primitive = document.json["meshes"][0]["primitives"][0];
    document.json["materials"][0]["extensions"]["KHR_materials_clearcoat"] = {
        {"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}, {"texCoord", 1}}}};
    primitive["attributes"] = {
        {"POSITION", document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0}, 3)},
        {"NORMAL", document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3)},
        {"TEXCOORD_0", document.AddAccessor<float>({0, 1, 1, 1, 1, 0, 2, 1}, 2)},
        {"TEXCOORD_1", document.AddAccessor<float>({0, 1, 1, 1, 1, 0, 0, 1}, 2)}};
    primitive["indices"] = document.AddAccessor<uint16_t>({0, 1, 2, 1, 3, 2}, 1);
    const scene::SceneData scene = Load(document);
    const scene::Primitive& loaded = OnlyPrimitive(scene);
    ASSERT_EQ(loaded.positions.size(), 6u);
    EXPECT_EQ(loaded.tangents, std::vector<vec4>(6, vec4(1, 0, 0, 1)));
    ASSERT_EQ(loaded.frameTurns.size(), 6u);
    for (size_t i = 0; i < 6; ++i)
        EXPECT_EQ(loaded.frameTurns[loaded.indices[i]], i < 3 ? vec2(1, 0) : vec2(-1, 0));
}

// The target turns the triangle by 90 degrees; the file has no tangents, and so none of the target.
TEST(ImportTangents, MorphTargetsMoveThem) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& primitive = document.json["meshes"][0]["primitives"][0];
    const size_t moves = document.AddAccessor<float>({0, 0, 0, -1, 1, 0, -1, -1, 0}, 3);
    primitive["targets"] = {{{"POSITION", moves}}, Json::object()};
    const scene::SceneData scene = Load(document);
    const scene::Primitive& loaded = OnlyPrimitive(scene);
    ASSERT_EQ(loaded.targets.size(), 2u);
    ASSERT_EQ(loaded.targets[0].tangents.size(), loaded.tangents.size());
    for (size_t i = 0; i < loaded.tangents.size(); ++i) {
        const vec3 tangent(loaded.tangents[i]), moved = tangent + loaded.targets[0].tangents[i];
        EXPECT_LT(glm::distance(moved, vec3(-tangent.y, tangent.x, 0)), 1e-6f) << i;
    }
    EXPECT_TRUE(loaded.targets[1].tangents.empty());
}

TEST(ImportTangents, SplitVerticesKeepTheirOtherAttributes) {
    GltfDocument document = QuadWithNormalMap(0);
    Json& primitive = document.json["meshes"][0]["primitives"][0];
    // Two triangles on one edge whose pictures mirror each other
    primitive["attributes"] = {
        {"POSITION", document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0}, 3)},
        {"NORMAL", document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3)},
        {"TEXCOORD_0", document.AddAccessor<float>({0, 1, 1, 1, 1, 0, 0, 1}, 2)},
        {"TEXCOORD_1", document.AddAccessor<float>({1, 2, 3, 4, 5, 6, 7, 8}, 2)},
        {"COLOR_0", document.AddAccessor<float>({0, 0, 0, 0.25f, 0, 0, 0.5f, 0, 0, 0.75f, 0, 0}, 3)}};
    primitive["indices"] = document.AddAccessor<uint16_t>({0, 1, 2, 1, 3, 2}, 1);
    const scene::SceneData scene = Load(document);
    const scene::Primitive& loaded = OnlyPrimitive(scene);
    ASSERT_EQ(loaded.positions.size(), 6u);
    for (size_t size : {loaded.normals.size(), loaded.uv0.size(), loaded.uv1.size(), loaded.colors.size(),
                        loaded.tangents.size()})
        EXPECT_EQ(size, 6u);
    const std::vector<uint32_t> file{0, 1, 2, 1, 3, 2};
    for (size_t i = 0; i < 6; ++i) {
        const uint32_t vertex = loaded.indices[i];
        EXPECT_EQ(loaded.positions[vertex], loaded.positions[file[i]]);
        EXPECT_EQ(loaded.uv1[vertex], vec2(float(2 * file[i] + 1), float(2 * file[i] + 2)));
        EXPECT_EQ(loaded.colors[vertex].x, 0.25f * float(file[i]));
        EXPECT_EQ(loaded.tangents[vertex].w, i < 3 ? 1.0f : -1.0f);
    }
}

}  // namespace
}  // namespace raygraph::test::import_tangents_test

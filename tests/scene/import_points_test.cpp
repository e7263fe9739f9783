// Points and lines: which segments they are, their radii in the world, and the checks on them.
#include <gtest/gtest.h>

#include <cmath>

#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/geometry/triangles.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"

namespace raygraph::test::import_points_test {
namespace {

using glm::vec3;
using glm::vec4;
using Indices = std::vector<uint32_t>;

scene::LoadOptions WithRadii(scene::RoundRadius points, scene::RoundRadius lines) {
    scene::LoadOptions options;
    options.pointsAndLines = {.points = points, .lines = lines};
    return options;
}

const scene::LoadOptions kShown = WithRadii({.value = 0.25f}, {.value = 0.125f});

// Four vertices with colors in the plane z = 0.
template <typename T = uint8_t>
GltfDocument Drawn(int mode, const std::vector<T>& indices = {}, const Json& node = Json::object()) {
    GltfDocument document;
    const size_t positions = document.AddAccessor<float>({0, 0, 0, 3, 0, 0, 3, 4, 0, 0, 4, 0}, 3);
    const size_t colors = document.AddAccessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5f, 0.5f, 0.5f}, 3);
    Json primitive{{"mode", mode}, {"attributes", {{"POSITION", positions}, {"COLOR_0", colors}}}};
    if (!indices.empty()) primitive["indices"] = document.AddAccessor(indices, 1);
    Json placed = node;
    placed["mesh"] = document.AddMesh(primitive);
    document.AddNode(placed);
    return document;
}

TEST(ImportPoints, EachModeGivesItsSegments) {
    EXPECT_EQ(OnlyPrimitive(Load(Drawn(0), kShown)).indices, (Indices{0, 0, 1, 1, 2, 2, 3, 3}));
    EXPECT_EQ(OnlyPrimitive(Load(Drawn(1), kShown)).indices, (Indices{0, 1, 2, 3}));
    EXPECT_EQ(OnlyPrimitive(Load(Drawn(2), kShown)).indices, (Indices{0, 1, 1, 2, 2, 3, 3, 0}));
    EXPECT_EQ(OnlyPrimitive(Load(Drawn(3), kShown)).indices, (Indices{0, 1, 1, 2, 2, 3}));
    EXPECT_EQ(OnlyPrimitive(Load(Drawn<uint8_t>(3, {3, 1, 0}), kShown)).indices, (Indices{3, 1, 1, 0}));
    // A loop of two vertices is one segment, not the same one there and back
    EXPECT_EQ(OnlyPrimitive(Load(Drawn<uint8_t>(2, {2, 3}), kShown)).indices, (Indices{2, 3}));
    for (const auto mode : {scene::PrimitiveMode::Points, scene::PrimitiveMode::Lines,
                            scene::PrimitiveMode::LineLoop, scene::PrimitiveMode::LineStrip})
        for (uint32_t count = 0; count < 7; ++count)
            EXPECT_EQ(scene::SegmentList(mode, Indices(count)).size(), 2 * scene::SegmentCount(mode, count));
}

TEST(ImportPoints, VerticesKeepTheirColorsAndPrimitivesTheirMaterial) {
    const scene::SceneData data = Load(Drawn<uint8_t>(0, {2}), kShown);
    const scene::Primitive& point = OnlyPrimitive(data);
    ASSERT_EQ(point.radii.size(), 1u);
    EXPECT_EQ(point.positions, std::vector<vec3>{vec3(3, 4, 0)}) << "only the vertex that is named";
    EXPECT_EQ(point.colors, std::vector<vec4>{vec4(0, 0, 1, 1)});
    EXPECT_TRUE(point.normals.empty());
    EXPECT_EQ(data.materials.at(point.material).name, "default");
    EXPECT_TRUE(data.warnings.empty());
}

TEST(ImportPoints, RadiiAreInTheWorldAtTheLargestPlacement) {
    const auto radius = [](const Json& node, const scene::LoadOptions& options) {
        const scene::SceneData data = Load(Drawn(0, {}, node), options);
        return OnlyPrimitive(data).radii.at(0);
    };
    EXPECT_FLOAT_EQ(radius(Json::object(), kShown), 0.25f);
    EXPECT_FLOAT_EQ(radius({{"scale", {0.001, 0.001, 0.001}}}, kShown), 250.0f);
    EXPECT_FLOAT_EQ(radius({{"scale", {1, -8, 1}}}, kShown), 0.125f) << "of the same volume";
    EXPECT_FLOAT_EQ(radius({{"scale", {2, 8, 0}}}, kShown), 0.0625f) << "of a disc of the same area";
    // The vertices are 5 apart along the diagonal
    EXPECT_FLOAT_EQ(radius(Json::object(), WithRadii({0.01f, true}, {})), 0.05f);
    EXPECT_FLOAT_EQ(radius({{"scale", {3, 3, 3}}}, WithRadii({0.01f, true}, {})), 0.05f);
    // Placed twice: at the larger scale it is as asked for
    GltfDocument document = Drawn(0, {}, {{"scale", {2, 2, 2}}});
    document.AddNode({{"mesh", 0}, {"scale", {5, 5, 5}}});
    EXPECT_FLOAT_EQ(Load(document, kShown).meshes[0].primitives[0].radii[0], 0.05f);
}

TEST(ImportPoints, BoundsContainTheRadii) {
    const scene::SceneData data = Load(Drawn(1, {}, {{"scale", {2, 2, 2}}}), kShown);
    EXPECT_NEAR(data.bounds.min.z, -0.125f, 1e-5f);
    EXPECT_NEAR(data.bounds.max.y, 8.125f, 1e-4f);
    EXPECT_LE(data.bounds.min.z, -0.125f);
    const scene::SceneStatistics statistics = scene::Statistics(data);
    EXPECT_EQ(statistics.placedCapsules, 2u);
    EXPECT_EQ(statistics.placedSpheres, 0u);
    EXPECT_EQ(statistics.placedTriangles, 0u);
    EXPECT_EQ(scene::Statistics(Load(Drawn(0), kShown)).placedSpheres, 4u);
}

TEST(ImportPoints, OneOptionDoesNotShowTheOther) {
    GltfDocument document = Drawn(0);
    Json line = document.json["meshes"][0]["primitives"][0];
    line["mode"] = 3;
    document.json["meshes"][0]["primitives"].push_back(line);
    document.json["meshes"][0]["primitives"].push_back(line);
    const scene::SceneData points = Load(document, WithRadii({.value = 1.0f}, {}));
    EXPECT_EQ(points.meshes[0].primitives.size(), 1u);
    EXPECT_EQ(points.warnings,
              std::vector<std::string>{"scene.gltf: meshes[0].primitives[1] and 1 more: 6 line segments "
                                       "are left out; a radius (--lines) shows them as capsules"});
    EXPECT_EQ(Load(document, WithRadii({}, {.value = 1.0f})).meshes[0].primitives.size(), 2u);
}

TEST(ImportPoints, HostileOnesAreRefused) {
    const auto error = [](const GltfDocument& document, const scene::LoadOptions& options = kShown) {
        return LoadError(document, options);
    };
    EXPECT_EQ(error(Drawn<uint8_t>(0, {0, 4})),
              "scene.gltf: meshes[0].primitives[0].indices: accessors[2] element 1 is 4, but POSITION has 4 "
              "elements");
    GltfDocument broken = Drawn(3);
    broken.json["buffers"][0]["uri"] =
        DataUri(BytesOf<float>({0, 0, 0, 3, std::nanf(""), 0, 3, 4, 0, 0, 4, 0}));
    EXPECT_NE(error(broken).find("scene.gltf: "), std::string::npos);
    EXPECT_NE(error(broken).find("finite"), std::string::npos) << error(broken);
    // The whole scene is one point
    GltfDocument point = Drawn<uint8_t>(0, {1});
    EXPECT_EQ(
        error(point, WithRadii({0.01f, true}, {})),
        "scene.gltf: meshes[0]: all of the scene is one point, to which no radius is relative: give it in "
        "meters");
    EXPECT_EQ(error(Drawn(0, {}, {{"scale", {1e-12, 1e-12, 1e-12}}})),
              "scene.gltf: meshes[0]: a radius of 0.25 m is 2.5e+11 at its scale, must be 1e-09 to 1e+09");
    const scene::SceneData odd = Load(Drawn<uint8_t>(1, {0, 1, 2}), kShown);
    EXPECT_EQ(OnlyPrimitive(odd).radii.size(), 1u);
    EXPECT_EQ(odd.warnings, std::vector<std::string>{
                                "scene.gltf: meshes[0].primitives[0]: 3 vertices make no whole number of "
                                "segments, the last is left out"});
    EXPECT_TRUE(Load(Drawn<uint8_t>(3, {0}), kShown).instances.empty());
}

TEST(ImportPoints, ARadiusReadsBackAsItsText) {
    using scene::ParseRoundRadius;
    EXPECT_EQ(ParseRoundRadius("0.5"), (scene::RoundRadius{.value = 0.5f}));
    EXPECT_EQ(ParseRoundRadius("0.2%"), (scene::RoundRadius{.value = 0.002f, .isRelative = true}));
    EXPECT_FALSE(ParseRoundRadius("off").IsOn());
    for (const char* text : {"off", "0.01", "1e-05", "0.2%", "0.07%", "12.5%"}) {
        EXPECT_EQ(scene::ToText(ParseRoundRadius(text)), text);
        EXPECT_EQ(ParseRoundRadius(scene::ToText(ParseRoundRadius(text))), ParseRoundRadius(text));
    }
    for (const char* text : {"", "%", "0", "-1", "nan", "inf", "1 m", "1e10", "2000%", "1%%", "on"})
        EXPECT_EQ(
            testing::ErrorTextOf([&] { ParseRoundRadius(text); }),
            std::string("\"") + text +
                "\" is not a radius: 1e-9 to 1e9 in meters, 1e-7% to 1000% of the diagonal of the scene's "
                "bounds, or off");
}

}  // namespace
}  // namespace raygraph::test::import_points_test

// Meshes: attributes, points, quantized attributes, and tangents.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/geometry/triangles.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"

// Primitives: topology, normals, tangents, colors, and the checks on them.
namespace raygraph::test::import_mesh_test {
namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;
using Indices = std::vector<uint32_t>;

// Five vertices in the plane z = 0 with normals, drawn in `mode`, with an index buffer if `indices` is not
// empty.
template <typename T = uint8_t>
GltfDocument Drawn(int mode, const std::vector<T>& indices) {
    GltfDocument document;
    const size_t positions = document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, 3);
    const size_t normals = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    Json primitive{{"mode", mode}, {"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}};
    if (!indices.empty()) primitive["indices"] = document.AddAccessor(indices, 1);
    document.AddNode({{"mesh", document.AddMesh(primitive)}});
    return document;
}

TEST(Import, TriangleListKeepsItsIndices) {
    EXPECT_EQ(OnlyPrimitive(Load(Drawn<uint8_t>(4, {0, 1, 2, 2, 1, 3}))).indices,
              (Indices{0, 1, 2, 2, 1, 3}));
}

TEST(Import, IndicesOfAllWidthsAreRead) {
    const Indices expected{4, 1, 2};
    EXPECT_EQ(OnlyPrimitive(Load(Drawn<uint8_t>(4, {4, 1, 2}))).indices, expected);
    EXPECT_EQ(OnlyPrimitive(Load(Drawn<uint16_t>(4, {4, 1, 2}))).indices, expected);
    EXPECT_EQ(OnlyPrimitive(Load(Drawn<uint32_t>(4, {4, 1, 2}))).indices, expected);
}

TEST(Import, StripIsConvertedToTrianglesOfOneWinding) {
    const scene::SceneData scene = Load(Drawn<uint8_t>(5, {}));
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    EXPECT_EQ(primitive.indices, (Indices{0, 1, 2, 1, 3, 2, 2, 3, 4}));
    for (size_t i = 0; i < primitive.indices.size(); i += 3) {
        const vec3& a = primitive.positions[primitive.indices[i]];
        const vec3& b = primitive.positions[primitive.indices[i + 1]];
        const vec3& c = primitive.positions[primitive.indices[i + 2]];
        EXPECT_GT(glm::cross(b - a, c - a).z, 0.0f) << "triangle " << i / 3;
    }
}

TEST(Import, IndexedStripIsConverted) {
    EXPECT_EQ(OnlyPrimitive(Load(Drawn<uint8_t>(5, {4, 3, 2, 1}))).indices, (Indices{4, 3, 2, 3, 1, 2}));
}

TEST(Import, FanIsConvertedAroundItsFirstVertex) {
    EXPECT_EQ(OnlyPrimitive(Load(Drawn<uint8_t>(6, {}))).indices, (Indices{1, 2, 0, 2, 3, 0, 3, 4, 0}));
}

TEST(Import, PointsAndLinesAreLeftOutWithOneWarning) {
    const char* const kWarnings[] = {
        "5 points are left out; a radius (--points) shows them as spheres",
        "2 line segments are left out; a radius (--lines) shows them as capsules",
        "5 line segments are left out; a radius (--lines) shows them as capsules",
        "4 line segments are left out; a radius (--lines) shows them as capsules",
    };
    for (int mode = 0; mode < 4; ++mode) {
        const scene::SceneData scene = Load(Drawn<uint8_t>(mode, {}));
        EXPECT_TRUE(scene.instances.empty());
        EXPECT_EQ(
            scene.warnings,
            std::vector<std::string>{std::string("scene.gltf: meshes[0].primitives[0]: ") + kWarnings[mode]});
    }
}

TEST(Import, IndicesLeftOverAreDroppedWithAWarning) {
    const scene::SceneData scene = Load(Drawn<uint8_t>(4, {0, 1, 2, 3}));
    EXPECT_EQ(OnlyPrimitive(scene).indices, (Indices{0, 1, 2}));
    EXPECT_EQ(scene.warnings, std::vector<std::string>{
                                  "scene.gltf: meshes[0].primitives[0]: 4 vertices make no whole number of "
                                  "triangles, the rest is left out"});
}

TEST(Import, UnknownModeIsRefused) {
    EXPECT_EQ(LoadError(Drawn<uint8_t>(7, {})),
              "scene.gltf: meshes[0].primitives[0].mode: is 7, must be 0 to 6");
}

TEST(Import, IndexBeyondTheVerticesIsRefused) {
    EXPECT_EQ(LoadError(Drawn<uint8_t>(4, {0, 1, 5})),
              "scene.gltf: meshes[0].primitives[0].indices: accessors[2] element 2 is 5, but POSITION has 5 "
              "elements");
    EXPECT_EQ(LoadError(Drawn<uint32_t>(4, {0, 1, 0xFFFFFFFFu})),
              "scene.gltf: meshes[0].primitives[0].indices: accessors[2] element 2 is 4294967295, but "
              "POSITION has 5 "
              "elements");
}

TEST(Import, IndicesOfTheWrongTypeAreRefused) {
    const std::string expected =
        "scene.gltf: meshes[0].primitives[0].indices: accessors[2] must be SCALAR of 5121, 5123 or 5125";
    EXPECT_EQ(LoadError(Drawn<float>(4, {0, 1, 2})), expected);
    EXPECT_EQ(LoadError(Drawn<int16_t>(4, {0, 1, 2})), expected);
}

TEST(Import, MissingNormalsBecomeFlatOnesOnSplitVertices) {
    GltfDocument document;
    const size_t positions = document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, 3);
    const size_t indices = document.AddAccessor<uint8_t>({0, 1, 2, 0, 2, 3}, 1);
    const size_t tangents = document.AddAccessor<float>(std::vector<float>(16, 1.0f), 4);
    document.AddNode(
        {{"mesh", document.AddMesh({{"indices", indices},
                                    {"attributes", {{"POSITION", positions}, {"TANGENT", tangents}}}})}});
    const scene::SceneData scene = Load(document);
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    EXPECT_EQ(primitive.positions,
              (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
    EXPECT_EQ(primitive.normals,
              (std::vector<vec3>{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}}));
    EXPECT_EQ(primitive.indices, (Indices{0, 1, 2, 3, 4, 5}));
    EXPECT_TRUE(primitive.tangents.empty()) << "tangents without normals must be ignored";
}

TEST(Import, NormalsAndTangentsBecomeUnitLength) {
    GltfDocument document;
    Json& attributes = document.AddTriangle()["attributes"];
    attributes["NORMAL"] = document.AddAccessor<float>({0, 0, 5, 0, 3, 4, 0, 0, 1e-20f}, 3);
    attributes["TANGENT"] = document.AddAccessor<float>({2, 0, 0, 1, 3, 4, 0, -1, 1, 0, 0, 0.5f}, 4);
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).normals, (std::vector<vec3>{{0, 0, 1}, {0, 0.6f, 0.8f}, {0, 0, 1}}));
    EXPECT_EQ(OnlyPrimitive(scene).tangents,
              (std::vector<vec4>{{1, 0, 0, 1}, {0.6f, 0.8f, 0, -1}, {1, 0, 0, 1}}));
}

TEST(Import, NormalsWithoutLengthAreTakenFromTheTriangles) {
    GltfDocument document;
    Json& attributes = document.AddTriangle()["attributes"];
    attributes["NORMAL"] = document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, 0, 0}, 3);
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).normals, (std::vector<vec3>{{0, 0, 1}, {1, 0, 0}, {0, 0, 1}}));
    EXPECT_EQ(
        scene.warnings,
        std::vector<std::string>{"scene.gltf: meshes[0].primitives[0]: 2 NORMAL values have no length, taken "
                                 "from the triangles around them"});
}

TEST(Import, QuantizedMeshIsRead) {
    GltfDocument document;
    document.json["extensionsUsed"] = {"KHR_mesh_quantization"};
    document.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    const auto add = [&](const Bytes& bytes, int type, size_t count, size_t components, int stride,
                         bool normalized) {
        const size_t view = document.AddBufferView(bytes);
        document.json["bufferViews"][view]["byteStride"] = stride;
        return document.AddAccessorOver(view, type, count, components, normalized);
    };
    const size_t positions =
        add(BytesOf<int16_t>({0, 0, 0, 9, 100, 0, 0, 9, 0, -7, 0, 9}), kInt16, 3, 3, 8, false);
    const size_t normals =
        add(BytesOf<int8_t>({0, 0, 127, 9, 0, 0, 127, 9, 0, 0, 127, 9}), kInt8, 3, 3, 4, true);
    const size_t uv = add(BytesOf<uint16_t>({0, 0, 65535, 0, 0, 65535}), kUint16, 3, 2, 4, true);
    document.AddNode(
        {{"mesh", document.AddMesh({{"attributes",
                                     {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uv}}}})}});
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).positions, (std::vector<vec3>{{0, 0, 0}, {100, 0, 0}, {0, -7, 0}}));
    EXPECT_EQ(OnlyPrimitive(scene).normals, std::vector<vec3>(3, vec3(0, 0, 1)));
    EXPECT_EQ(OnlyPrimitive(scene).uv0, (std::vector<vec2>{{0, 0}, {1, 0}, {0, 1}}));
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(Import, BothTextureCoordinateSetsAreRead) {
    GltfDocument document;
    Json& attributes = document.AddTriangle()["attributes"];
    attributes["TEXCOORD_0"] = document.AddAccessor<float>({0, 0, 1, 0, 0, 1}, 2);
    attributes["TEXCOORD_1"] = document.AddAccessor<float>({5, 6, 7, 8, 9, 10}, 2);
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).uv0, (std::vector<vec2>{{0, 0}, {1, 0}, {0, 1}}));
    EXPECT_EQ(OnlyPrimitive(scene).uv1, (std::vector<vec2>{{5, 6}, {7, 8}, {9, 10}}));
}

TEST(Import, ColorsOfThreeChannelsGetAlphaOne) {
    const auto load = [](const auto& values, size_t components, bool isNormalized) {
        GltfDocument document;
        document.AddTriangle()["attributes"]["COLOR_0"] =
            document.AddAccessor(values, components, isNormalized);
        return OnlyPrimitive(Load(document)).colors;
    };
    const std::vector<vec4> expected{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 0.2f, 1}};
    EXPECT_EQ(load(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 0.2f}, 3, false), expected);
    EXPECT_EQ(load(std::vector<uint8_t>{255, 0, 0, 0, 255, 0, 0, 0, 51}, 3, true), expected);
    EXPECT_EQ(
        load(std::vector<uint16_t>{65535, 0, 0, 65535, 0, 65535, 0, 65535, 0, 0, 13107, 65535}, 4, true),
        expected);
}

TEST(Import, ColorsOutOfRangeAreClampedWithAWarning) {
    GltfDocument document;
    document.AddTriangle()["attributes"]["COLOR_0"] =
        document.AddAccessor<float>({2, 0, 0, 0, 1, 0, 0, -1, 0}, 3);
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).colors, (std::vector<vec4>{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 0, 1}}));
    EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(Import, FewIndicesIntoAGreatBufferReadOnlyTheirVertices) {
    GltfDocument document;
    std::vector<float> positions, normals;
    for (int i = 0; i < 1000; ++i) {
        positions.insert(positions.end(), {static_cast<float>(i), static_cast<float>(i % 7), 0.0f});
        normals.insert(normals.end(), {0.0f, 0.0f, 1.0f});
    }
    const size_t position = document.AddAccessor(positions, 3);
    const size_t normal = document.AddAccessor(normals, 3);
    const size_t indices = document.AddAccessor<uint16_t>({900, 10, 500, 10, 900, 20}, 1);
    document.AddNode(
        {{"mesh", document.AddMesh({{"indices", indices},
                                    {"attributes", {{"POSITION", position}, {"NORMAL", normal}}}})}});
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).positions,
              (std::vector<vec3>{{10, 3, 0}, {20, 6, 0}, {500, 3, 0}, {900, 4, 0}}));
    EXPECT_EQ(OnlyPrimitive(scene).indices, (Indices{3, 0, 2, 0, 3, 1}));
}

TEST(Import, GeometryBeyondTheLimitIsRefused) {
    // One accessor of 999 vertices, drawn 2000 times: 2 M triangles from 40 kB.
    GltfDocument document;
    const size_t positions = document.AddAccessor(std::vector<float>(3 * 999, 1.0f), 3);
    Json primitives = Json::array();
    for (int i = 0; i < 2000; ++i) primitives.push_back({{"attributes", {{"POSITION", positions}}}});
    document.Add("meshes", {{"primitives", primitives}});
    document.AddNode({{"mesh", 0}});
    scene::LoadOptions options;
    options.limits.maxGeometryBytes = 1000000;
    const std::string message = LoadError(document, options);
    EXPECT_NE(message.find("decoded geometry exceeds the limit of"), std::string::npos) << message;
}

TEST(Import, AttributesOfUnequalCountAreRefused) {
    GltfDocument document;
    Json& attributes = document.AddTriangle()["attributes"];
    attributes["TEXCOORD_0"] = document.AddAccessor<float>({0, 0, 1, 0}, 2);
    EXPECT_EQ(LoadError(document),
              "scene.gltf: meshes[0].primitives[0].attributes.TEXCOORD_0: accessors[2] has 2 elements, "
              "POSITION has 3");
}

TEST(Import, AttributesOfTheWrongTypeAreRefused) {
    const auto error = [](const char* attribute, const auto& values, size_t components) {
        GltfDocument document;
        Json& attributes = document.AddTriangle()["attributes"];
        attributes[attribute] = document.AddAccessor(values, components);
        return LoadError(document);
    };
    const std::string start = "scene.gltf: meshes[0].primitives[0].attributes.";
    EXPECT_EQ(error("POSITION", std::vector<float>(6), 2),
              start + "POSITION: accessors[2] must be VEC3 of float, byte or short");
    EXPECT_EQ(error("POSITION", std::vector<uint32_t>(9), 3),
              start + "POSITION: accessors[2] must be VEC3 of float, byte or short");
    EXPECT_EQ(error("NORMAL", std::vector<uint8_t>(9), 3),
              start + "NORMAL: accessors[2] must be VEC3 of float, normalized byte or normalized short");
    EXPECT_EQ(error("TANGENT", std::vector<float>(9), 3),
              start + "TANGENT: accessors[2] must be VEC4 of float, normalized byte or normalized short");
    EXPECT_EQ(error("TEXCOORD_1", std::vector<float>(9), 3),
              start + "TEXCOORD_1: accessors[2] must be VEC2 of float, byte or short");
    EXPECT_EQ(
        error("COLOR_0", std::vector<uint8_t>(9), 3),
        start +
            "COLOR_0: accessors[2] must be VEC3 or VEC4 of float, normalized unsigned byte or normalized "
            "unsigned short");
}

TEST(Import, UnknownAttributesAreIgnored) {
    GltfDocument document;
    Json& attributes = document.AddTriangle()["attributes"];
    attributes["_HEAT"] = 0;
    attributes["TEXCOORD_2"] = 0;
    EXPECT_TRUE(Load(document).warnings.empty());
}

TEST(Import, PrimitiveWithoutMaterialGetsTheDefault) {
    GltfDocument document;
    document.AddTriangle();
    document.AddMaterial({{"name", "unused"}});
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.materials.size(), 2u);
    EXPECT_EQ(OnlyPrimitive(scene).material, 1u);
    EXPECT_EQ(scene.materials[1].baseColorFactor, vec4(1.0f));
    EXPECT_EQ(scene.materials[1].roughnessFactor, 1.0f);
}

TEST(Import, MaterialOutOfRangeIsRefused) {
    GltfDocument document;
    document.AddTriangle()["material"] = 0;
    EXPECT_EQ(LoadError(document),
              "scene.gltf: meshes[0].primitives[0].material: is 0, but there are 0 materials");
}

TEST(Import, MeshesThatAreNotPlacedAreNotDecoded) {
    GltfDocument document;
    document.AddTriangle();
    document.Add("meshes", document.json["meshes"][0]);
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.meshes[0].primitives.size(), 1u);
    EXPECT_TRUE(scene.meshes[1].primitives.empty());
}

TEST(Triangles, FlatNormalOfADegenerateTriangleIsFinite) {
    const std::vector<vec3> positions(3, vec3(1, 2, 3));
    EXPECT_EQ(scene::FlatNormals(positions), std::vector<vec3>(3, vec3(0, 0, 1)));
}

TEST(Triangles, FlatNormalsHoldForTinyAndHugeTriangles) {
    for (const float size : {1e-12f, 1e18f}) {
        const std::vector<vec3> positions{{0, 0, 0}, {0, size, 0}, {0, 0, size}};
        EXPECT_EQ(scene::FlatNormals(positions), std::vector<vec3>(3, vec3(1, 0, 0))) << size;
    }
}

TEST(Triangles, TangentsWithoutLengthBecomePerpendicularToTheNormal) {
    std::vector<vec4> tangents(2, vec4(0, 0, 0, -1));
    const std::vector<vec3> normals{{1, 0, 0}, {0, 0.6f, 0.8f}};
    EXPECT_EQ(scene::NormalizeTangents(tangents, normals), 2u);
    for (size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(glm::dot(vec3(tangents[i]), normals[i]), 0.0f, 1e-6f);
        EXPECT_NEAR(glm::length(vec3(tangents[i])), 1.0f, 1e-6f);
        EXPECT_EQ(tangents[i].w, -1.0f);
    }
}

}  // namespace
}  // namespace raygraph::test::import_mesh_test

// Points and lines: which segments they are, their radii in the world, and the checks on them.
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

// KHR_mesh_quantization: every type that it adds is read as its value, on a mesh as a whole; what it does not
// allow is refused, and what takes it is told of where the file does not name it.
namespace raygraph::test::import_quantization_test {
namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;

constexpr const char* kExtension = "KHR_mesh_quantization";

// Elements of `components` values, each padded to a multiple of four bytes, as the extension wants it.
template <typename T>
size_t AddPadded(GltfDocument& document, const std::vector<T>& values, size_t components, bool isNormalized) {
    const size_t stride = (components * sizeof(T) + 3) / 4 * 4, count = values.size() / components;
    Bytes bytes(count * stride);
    for (size_t i = 0; i < count; ++i)
        std::memcpy(&bytes[i * stride], &values[i * components], components * sizeof(T));
    const size_t view = document.AddBufferView(bytes);
    document.json["bufferViews"][view]["byteStride"] = stride;
    return document.AddAccessorOver(view, ComponentTypeOf<T>(), count, components, isNormalized);
}

// A triangle that names the extension.
GltfDocument Quantized() {
    GltfDocument document;
    document.AddTriangle();
    document.json["extensionsUsed"] = document.json["extensionsRequired"] = Json::array({kExtension});
    return document;
}

void SetAttribute(GltfDocument& document, const char* name, size_t accessor) {
    document.json["meshes"][0]["primitives"][0]["attributes"][name] = accessor;
}

// Returns the number that a value of the type stands for, by the extension's table.
template <typename T>
float Meant(T value, bool isNormalized) {
    if (!isNormalized) return float(value);
    return std::max(float(value) / float(std::numeric_limits<T>::max()), -1.0f);
}

template <typename T>
class QuantizedType : public ::testing::Test {};
using IntegerTypes = ::testing::Types<int8_t, uint8_t, int16_t, uint16_t>;
TYPED_TEST_SUITE(QuantizedType, IntegerTypes);

TYPED_TEST(QuantizedType, PositionsAreReadNormalizedOrNot) {
    constexpr TypeParam kMax = std::numeric_limits<TypeParam>::max(),
                        kMin = std::numeric_limits<TypeParam>::lowest();
    const std::vector<TypeParam> values{0, 0, 0, kMax, 0, 1, 1, kMax, kMin};
    for (const bool isNormalized : {false, true}) {
        GltfDocument document = Quantized();
        SetAttribute(document, "POSITION", AddPadded(document, values, 3, isNormalized));
        const scene::SceneData scene = Load(document);
        EXPECT_TRUE(scene.warnings.empty());
        const std::vector<vec3>& positions = OnlyPrimitive(scene).positions;
        ASSERT_EQ(positions.size(), 3u);
        for (size_t i = 0; i < 3; ++i)
            for (size_t c = 0; c < 3; ++c)
                EXPECT_EQ(positions[i][int(c)], Meant(values[3 * i + c], isNormalized)) << i << ' ' << c;
        EXPECT_EQ(scene.bounds.max.x, Meant(kMax, isNormalized));
    }
}

TYPED_TEST(QuantizedType, TextureCoordinatesAreReadNormalizedOrNot) {
    constexpr TypeParam kMax = std::numeric_limits<TypeParam>::max(),
                        kMin = std::numeric_limits<TypeParam>::lowest();
    const std::vector<TypeParam> values{0, 3, kMax, 0, kMin, kMax};
    for (const bool isNormalized : {false, true}) {
        GltfDocument document = Quantized();
        const size_t accessor = AddPadded(document, values, 2, isNormalized);
        SetAttribute(document, "TEXCOORD_0", accessor);
        SetAttribute(document, "TEXCOORD_1", accessor);
        const scene::SceneData scene = Load(document);
        EXPECT_TRUE(scene.warnings.empty());
        const scene::Primitive& primitive = OnlyPrimitive(scene);
        ASSERT_EQ(primitive.uv0.size(), 3u);
        for (size_t i = 0; i < 3; ++i)
            EXPECT_EQ(primitive.uv0[i],
                      vec2(Meant(values[2 * i], isNormalized), Meant(values[2 * i + 1], isNormalized)));
        EXPECT_EQ(primitive.uv1, primitive.uv0);
    }
}

TYPED_TEST(QuantizedType, NormalsAndTangentsAreNormalizedSignedOnes) {
    constexpr bool isSigned = std::is_signed_v<TypeParam>;
    constexpr TypeParam kMax = std::numeric_limits<TypeParam>::max();
    constexpr TypeParam kMin = isSigned ? TypeParam(-kMax) : TypeParam(0);
    // Some are not of unit length, as rounding leaves them
    const std::vector<TypeParam> normals{0, 0, kMax, kMax / 2, 0, kMax / 2, 0, kMin, 0};
    const std::vector<TypeParam> tangents{kMax, 0, 0, kMax, 0, kMax, 0, kMin, kMax, 0, 0, kMax};
    for (const bool isNormalized : {false, true}) {
        GltfDocument document = Quantized();
        const size_t normal = AddPadded(document, normals, 3, isNormalized);
        const size_t tangent = AddPadded(document, tangents, 4, isNormalized);
        SetAttribute(document, "NORMAL", normal);
        SetAttribute(document, "TANGENT", tangent);
        if (!isSigned || !isNormalized) {
            EXPECT_EQ(LoadError(document),
                      "scene.gltf: meshes[0].primitives[0].attributes.NORMAL: accessors[" +
                          std::to_string(normal) +
                          "] must be VEC3 of float, normalized byte or normalized short");
            document.json["meshes"][0]["primitives"][0]["attributes"].erase("NORMAL");
            EXPECT_EQ(LoadError(document),
                      "scene.gltf: meshes[0].primitives[0].attributes.TANGENT: accessors[" +
                          std::to_string(tangent) +
                          "] must be VEC4 of float, normalized byte or normalized short");
            continue;
        }
        const scene::SceneData scene = Load(document);
        EXPECT_TRUE(scene.warnings.empty());
        const scene::Primitive& primitive = OnlyPrimitive(scene);
        ASSERT_EQ(primitive.normals.size(), 3u);
        const float h = std::sqrt(0.5f);
        const vec3 expected[] = {{0, 0, 1}, {h, 0, h}, {0, -1, 0}};
        for (size_t i = 0; i < 3; ++i)
            EXPECT_LT(glm::distance(primitive.normals[i], expected[i]), 1e-6f) << i;
        EXPECT_EQ(primitive.tangents, (std::vector<vec4>{{1, 0, 0, 1}, {0, 1, 0, -1}, {1, 0, 0, 1}}));
    }
}

// Encoders write shorts around the origin, and a node that scales them back.
TEST(Quantization, NodeScalesTheMeshBack) {
    GltfDocument document = Quantized();
    SetAttribute(document, "POSITION",
                 AddPadded<uint16_t>(document, {0, 0, 0, 65535, 0, 0, 0, 65535, 0}, 3, false));
    document.json["nodes"][0]["scale"] = {2.0 / 65535, 2.0 / 65535, 2.0 / 65535};
    document.json["nodes"][0]["translation"] = {-1, -1, 0};
    const scene::SceneData scene = Load(document);
    EXPECT_LT(glm::distance(scene.bounds.min, vec3(-1, -1, 0)), 1e-6f);
    EXPECT_LT(glm::distance(scene.bounds.max, vec3(1, 1, 0)), 1e-6f);
}

TEST(Quantization, FileThatDoesNotNameItIsReadWithAWarning) {
    GltfDocument document = Quantized();
    const size_t accessor = AddPadded<int8_t>(document, {0, 0, 0, 1, 0, 0, 0, 1, 0}, 3, false);
    SetAttribute(document, "POSITION", accessor);
    document.json.erase("extensionsRequired");
    EXPECT_TRUE(Load(document).warnings.empty()) << "used is enough";
    document.json.erase("extensionsUsed");
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).positions[1], vec3(1, 0, 0));
    EXPECT_EQ(
        scene.warnings,
        std::vector<std::string>{
            "scene.gltf: meshes[0].primitives[0].attributes.POSITION: accessors[" + std::to_string(accessor) +
            "] takes KHR_mesh_quantization, which the file does not name; read with it"});
}

TEST(Quantization, WhatTheCoreAllowsNeedsNoExtension) {
    GltfDocument document;
    document.AddTriangle();
    SetAttribute(document, "TEXCOORD_0", AddPadded<uint8_t>(document, {0, 0, 255, 0, 0, 255}, 2, true));
    SetAttribute(document, "TEXCOORD_1", AddPadded<uint16_t>(document, {0, 0, 65535, 0, 0, 65535}, 2, true));
    SetAttribute(document, "COLOR_0",
                 AddPadded<uint8_t>(document, {1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 1, 1}, 4, true));
    EXPECT_TRUE(Load(document).warnings.empty());
}

TEST(Quantization, ThirtyTwoBitsAreRefused) {
    GltfDocument document = Quantized();
    const size_t accessor = document.AddAccessor<uint32_t>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3);
    SetAttribute(document, "POSITION", accessor);
    EXPECT_EQ(LoadError(document), "scene.gltf: meshes[0].primitives[0].attributes.POSITION: accessors[" +
                                       std::to_string(accessor) + "] must be VEC3 of float, byte or short");
}

}  // namespace
}  // namespace raygraph::test::import_quantization_test

// Tangents that the importer makes of glTF's texture coordinates where a file has none.
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

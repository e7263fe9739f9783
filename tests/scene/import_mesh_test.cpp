// Primitives: topology, normals, tangents, colors, and the checks on them.
#include <gtest/gtest.h>

#include "renderer/scene/geometry/triangles.h"
#include "tests/scene/gltf_document.h"

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

// KHR_draco_mesh_compression: what is decoded is what was encoded; counts that disagree, and hostile ones,
// end with one line.
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <draco/metadata/geometry_metadata.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <tuple>

#include "base/text.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/gltf_document.h"
#include "tests/scene/same_scene.h"

namespace raygraph::test::import_draco_test {
namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;

constexpr const char* kExtension = "KHR_draco_mesh_compression";
constexpr uint32_t kSide = 9, kPoints = kSide * kSide, kFaces = 2 * (kSide - 1) * (kSide - 1);
// Ids of the attributes in the compressed data.
constexpr uint32_t kPositionId = 7, kNormalId = 2, kUvId = 11, kColorId = 0;

// A bumpy square whose texture coordinates and colors are the numbers of its vertices.
struct Grid {
    std::vector<vec3> positions, normals;
    std::vector<vec2> uv;
    std::vector<std::array<uint8_t, 4>> colors;
    std::vector<uint32_t> indices;

    Grid() {
        for (uint32_t i = 0; i < kPoints; ++i) {
            const uint32_t x = i % kSide, y = i / kSide;
            positions.emplace_back(x, 0.5f * float(y), 0.125f * float(x * y % 5));
            normals.push_back(glm::normalize(vec3(0.1f * float(x % 3), 0.1f * float(y % 4), 1.0f)));
            uv.emplace_back(float(i), 0.5f);
            colors.push_back({uint8_t(i), uint8_t(255 - i), 3, 255});
            if (x + 1 == kSide || y + 1 == kSide) continue;
            indices.insert(indices.end(), {i, i + 1, i + kSide, i + kSide, i + 1, i + kSide + 1});
        }
    }
};

struct Encoding {
    int method = draco::MESH_EDGEBREAKER_ENCODING;
    int submethod = -1;
    int speed = 5;
    int positionBits = 0, uvBits = 0;  // 0: not rounded
    bool hasMetadata = false;
    int extraAttributes = 0;  // attributes that no primitive has
};
struct Encoded {
    Bytes bytes;
    size_t pointCount = 0, faceCount = 0;
};

template <typename T>
void AddAttribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, uint32_t id, uint8_t components,
                  draco::DataType dataType, const std::vector<T>& values) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, components, dataType, false, sizeof(T), 0);
    const int index = mesh.AddAttribute(attribute, true, kPoints);
    for (uint32_t i = 0; i < kPoints; ++i)
        mesh.attribute(index)->SetAttributeValue(draco::AttributeValueIndex(i), &values[i]);
    mesh.attribute(index)->set_unique_id(id);
}

Encoded Encode(const Encoding& encoding = {}) {
    const Grid grid;
    draco::Mesh mesh;
    mesh.set_num_points(kPoints);
    for (uint32_t face = 0; face < kFaces; ++face)
        mesh.AddFace({draco::PointIndex(grid.indices[3 * face]),
                      draco::PointIndex(grid.indices[3 * face + 1]),
                      draco::PointIndex(grid.indices[3 * face + 2])});
    AddAttribute(mesh, draco::GeometryAttribute::POSITION, kPositionId, 3, draco::DT_FLOAT32, grid.positions);
    AddAttribute(mesh, draco::GeometryAttribute::NORMAL, kNormalId, 3, draco::DT_FLOAT32, grid.normals);
    AddAttribute(mesh, draco::GeometryAttribute::TEX_COORD, kUvId, 2, draco::DT_FLOAT32, grid.uv);
    AddAttribute(mesh, draco::GeometryAttribute::COLOR, kColorId, 4, draco::DT_UINT8, grid.colors);
    for (int i = 0; i < encoding.extraAttributes; ++i)
        AddAttribute(mesh, draco::GeometryAttribute::GENERIC, uint32_t(100 + i), 4, draco::DT_UINT8,
                     grid.colors);
    if (encoding.hasMetadata) {
        auto metadata = std::make_unique<draco::GeometryMetadata>();
        metadata->AddEntryString("name", "grid");
        mesh.AddMetadata(std::move(metadata));
    }
    draco::ExpertEncoder encoder(mesh);
    encoder.SetTrackEncodedProperties(true);
    encoder.SetSpeedOptions(encoding.speed, encoding.speed);
    encoder.SetEncodingMethod(encoding.method);
    if (encoding.submethod >= 0) encoder.SetEncodingSubmethod(encoding.submethod);
    if (encoding.positionBits > 0) encoder.SetAttributeQuantization(0, encoding.positionBits);
    if (encoding.uvBits > 0) encoder.SetAttributeQuantization(2, encoding.uvBits);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
    Bytes bytes(buffer.size());
    std::memcpy(bytes.data(), buffer.data(), buffer.size());
    return {bytes, encoder.num_encoded_points(), encoder.num_encoded_faces()};
}

// A document of which all data but the compressed one is counts and types.
GltfDocument Compressed(const Encoded& encoded) {
    GltfDocument document;
    const size_t view = document.AddBufferView(encoded.bytes);
    const auto add = [&](int componentType, const char* type, size_t count, bool isNormalized) {
        return document.Add("accessors", {{"componentType", componentType},
                                          {"type", type},
                                          {"count", count},
                                          {"normalized", isNormalized}});
    };
    const size_t points = encoded.pointCount;
    const size_t positions = add(kFloat, "VEC3", points, false), normals = add(kFloat, "VEC3", points, false);
    const size_t uv = add(kFloat, "VEC2", points, false), colors = add(kUint8, "VEC4", points, true);
    const size_t indices = add(kUint16, "SCALAR", 3 * encoded.faceCount, false);
    document.AddNode(
        {{"mesh",
          document.AddMesh(
              {{"attributes",
                {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uv}, {"COLOR_0", colors}}},
               {"indices", indices},
               {"extensions",
                {{kExtension,
                  {{"bufferView", view},
                   {"attributes",
                    {{"POSITION", kPositionId},
                     {"NORMAL", kNormalId},
                     {"TEXCOORD_0", kUvId},
                     {"COLOR_0", kColorId}}}}}}}})}});
    document.json["extensionsUsed"] = document.json["extensionsRequired"] = Json::array({kExtension});
    return document;
}

Json& Primitive(GltfDocument& document) {
    return document.json["meshes"][0]["primitives"][0];
}
// The triangles, each from its smallest corner on, in ascending order: by the numbers of the grid's vertices,
// which are in `uv`.
std::vector<std::array<uint32_t, 3>> Triangles(const scene::Primitive& primitive) {
    std::vector<std::array<uint32_t, 3>> triangles;
    for (size_t i = 0; i < primitive.indices.size(); i += 3) {
        std::array<uint32_t, 3> corners;
        for (size_t c = 0; c < 3; ++c)
            corners[c] = uint32_t(std::lround(primitive.uv0[primitive.indices[i + c]].x));
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        triangles.push_back(corners);
    }
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

void ExpectGrid(const scene::SceneData& scene, float positionTolerance = 0.0f) {
    const Grid grid;
    EXPECT_TRUE(scene.warnings.empty());
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    ASSERT_EQ(primitive.positions.size(), kPoints);
    for (size_t i = 0; i < kPoints; ++i) {
        const auto number = size_t(std::lround(primitive.uv0[i].x));
        ASSERT_LT(number, kPoints);
        EXPECT_LE(glm::distance(primitive.positions[i], grid.positions[number]), positionTolerance) << number;
        EXPECT_LT(glm::distance(primitive.normals[i], grid.normals[number]), 1e-6f) << number;
        EXPECT_EQ(primitive.colors[i].x, float(number) / 255.0f);
        EXPECT_EQ(primitive.colors[i].w, 1.0f);
    }
    scene::Primitive expected;
    expected.uv0 = grid.uv;
    expected.indices = grid.indices;
    EXPECT_EQ(Triangles(primitive), Triangles(expected));
}

TEST(Draco, EveryMethodGivesBackTheMesh) {
    ExpectGrid(Load(Compressed(Encode({.method = draco::MESH_SEQUENTIAL_ENCODING, .speed = 10}))));
    ExpectGrid(Load(Compressed(Encode({.method = draco::MESH_SEQUENTIAL_ENCODING, .speed = 0}))));
    for (const int submethod :
         {draco::MESH_EDGEBREAKER_STANDARD_ENCODING, draco::MESH_EDGEBREAKER_VALENCE_ENCODING})
        for (const int speed : {0, 5, 9})
            ExpectGrid(Load(Compressed(Encode({.submethod = submethod, .speed = speed}))));
}

TEST(Draco, QuantizedPositionsAreNear) {
    ExpectGrid(Load(Compressed(Encode({.positionBits = 14}))), 1e-3f);
}

// The extension allows strips: one is decoded as triangles, and its accessor counts the strip's indices.
TEST(Draco, StripsAreTriangles) {
    GltfDocument document = Compressed(Encode());
    Primitive(document)["mode"] = 5;
    document.json["accessors"][4]["count"] = 100;
    ExpectGrid(Load(document));
    Primitive(document)["mode"] = 6;
    EXPECT_EQ(LoadError(document),
              "scene.gltf: meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: "
              "is of a primitive that is no list or strip of triangles");
}

TEST(Draco, AttributesThatAreNotCompressedAreReadFromTheirAccessors) {
    GltfDocument document = Compressed(Encode({.method = draco::MESH_SEQUENTIAL_ENCODING}));
    std::vector<float> uv;
    for (uint32_t i = 0; i < kPoints; ++i) uv.insert(uv.end(), {0.25f, float(i)});
    Primitive(document)["attributes"]["TEXCOORD_1"] = document.AddAccessor(uv, 2);
    const scene::SceneData scene = Load(document);
    ExpectGrid(scene);
    EXPECT_EQ(OnlyPrimitive(scene).uv1[5], vec2(0.25f, 5.0f));
}

// Accessors that have bytes too, for readers without the extension.
TEST(Draco, CompressedDataIsPreferred) {
    GltfDocument document = Compressed(Encode());
    const size_t zeros = document.AddBufferView(Bytes(size_t{kPoints} * 12));
    document.json["accessors"][0]["bufferView"] = zeros;
    ExpectGrid(Load(document));
}

TEST(Draco, WhatDisagreesIsRefused) {
    const Encoded encoded = Encode();
    const std::string at = "scene.gltf: meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
    const auto refused = [&](const char* where, const Json& value, const std::string& message) {
        GltfDocument document = Compressed(encoded);
        document.json[Json::json_pointer(where)] = value;
        EXPECT_EQ(LoadError(document), message) << where;
    };
    refused("/accessors/4/count", 3, at + ": 128 triangles are compressed, indices has 3 elements");
    GltfDocument fewer = Compressed(encoded);
    for (size_t i = 0; i < 4; ++i) fewer.json["accessors"][i]["count"] = 80;
    EXPECT_EQ(LoadError(fewer), at + ": 81 vertices are compressed, POSITION has 80 elements");
    const std::string extension = std::string("/meshes/0/primitives/0/extensions/") + kExtension;
    refused((extension + "/attributes/NORMAL").c_str(), 99,
            at + ".attributes.NORMAL: is 99, no attribute has this id");
    refused((extension + "/attributes/NORMAL").c_str(), kUvId,
            at + ".attributes.NORMAL: is of another type than accessors[1]");
    refused((extension + "/attributes/TANGENT").c_str(), 3,
            at + ".attributes.TANGENT: is of an attribute that the primitive does not have");
    refused((extension + "/attributes/NORMAL").c_str(), -1,
            at + ".attributes.NORMAL: is -1, must be a whole number of at least 0");
    refused((extension + "/bufferView").c_str(), 5, at + ".bufferView: is 5, but there is 1 bufferView");
    refused(
        "/accessors/2/componentType", kInt16,
        "scene.gltf: meshes[0].primitives[0].extensions.KHR_draco_mesh_compression.attributes.TEXCOORD_0: is "
        "of another type than accessors[2]");
}

TEST(Draco, WhatIsNoMeshOfThisFormatIsRefused) {
    const Encoded encoded = Encode();
    const std::string at = "scene.gltf: meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: ";
    const auto changed = [&](size_t byte, uint8_t value) {
        Encoded other = encoded;
        other.bytes[byte] = std::byte{value};
        return LoadError(Compressed(other));
    };
    EXPECT_EQ(changed(0, 'd'), at + "its bytes are not those of Draco");
    EXPECT_EQ(changed(6, 1), at + "is of version 2.1 of the format, 2.2 is read");
    EXPECT_EQ(changed(7, 0), at + "holds no mesh of triangles");
    EXPECT_EQ(changed(8, 9), at + "its bytes are damaged");
    EXPECT_EQ(LoadError(Compressed(Encode({.hasMetadata = true}))), at + "has metadata, which is not read");
    Encoded half = encoded;
    half.bytes.resize(half.bytes.size() / 2);
    EXPECT_EQ(LoadError(Compressed(half)), at + "its bytes are damaged");
}

void AppendVarint(Bytes& bytes, uint32_t value) {
    for (; value >= 128; value >>= 7) bytes.push_back(std::byte((value & 127) | 128));
    bytes.push_back(std::byte(value));
}

// Thirty bytes that claim a billion triangles, and accessors that claim them too.
TEST(Draco, MemoryIsChargedBeforeItIsTaken) {
    constexpr uint32_t kClaimed = 1'000'000'000;
    for (const int method : {0, 1}) {
        Encoded encoded;
        for (const int byte : {0x44, 0x52, 0x41, 0x43, 0x4F, 2, 2, 1})
            encoded.bytes.push_back(std::byte(byte));
        encoded.bytes.push_back(std::byte(method));
        encoded.bytes.resize(11);                                // no flags
        if (method == 1) encoded.bytes.push_back(std::byte{0});  // the traversal
        AppendVarint(encoded.bytes, method == 1 ? kClaimed / 2 : kClaimed);
        AppendVarint(encoded.bytes, method == 1 ? kClaimed : 3 * (kClaimed / 3));
        if (method == 1) {
            encoded.bytes.push_back(std::byte{255});
            AppendVarint(encoded.bytes, kClaimed);
            AppendVarint(encoded.bytes, kClaimed);
        }
        encoded.bytes.resize(encoded.bytes.size() + 20);
        encoded.pointCount = 3 * (kClaimed / 3);
        encoded.faceCount = kClaimed;
        GltfDocument document = Compressed(encoded);
        document.json["accessors"][4]["componentType"] = kUint32;
        document.json["accessors"][4]["count"] = uint64_t{3} * kClaimed;
        const std::string error = LoadError(document);
        EXPECT_NE(error.find("decoded geometry exceeds the limit of "), std::string::npos) << error;
    }
}

// The number of bits that predict texture coordinates follows their compressed values: the decoder makes room
// for two billion, and takes half a minute to read them all from a few bytes.
TEST(Draco, OrientationsOfTextureCoordinatesAreAtMostOneAValue) {
    const Encoded encoded = Encode({.speed = 0, .positionBits = 11, .uvBits = 11});
    EXPECT_EQ(LoadError(Compressed(encoded)), "loaded");
    const auto error = [&](size_t at, uint32_t count) {
        Encoded changed = encoded;
        std::memcpy(&changed.bytes[at], &count, sizeof(count));
        return LoadError(Compressed(changed));
    };
    const auto refusal = [](const char* count) {
        return Text(
            "scene.gltf: meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: {} orientations are "
            "compressed, of 81 values",
            count);
    };
    std::vector<size_t> places;
    for (size_t at = 11; at + 4 <= encoded.bytes.size(); ++at) {
        uint32_t count = 0;
        std::memcpy(&count, &encoded.bytes[at], sizeof(count));
        if (count > 0 && count <= kPoints && error(at, 82) == refusal("82")) places.push_back(at);
    }
    ASSERT_EQ(places.size(), 1u);
    EXPECT_EQ(error(places[0], 2147483647), refusal("2147483647"));
    EXPECT_NE(error(places[0], 81), refusal("81"));
}

TEST(Draco, AttributesAreLimitedInNumber) {
    EXPECT_EQ(LoadError(Compressed(Encode({.extraAttributes = 60}))), "loaded");
    EXPECT_EQ(LoadError(Compressed(Encode({.extraAttributes = 61}))),
              "scene.gltf: meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: 65 attributes are "
              "compressed, at most 64 are read");
}

// The decoded size does not grow with the number of primitives that share the same bytes.
TEST(Draco, PrimitivesThatShareTheirDataAreLimited) {
    GltfDocument document = Compressed(Encode({.extraAttributes = 60}));
    Json& primitives = document.json["meshes"][0]["primitives"];
    for (int i = 0; i < 9; ++i) primitives.push_back(Json(primitives[0]));
    EXPECT_EQ(LoadError(document), "loaded");
    for (int i = 0; i < 90; ++i) primitives.push_back(Json(primitives[0]));
    const std::string error = LoadError(document);
    EXPECT_NE(error.find("too many primitives share their compressed data"), std::string::npos) << error;
}

TEST(Draco, SavingKeepsIt) {
    SceneFolder folder;
    GltfDocument document = Compressed(Encode());
    const std::filesystem::path source = folder.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    edited.nodes[0].translation = {1, 2, 3};
    scene::UpdateWorldTransforms(edited);
    scene::SaveGltf(source, edited, folder.Path() / "saved.glb");
    ExpectSame(edited, scene::LoadGltf(folder.Path() / "saved.glb"));
}

// Worth most under AddressSanitizer.
TEST(Draco, ChangedBytesLoadOrEndWithOneLine) {
    std::mt19937 random(11);
    const auto below = [&](size_t bound) { return size_t{random()} % bound; };
    const std::array encodings{
        Encode({.method = draco::MESH_SEQUENTIAL_ENCODING, .speed = 10}),
        Encode({.method = draco::MESH_SEQUENTIAL_ENCODING, .speed = 0}),
        Encode({.submethod = draco::MESH_EDGEBREAKER_STANDARD_ENCODING, .positionBits = 10}),
        Encode({.submethod = draco::MESH_EDGEBREAKER_VALENCE_ENCODING, .speed = 0})};
    size_t loadedCount = 0, refusedCount = 0;
    for (int round = 0; round < 2000; ++round) {
        Encoded encoded = encodings[size_t(round) % encodings.size()];
        for (size_t i = 0; i < 1 + below(4); ++i)
            encoded.bytes[9 + below(encoded.bytes.size() - 9)] = std::byte(random());
        if (below(8) == 0) encoded.bytes.resize(12 + below(encoded.bytes.size() - 12));
        const std::string result = LoadError(Compressed(encoded));
        ++(result == "loaded" ? loadedCount : refusedCount);
        ASSERT_TRUE(result == "loaded" || result.starts_with("scene.gltf: ")) << round << ": " << result;
        ASSERT_EQ(result.find('\n'), std::string::npos);
    }
    EXPECT_GT(loadedCount, 20u);
    EXPECT_GT(refusedCount, 100u);
}

// Generic attributes hold the bytes of the colors: i, 255 - i, 3 and 255 of vertex i, as joints and as weights.
TEST(Draco, JointsAndWeightsAreDecoded) {
    const Encoded encoded = Encode({.extraAttributes = 2});
    GltfDocument document = Compressed(encoded);
    Json accessor{{"componentType", kUint8}, {"type", "VEC4"}, {"count", encoded.pointCount}};
    Json& attributes = Primitive(document)["attributes"];
    Json& ids = Primitive(document)["extensions"][kExtension]["attributes"];
    attributes["JOINTS_0"] = document.Add("accessors", accessor);
    accessor["normalized"] = true;
    attributes["WEIGHTS_0"] = document.Add("accessors", accessor);
    ids["JOINTS_0"] = 100;
    ids["WEIGHTS_0"] = 101;
    document.Add("skins", {{"joints", Json(256, 0)}});
    document.json["nodes"][0]["skin"] = 0;
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.warnings.size(), 1u) << "the weights do not sum to 1";
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    ASSERT_EQ(primitive.influences.perVertex, 4u);
    ASSERT_EQ(primitive.influences.joints.size(), 4 * primitive.positions.size());
    for (size_t v = 0; v < primitive.positions.size(); ++v) {
        const auto number = uint32_t(std::lround(primitive.uv0[v].x));
        std::map<uint32_t, float> weights;
        for (size_t k = 4 * v; k < 4 * v + 4; ++k)
            weights[primitive.influences.joints[k]] += 513.0f * primitive.influences.weights[k];
        if (number < 4) continue;  // where joints are named twice
        ASSERT_EQ(weights.size(), 4u);
        EXPECT_NEAR(weights[number], float(number), 1e-3f);
        EXPECT_NEAR(weights[255 - number], 255.0f - float(number), 1e-3f);
        EXPECT_NEAR(weights[3], 3.0f, 1e-3f);
        EXPECT_NEAR(weights[255], 255.0f, 1e-3f);
    }
}

}  // namespace
}  // namespace raygraph::test::import_draco_test

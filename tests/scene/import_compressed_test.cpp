#include <gtest/gtest.h>

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <draco/metadata/geometry_metadata.h>
#include <meshoptimizer.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <tuple>

#include "base/text.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/encode_exponentials.h"

// KHR_draco_mesh_compression: what is decoded is what was encoded; counts that disagree, and hostile ones,
// end with one line.
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

// EXT_meshopt_compression and KHR_meshopt_compression: what is decoded is what was encoded, and hostile bytes
// end with one line.
namespace raygraph::test::import_meshopt_test {
namespace {

using glm::vec3;

constexpr const char* kExt = "EXT_meshopt_compression";
constexpr const char* kKhr = "KHR_meshopt_compression";

Bytes AsBytes(const std::vector<unsigned char>& values, size_t size) {
    Bytes bytes(size);
    std::memcpy(bytes.data(), values.data(), size);
    return bytes;
}

Bytes EncodeAttributes(const void* elements, size_t count, size_t stride) {
    std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
    return AsBytes(out, meshopt_encodeVertexBuffer(out.data(), out.size(), elements, count, stride));
}
Bytes EncodeTriangles(const std::vector<uint32_t>& indices, size_t vertexCount) {
    std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(indices.size(), vertexCount));
    return AsBytes(out, meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), indices.size()));
}
Bytes EncodeSequence(const std::vector<uint32_t>& indices, size_t vertexCount) {
    std::vector<unsigned char> out(meshopt_encodeIndexSequenceBound(indices.size(), vertexCount));
    return AsBytes(out, meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), indices.size()));
}

struct Encoded {
    Bytes bytes;
    size_t count;
    size_t stride;
    const char* mode = "ATTRIBUTES";
    const char* filter = nullptr;
    const char* extension = kExt;
};

// A view of these elements that is only there compressed; its own buffer has no bytes.
size_t AddView(GltfDocument& document, const Encoded& encoded) {
    const size_t size = encoded.count * encoded.stride;
    const size_t compressed =
        document.Add("buffers", {{"byteLength", encoded.bytes.size()}, {"uri", DataUri(encoded.bytes)}});
    const size_t fallback = document.Add(
        "buffers", {{"byteLength", size}, {"extensions", {{encoded.extension, {{"fallback", true}}}}}});
    Json extension{{"buffer", compressed},
                   {"byteLength", encoded.bytes.size()},
                   {"byteStride", encoded.stride},
                   {"count", encoded.count},
                   {"mode", encoded.mode}};
    if (encoded.filter) extension["filter"] = encoded.filter;
    Json view{{"buffer", fallback}, {"byteLength", size}, {"extensions", {{encoded.extension, extension}}}};
    if (std::string_view(encoded.mode) == "ATTRIBUTES") view["byteStride"] = encoded.stride;
    return document.Add("bufferViews", view);
}

// A bumpy square of 12 x 12 vertices.
struct Grid {
    std::vector<float> positions, normals;
    std::vector<uint32_t> indices;
    size_t VertexCount() const { return positions.size() / 3; }

    Grid() {
        constexpr uint32_t kSide = 12;
        for (uint32_t y = 0; y < kSide; ++y)
            for (uint32_t x = 0; x < kSide; ++x) {
                const vec3 normal = glm::normalize(vec3(0.1f * float(x % 3), 0.1f * float(y % 4) - 0.1f, 1));
                positions.insert(positions.end(), {float(x), 0.5f * float(y), 0.25f * float(x * y % 5)});
                normals.insert(normals.end(), {normal.x, normal.y, normal.z});
            }
        for (uint32_t y = 0; y + 1 < kSide; ++y)
            for (uint32_t x = 0; x + 1 < kSide; ++x) {
                const uint32_t a = y * kSide + x, b = a + 1, c = a + kSide, d = c + 1;
                indices.insert(indices.end(), {a, b, c, c, b, d});
            }
    }
};

struct GridAccessors {
    size_t positions, normals, indices;
    int mode = 4;
};
GltfDocument WithMesh(GltfDocument document, const GridAccessors& accessors) {
    const size_t mesh =
        document.AddMesh({{"attributes", {{"POSITION", accessors.positions}, {"NORMAL", accessors.normals}}},
                          {"indices", accessors.indices},
                          {"mode", accessors.mode}});
    document.AddNode({{"mesh", mesh}});
    return document;
}

GltfDocument Plain(const Grid& grid, int mode = 4) {
    GltfDocument document;
    const size_t positions = document.AddAccessor(grid.positions, 3);
    const size_t normals = document.AddAccessor(grid.normals, 3);
    const size_t indices = document.AddAccessor(grid.indices, 1);
    return WithMesh(document, {positions, normals, indices, mode});
}

// `indexBytes`: 2 or 4 a compressed index. The codec of triangles may turn them around: the plain grid then
// is given the order in which they come out.
GltfDocument Compressed(const Grid& grid, const char* extension = kExt, size_t indexBytes = 2, int mode = 4) {
    GltfDocument document;
    const size_t count = grid.VertexCount();
    const auto attribute = [&](const std::vector<float>& values) {
        const size_t view = AddView(document, {EncodeAttributes(values.data(), count, 12), count, 12,
                                               "ATTRIBUTES", nullptr, extension});
        return document.AddAccessorOver(view, kFloat, count, 3, false);
    };
    const size_t positions = attribute(grid.positions), normals = attribute(grid.normals);
    const bool isList = mode == 4;
    const size_t view = AddView(
        document, {isList ? EncodeTriangles(grid.indices, count) : EncodeSequence(grid.indices, count),
                   grid.indices.size(), indexBytes, isList ? "TRIANGLES" : "INDICES", nullptr, extension});
    const size_t indices =
        document.AddAccessorOver(view, indexBytes == 2 ? kUint16 : kUint32, grid.indices.size(), 1, false);
    return WithMesh(document, {positions, normals, indices, mode});
}

// The codec may begin a triangle at another corner.
void NormalizeTriangles(std::vector<uint32_t>& indices) {
    for (size_t i = 0; i < indices.size(); i += 3)
        std::rotate(
            indices.begin() + std::ptrdiff_t(i),
            std::min_element(indices.begin() + std::ptrdiff_t(i), indices.begin() + std::ptrdiff_t(i) + 3),
            indices.begin() + std::ptrdiff_t(i) + 3);
}

TEST(Meshopt, AttributesAndTrianglesAreWhatWasEncoded) {
    const Grid grid;
    scene::SceneData expected = Load(Plain(grid));
    NormalizeTriangles(expected.meshes[0].primitives[0].indices);
    for (const char* extension : {kExt, kKhr})
        for (const size_t indexBytes : {2, 4}) {
            SCOPED_TRACE(extension);
            scene::SceneData decoded = Load(Compressed(grid, extension, indexBytes));
            NormalizeTriangles(decoded.meshes[0].primitives[0].indices);
            ExpectSame(expected, decoded);
            EXPECT_TRUE(decoded.warnings.empty());
        }
}

TEST(Meshopt, SequencesAreWhatWasEncoded) {
    const Grid grid;
    for (const size_t indexBytes : {2, 4})  // coded as a strip
        ExpectSame(Load(Plain(grid, 5)), Load(Compressed(grid, kExt, indexBytes, 5)));
}

TEST(Meshopt, OctahedralNormalsAreUnfiltered) {
    const Grid grid;
    const size_t count = grid.VertexCount();
    std::vector<float> four;
    for (size_t i = 0; i < count; ++i)
        four.insert(four.end(),
                    {grid.normals[3 * i], grid.normals[3 * i + 1], grid.normals[3 * i + 2], 0.0f});
    for (const size_t stride : {4, 8}) {
        GltfDocument document = Plain(grid);
        std::vector<std::byte> filtered(count * stride);
        meshopt_encodeFilterOct(filtered.data(), count, stride, stride == 4 ? 8 : 14, four.data());
        const size_t view = AddView(document, {EncodeAttributes(filtered.data(), count, stride), count,
                                               stride, "ATTRIBUTES", "OCTAHEDRAL"});
        document.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
            document.AddAccessorOver(view, stride == 4 ? kInt8 : kInt16, count, 3, true);
        document.json["extensionsUsed"] = {"KHR_mesh_quantization"};
        const scene::SceneData scene = Load(document);
        const std::vector<vec3>& normals = OnlyPrimitive(scene).normals;
        ASSERT_EQ(normals.size(), count);
        for (size_t i = 0; i < count; ++i)
            EXPECT_LT(glm::distance(normals[i], vec3(four[4 * i], four[4 * i + 1], four[4 * i + 2])),
                      stride == 4 ? 0.03f : 0.0005f);
    }
}

TEST(Meshopt, ExponentialsAreUnfiltered) {
    const Grid grid;
    const size_t count = grid.VertexCount();
    GltfDocument document = Plain(grid);
    std::vector<std::byte> filtered(count * 12);
    EncodeExponentials(filtered.data(), count, 12, 20, grid.positions.data());
    const size_t view = AddView(
        document, {EncodeAttributes(filtered.data(), count, 12), count, 12, "ATTRIBUTES", "EXPONENTIAL"});
    document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
        document.AddAccessorOver(view, kFloat, count, 3, false);
    const scene::SceneData scene = Load(document);
    const std::vector<vec3>& positions = OnlyPrimitive(scene).positions;
    ASSERT_EQ(positions.size(), count);
    for (size_t i = 0; i < count; ++i)
        EXPECT_LT(glm::distance(positions[i], vec3(grid.positions[3 * i], grid.positions[3 * i + 1],
                                                   grid.positions[3 * i + 2])),
                  1e-3f);
}

// The quaternions are rotations of instances.
TEST(Meshopt, QuaternionsAreUnfiltered) {
    GltfDocument document;
    document.AddTriangle();
    const float h = std::sqrt(0.5f);
    const std::vector<float> turns{0, 0, h, h, 0, 0, 0, 1, h, 0, 0, h};
    std::vector<std::byte> filtered(3 * 8);
    meshopt_encodeFilterQuat(filtered.data(), 3, 8, 14, turns.data());
    const size_t view =
        AddView(document, {EncodeAttributes(filtered.data(), 3, 8), 3, 8, "ATTRIBUTES", "QUATERNION"});
    document.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["ROTATION"] =
        document.AddAccessorOver(view, kInt16, 3, 4, true);
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 3u);
    const vec3 turned[] = {{0, 1, 0}, {1, 0, 0}, {1, 0, 0}};
    for (size_t i = 0; i < 3; ++i)
        EXPECT_LT(glm::distance(scene.instances[i].objectToWorld[0], turned[i]), 1e-3f) << i;
    EXPECT_LT(glm::distance(scene.instances[2].objectToWorld[1], vec3(0, 0, 1)), 1e-3f);
}

TEST(Meshopt, FallbackBuffersAreNeverOpened) {
    GltfDocument document = Compressed(Grid());
    document.json["buffers"][1]["uri"] = "not_there.bin";
    document.json["buffers"][3].erase("extensions");  // one that says nothing of itself
    EXPECT_EQ(LoadError(document), "loaded");
    const std::string fallback = "buffers[1] is a fallback, only compressed views may be in it";
    GltfDocument plain = document;
    plain.json["bufferViews"][0].erase("extensions");
    EXPECT_EQ(LoadError(plain), "scene.gltf: bufferViews[0].buffer: " + fallback);
    document.json["bufferViews"][0]["extensions"][kExt]["buffer"] = 1;
    document.json["bufferViews"][0]["extensions"][kExt]["byteLength"] = 4;
    EXPECT_EQ(LoadError(document),
              "scene.gltf: bufferViews[0].extensions.EXT_meshopt_compression.buffer: " + fallback);
}

TEST(Meshopt, BrokenRulesAreRefused) {
    const GltfDocument document = Compressed(Grid());
    const auto refused = [&](size_t view, const Json& changes, const std::string& message) {
        GltfDocument changed = document;
        changed.json["bufferViews"][view]["extensions"][kExt].update(changes);
        EXPECT_EQ(LoadError(changed), "scene.gltf: bufferViews[" + std::to_string(view) +
                                          "].extensions.EXT_meshopt_compression" + message);
    };
    refused(0, {{"byteStride", 6}}, ": byteStride is 6, must be a multiple of 4 up to 256 for ATTRIBUTES");
    refused(0, {{"byteStride", 16}}, ".byteStride: is 16, but the view's byteStride is 12");
    refused(0, {{"count", 143}}, ".count: 143 elements of 12 bytes are not the view's 1728 bytes");
    refused(0, {{"count", 1ull << 53}},
            ".count: 9007199254740992 elements of 12 bytes are not the view's 1728 bytes");
    refused(0, {{"filter", "OCTAHEDRAL"}}, ": byteStride is 12, must be 4 or 8 for OCTAHEDRAL");
    refused(0, {{"filter", "QUATERNION"}}, ": byteStride is 12, must be 8 for QUATERNION");
    refused(0, {{"filter", "COLOR"}},
            ".filter: is \"COLOR\", must be NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL");
    refused(0, {{"mode", "POINTS"}}, ".mode: is \"POINTS\", must be ATTRIBUTES, TRIANGLES or INDICES");
    refused(0, {{"byteOffset", 1ull << 53}},
            ".byteLength: " + std::to_string(document.json["buffers"][0]["byteLength"].get<size_t>()) +
                " bytes from 9007199254740992 exceed buffers[0] (" +
                std::to_string(document.json["buffers"][0]["byteLength"].get<size_t>()) + " bytes)");
    refused(0, {{"byteLength", 3000}},
            ".byteLength: 3000 bytes from 0 exceed buffers[0] (" +
                std::to_string(document.json["buffers"][0]["byteLength"].get<size_t>()) + " bytes)");
    refused(2, {{"byteStride", 8}}, ": byteStride is 8, must be 2 or 4 for TRIANGLES");
    refused(2, {{"count", 725}}, ": count is 725, must be a multiple of 3 for TRIANGLES");
    refused(2, {{"filter", "EXPONENTIAL"}}, ": TRIANGLES cannot have a filter");
    GltfDocument both = document;
    both.json["bufferViews"][0]["extensions"][kKhr] = both.json["bufferViews"][0]["extensions"][kExt];
    EXPECT_EQ(LoadError(both),
              "scene.gltf: bufferViews[0].extensions: has both EXT_meshopt_compression and "
              "KHR_meshopt_compression");
    GltfDocument color = Compressed(Grid(), kKhr);
    color.json["bufferViews"][0]["extensions"][kKhr]["filter"] = "COLOR";
    EXPECT_EQ(LoadError(color),
              "scene.gltf: bufferViews[0].extensions.KHR_meshopt_compression.filter: is "
              "\"COLOR\", which is not decoded");
}

TEST(Meshopt, DamagedBytesAreRefused) {
    const Grid grid;
    Bytes encoded = EncodeAttributes(grid.positions.data(), grid.VertexCount(), 12);
    const auto error = [&](const Bytes& bytes) {
        GltfDocument document = Plain(grid);
        const size_t view = AddView(document, {bytes, grid.VertexCount(), 12});
        document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
            document.AddAccessorOver(view, kFloat, grid.VertexCount(), 3, false);
        return LoadError(document);
    };
    EXPECT_EQ(error(encoded), "loaded");
    const std::string at = "scene.gltf: bufferViews[3].extensions.EXT_meshopt_compression: ";
    const Bytes half(encoded.begin(), encoded.begin() + 200);
    EXPECT_EQ(error(half), at + "200 bytes are no ATTRIBUTES of 144 elements of 12 bytes");
    encoded[0] = std::byte{0xA7};
    EXPECT_EQ(error(encoded).find(at + "is of version 7 of the codec, which meshoptimizer "), 0u);
    encoded[0] = std::byte{0x00};
    EXPECT_NE(error(encoded).find(" bytes are no ATTRIBUTES of "), std::string::npos);
}

// A few bytes that claim to be gigabytes.
TEST(Meshopt, MemoryIsChargedBeforeItIsTaken) {
    GltfDocument document = Compressed(Grid());
    constexpr uint64_t kCount = 1ull << 40;
    document.json["buffers"][1]["byteLength"] = document.json["bufferViews"][0]["byteLength"] = kCount * 12;
    document.json["bufferViews"][0]["extensions"][kExt]["count"] = kCount;
    EXPECT_EQ(
        LoadError(document).find("scene.gltf: bufferViews[0].extensions.EXT_meshopt_compression: decoded "
                                 "geometry exceeds the limit of "),
        0u)
        << LoadError(document);
}

TEST(Meshopt, SavingKeepsItAndItsFallback) {
    SceneFolder folder;
    GltfDocument document = Compressed(Grid());
    document.json["buffers"][1]["uri"] = "not_there.bin";
    document.json["buffers"][3]["uri"] = "there.bin";
    folder.Write("there.bin", "some bytes");
    const std::filesystem::path source = folder.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    edited.nodes[0].translation = {1, 2, 3};
    scene::UpdateWorldTransforms(edited);
    const TemporaryFolder other;
    scene::SaveGltf(source, edited, other / "saved.gltf");
    ExpectSame(edited, scene::LoadGltf(other / "saved.gltf"));
    EXPECT_TRUE(std::filesystem::exists(other / "there.bin"));
    std::ifstream text(other / "saved.gltf");
    EXPECT_EQ(Json::parse(text)["bufferViews"], document.json["bufferViews"]);
}

// Worth most under AddressSanitizer.
TEST(Meshopt, ChangedBytesLoadOrEndWithOneLine) {
    const Grid grid;
    std::mt19937 random(7);
    const auto below = [&](size_t bound) { return size_t{random()} % bound; };
    size_t loadedCount = 0, refusedCount = 0;
    for (const int mode : {4, 5})
        for (int round = 0; round < 600; ++round) {
            GltfDocument document = Compressed(grid, kExt, 2 + 2 * (round % 2), mode);
            for (const size_t view : {0, 2}) {
                Json& extension = document.json["bufferViews"][view]["extensions"][kExt];
                const size_t buffer = extension["buffer"];
                Bytes bytes = view == 0   ? EncodeAttributes(grid.positions.data(), grid.VertexCount(), 12)
                              : mode == 4 ? EncodeTriangles(grid.indices, grid.VertexCount())
                                          : EncodeSequence(grid.indices, grid.VertexCount());
                for (size_t i = 0; i < below(4); ++i) bytes[below(bytes.size())] = std::byte(random());
                if (below(4) == 0) bytes.resize(1 + below(bytes.size()));
                document.json["buffers"][buffer] = {{"byteLength", bytes.size()}, {"uri", DataUri(bytes)}};
                extension["byteLength"] = bytes.size();
                if (view == 0 && below(3) == 0) extension["filter"] = "EXPONENTIAL";
            }
            const std::string result = LoadError(document);
            ++(result == "loaded" ? loadedCount : refusedCount);
            ASSERT_TRUE(result == "loaded" || result.starts_with("scene.gltf: ")) << result;
            ASSERT_EQ(result.find('\n'), std::string::npos);
        }
    EXPECT_GT(loadedCount, 20u);
    EXPECT_GT(refusedCount, 100u);
}

// Joints, weights, displacements, times and values: what an accessor reads may be compressed, whatever it is for.
TEST(Meshopt, WhatMovesIsWhatWasEncoded) {
    GltfDocument plain = SkinnedTriangle();
    Json& primitive = plain.json["meshes"][0]["primitives"][0];
    const std::vector<float> shifts{0, 0, 1, 0, 2, 0, 3, 0, 0}, times{0, 1, 3},
        places{1, 2, 3, 4, 5, 6, 7, 8, 9};
    primitive["targets"] = {{{"POSITION", plain.AddAccessor(shifts, 3)}}};
    Animate(plain, {{"node", 1}, {"path", "translation"}}, times, places, 3);
    GltfDocument document = plain;
    const auto compress = [&](size_t accessor, const void* elements, size_t stride) {
        document.json["accessors"][accessor]["bufferView"] =
            AddView(document, {EncodeAttributes(elements, 3, stride), 3, stride});
    };
    const std::vector<uint8_t> joints{0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};
    const std::vector<float> weights{1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0};
    compress(primitive["attributes"]["JOINTS_0"], joints.data(), 4);
    compress(primitive["attributes"]["WEIGHTS_0"], weights.data(), 16);
    compress(primitive["targets"][0]["POSITION"], shifts.data(), 12);
    compress(plain.json["animations"][0]["samplers"][0]["input"], times.data(), 4);
    compress(plain.json["animations"][0]["samplers"][0]["output"], places.data(), 12);
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.animations.at(0).channels.size(), 1u);
    ExpectSame(Load(plain), scene);
}

}  // namespace
}  // namespace raygraph::test::import_meshopt_test

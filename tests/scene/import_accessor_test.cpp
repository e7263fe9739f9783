// Numbers out of accessors: component types, strides, normalization, sparse ones, and every way they can be
// wrong.
#include <gtest/gtest.h>

#include <limits>

#include "tests/scene/gltf_document.h"

namespace raygraph::test::import_accessor_test {
namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;

// A triangle whose TEXCOORD_0 is an accessor of the given integers.
template <typename T>
std::vector<vec2> LoadTexCoords(const std::vector<T>& values, bool isNormalized) {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["attributes"]["TEXCOORD_0"] = document.AddAccessor(values, 2, isNormalized);
    return OnlyPrimitive(Load(document)).uv0;
}

TEST(Accessor, NormalizedIntegersCoverZeroToOne) {
    EXPECT_EQ(LoadTexCoords<uint8_t>({0, 255, 51, 0, 0, 0}, true),
              (std::vector<vec2>{{0, 1}, {0.2f, 0}, {0, 0}}));
    EXPECT_EQ(LoadTexCoords<uint16_t>({0, 65535, 13107, 0, 0, 0}, true),
              (std::vector<vec2>{{0, 1}, {0.2f, 0}, {0, 0}}));
}

TEST(Accessor, SignedNormalizedIntegersReachMinusOneTwice) {
    EXPECT_EQ(LoadTexCoords<int8_t>({-128, -127, 127, 0, 0, 0}, true),
              (std::vector<vec2>{{-1, -1}, {1, 0}, {0, 0}}));
    EXPECT_EQ(LoadTexCoords<int16_t>({-32768, -32767, 32767, 0, 0, 0}, true),
              (std::vector<vec2>{{-1, -1}, {1, 0}, {0, 0}}));
}

TEST(Accessor, PlainIntegersKeepTheirValue) {
    EXPECT_EQ(LoadTexCoords<int16_t>({-300, 7, 1, 2, 3, 4}, false),
              (std::vector<vec2>{{-300, 7}, {1, 2}, {3, 4}}));
    EXPECT_EQ(LoadTexCoords<uint8_t>({200, 7, 1, 2, 3, 4}, false),
              (std::vector<vec2>{{200, 7}, {1, 2}, {3, 4}}));
}

TEST(Accessor, InterleavedStreamsShareOneView) {
    // position.xyz, normal.xyz, a byte pair padded to four.
    Bytes bytes;
    for (int i = 0; i < 3; ++i) {
        const std::vector<float> vertex{
            static_cast<float>(i), static_cast<float>(i * i), 2.0f, 0.0f, 0.0f, 1.0f};
        const Bytes part = BytesOf(vertex);
        bytes.insert(bytes.end(), part.begin(), part.end());
        for (int k : {255, 0, 99, 99}) bytes.push_back(static_cast<std::byte>(k));
    }
    GltfDocument document;
    const size_t view = document.AddBufferView(bytes);
    document.json["bufferViews"][view]["byteStride"] = 28;
    const size_t positions = document.AddAccessorOver(view, kFloat, 3, 3, false);
    const size_t normals = document.AddAccessorOver(view, kFloat, 3, 3, false);
    document.json["accessors"][normals]["byteOffset"] = 12;
    const size_t uv = document.AddAccessorOver(view, kUint8, 3, 2, true);
    document.json["accessors"][uv]["byteOffset"] = 24;
    const size_t mesh = document.AddMesh(
        {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uv}}}});
    document.AddNode({{"mesh", mesh}});

    const scene::SceneData scene = Load(document);
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    EXPECT_EQ(primitive.positions, (std::vector<vec3>{{0, 0, 2}, {1, 1, 2}, {2, 4, 2}}));
    EXPECT_EQ(primitive.normals, std::vector<vec3>(3, vec3(0, 0, 1)));
    EXPECT_EQ(primitive.uv0, std::vector<vec2>(3, vec2(1, 0)));
}

// A triangle with POSITION replaced element by element from a sparse part.
struct SparseTriangle {
    GltfDocument document;
    size_t accessor = 0;

    explicit SparseTriangle(std::vector<uint16_t> indices, bool hasBase = true) {
        document.AddTriangle();
        accessor = document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<size_t>();
        const size_t indexView = document.AddBufferView(BytesOf(indices));
        std::vector<float> values;
        for (size_t i = 0; i < 3 * indices.size(); ++i) values.push_back(10.0f + static_cast<float>(i));
        const size_t valueView = document.AddBufferView(BytesOf(values));
        Json& json = document.json["accessors"][accessor];
        if (!hasBase) json.erase("bufferView");
        json["sparse"] = {{"count", indices.size()},
                          {"indices", {{"bufferView", indexView}, {"componentType", kUint16}}},
                          {"values", {{"bufferView", valueView}}}};
    }
};

TEST(Accessor, SparseValuesReplaceThoseOfTheBase) {
    EXPECT_EQ(OnlyPrimitive(Load(SparseTriangle({0, 2}).document)).positions,
              (std::vector<vec3>{{10, 11, 12}, {1, 0, 0}, {13, 14, 15}}));
}

TEST(Accessor, SparseWithoutBaseIsZeroElsewhere) {
    EXPECT_EQ(OnlyPrimitive(Load(SparseTriangle({1}, false).document)).positions,
              (std::vector<vec3>{{0, 0, 0}, {10, 11, 12}, {0, 0, 0}}));
}

TEST(Accessor, SparseValuesReachSplitVertices) {
    // No normals: vertices are split, read through a list, and the sparse part must follow.
    SparseTriangle sparse({1});
    Json& primitive = sparse.document.json["meshes"][0]["primitives"][0];
    primitive["attributes"].erase("NORMAL");
    const size_t indices = sparse.document.AddAccessor<uint8_t>({2, 1, 0, 1, 2, 0}, 1);
    sparse.document.json["meshes"][0]["primitives"][0]["indices"] = indices;
    EXPECT_EQ(OnlyPrimitive(Load(sparse.document)).positions,
              (std::vector<vec3>{{0, 1, 0}, {10, 11, 12}, {0, 0, 0}, {10, 11, 12}, {0, 1, 0}, {0, 0, 0}}));
}

TEST(Accessor, SparseIndicesOutOfRangeAreRefused) {
    EXPECT_EQ(LoadError(SparseTriangle({3}).document),
              "scene.gltf: accessors[0].sparse.indices: element 0 is 3, but the accessor has 3 elements");
}

TEST(Accessor, SparseIndicesThatDoNotRiseAreRefused) {
    EXPECT_EQ(LoadError(SparseTriangle({1, 1}).document),
              "scene.gltf: accessors[0].sparse.indices: element 1 is 1, not greater than the one before it");
}

TEST(Accessor, SparseCountAboveTheAccessorsIsRefused) {
    EXPECT_EQ(LoadError(SparseTriangle({0, 1, 2, 3}).document),
              "scene.gltf: accessors[0].sparse.count: is 4, more than the accessor's 3 elements");
}

TEST(Accessor, SparsePartsBeyondTheirViewsAreRefused) {
    constexpr const char* kIndices = "/accessors/0/sparse/indices/byteOffset";
    constexpr const char* kValues = "/accessors/0/sparse/values/byteOffset";
    constexpr uint64_t kMuch = uint64_t{1} << 40;  // more than an int holds
    ExpectRefused(
        SparseTriangle({0, 1}).document,
        {{kIndices, 2, "accessors[0].sparse.count: 2 elements from byte 2 exceed bufferViews[2] (4 bytes)"},
         {kIndices, kMuch,
          "accessors[0].sparse.count: 2 elements from byte 1099511627776 exceed bufferViews[2] (4 bytes)"},
         {kValues, 4, "accessors[0].sparse.count: 2 elements from byte 4 exceed bufferViews[3] (24 bytes)"},
         {kValues, kMuch,
          "accessors[0].sparse.count: 2 elements from byte 1099511627776 exceed bufferViews[3] (24 bytes)"},
         {"/accessors/0/sparse/count", kMuch,
          "accessors[0].sparse.count: is 1099511627776, more than the accessor's 3 elements"}});
}

TEST(Accessor, SparseIndicesMustBeUnsigned) {
    ExpectRefused(SparseTriangle({0}).document,
                  {{"/accessors/0/sparse/indices/componentType", kFloat,
                    "accessors[0].sparse.indices.componentType: is 5126, must be 5121, 5123 or 5125"}});
}

// Makes a document whose accessors[0] is POSITION: 3 x VEC3 float, 36 bytes.
GltfDocument Triangle() {
    GltfDocument document;
    document.AddTriangle();
    return document;
}

TEST(Accessor, CountBeyondTheViewIsRefused) {
    ExpectRefused(Triangle(), {{"/accessors/0/count", 4,
                                "accessors[0].count: 4 elements exceed bufferViews[0] (36 bytes)"}});
}

TEST(Accessor, CountThatOverflowsIsRefused) {
    ExpectRefused(Triangle(),
                  {{"/accessors/0/count", 4611686018427387904u,
                    "accessors[0].count: 4611686018427387904 elements exceed bufferViews[0] (36 bytes)"},
                   {"/accessors/0/count", std::numeric_limits<uint64_t>::max(),
                    "accessors[0].count: 18446744073709551615 elements exceed bufferViews[0] (36 bytes)"}});
}

TEST(Accessor, ByteOffsetThatOverflowsIsRefused) {
    ExpectRefused(
        Triangle(),
        {{"/accessors/0/byteOffset", std::numeric_limits<uint64_t>::max() - 3,
          "accessors[0].count: 3 elements from byte 18446744073709551612 exceed bufferViews[0] (36 bytes)"}});
}

TEST(Accessor, HugeCountWithoutAViewIsRefused) {
    GltfDocument document;
    document.AddTriangle();
    for (size_t i = 0; i < 2; ++i) {
        document.json["accessors"][i].erase("bufferView");
        document.json["accessors"][i]["count"] = 4611686018427387904u;
    }
    EXPECT_EQ(LoadError(document),
              "scene.gltf: accessors[0].count: is 4611686018427387904, must be below 2^32 - 1");
    for (size_t i = 0; i < 2; ++i) document.json["accessors"][i]["count"] = 4000000000u;
    const std::string message = LoadError(document);
    EXPECT_NE(message.find("decoded geometry exceeds the limit of"), std::string::npos) << message;
}

TEST(Accessor, CountOfTheWrongTypeIsRefused) {
    constexpr const char* kCount = "/accessors/0/count";
    ExpectRefused(
        Triangle(),
        {{kCount, 0, "accessors[0].count: is 0, must be at least 1"},
         {kCount, -1, "accessors[0].count: is -1, must be a whole number of at least 0"},
         {kCount, 2.5, "accessors[0].count: is 2.5, must be a whole number of at least 0"},
         {kCount, "3", "accessors[0].count: is \"3\", must be a whole number of at least 0"},
         {kCount, nullptr, "accessors[0].count: is null, must be a whole number of at least 0"},
         {kCount, Json::array({3}), "accessors[0].count: is an array, must be a whole number of at least 0"},
         {kCount, 1e300, "accessors[0].count: is 1e+300, must be a whole number of at least 0"}});
}

TEST(Accessor, IntegerWrittenAsFloatIsTaken) {
    ExpectRefused(Triangle(), {{"/accessors/0/count", 3.0, "loaded"}});
}

TEST(Accessor, UnknownTypesAreRefused) {
    ExpectRefused(Triangle(),
                  {{"/accessors/0/componentType", 5124,
                    "accessors[0].componentType: is 5124, must be 5120, 5121, 5122, 5123, 5125 or 5126"},
                   {"/accessors/0/type", "VEC5",
                    "accessors[0].type: is \"VEC5\", must be SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4"},
                   {"/accessors/0/normalized", 1, "accessors[0].normalized: is 1, must be true or false"}});
}

TEST(Accessor, ViewThatDoesNotExistIsRefused) {
    ExpectRefused(Triangle(), {{"/accessors/0/bufferView", 2,
                                "accessors[0].bufferView: is 2, but there are 2 bufferViews"}});
}

TEST(Accessor, NotANumberInVerticesIsRefused) {
    GltfDocument document;
    document.AddTriangle();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const size_t bad = document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, nan, 0}, 3);
    document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = bad;
    EXPECT_EQ(LoadError(document), "scene.gltf: accessors[2]: element 2 is not finite");
    const size_t infinite =
        document.AddAccessor<float>({0, std::numeric_limits<float>::infinity(), 0, 1, 0, 0, 0, 0, 0}, 3);
    document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = infinite;
    EXPECT_EQ(LoadError(document), "scene.gltf: accessors[3]: element 0 is not finite");
}

TEST(BufferView, OutsideItsBufferIsRefused) {
    ExpectRefused(
        Triangle(),
        {{"/bufferViews/0/byteOffset", 1,
          "bufferViews[0].byteLength: 36 bytes from 1 exceed buffers[0] (36 bytes)"},
         {"/bufferViews/0/byteOffset", std::numeric_limits<uint64_t>::max(),
          "bufferViews[0].byteLength: 36 bytes from 18446744073709551615 exceed buffers[0] (36 bytes)"},
         {"/bufferViews/0/buffer", 7, "bufferViews[0].buffer: is 7, but there are 2 buffers"}});
}

TEST(BufferView, StrideOutOfRangeIsRefused) {
    constexpr const char* kStride = "/bufferViews/0/byteStride";
    ExpectRefused(
        Triangle(),
        {{kStride, 256, "bufferViews[0].byteStride: is 256, must be 4 to 252"},
         {kStride, 0, "bufferViews[0].byteStride: is 0, must be 4 to 252"},
         {kStride, 8,
          "accessors[0].bufferView: bufferViews[0].byteStride of 8 is less than the element's 12 bytes"}});
}

// glTF asks for multiples of 4, but all that is wrong with others is that they are slow to read.
TEST(BufferView, StrideNeedNotBeAMultipleOfFour) {
    const std::vector<glm::vec3> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    constexpr size_t kStride = 14;
    Bytes bytes(2 * kStride + sizeof(glm::vec3));
    for (size_t i = 0; i < positions.size(); ++i)
        std::memcpy(&bytes[kStride * i], &positions[i], sizeof(glm::vec3));
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    const size_t view = document.AddBufferView(bytes);
    primitive["attributes"] = {{"POSITION", document.AddAccessorOver(view, kFloat, 3, 3, false)}};
    document.json["bufferViews"][view]["byteStride"] = kStride;
    EXPECT_EQ(OnlyPrimitive(Load(document)).positions, positions);
}

TEST(Buffer, ShorterThanItsByteLengthIsRefused) {
    ExpectRefused(Triangle(), {{"/buffers/0/byteLength", 40,
                                "buffers[0].byteLength: is 40, but the buffer has 36 bytes"}});
}

}  // namespace
}  // namespace raygraph::test::import_accessor_test

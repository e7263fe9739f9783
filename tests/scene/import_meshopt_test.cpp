// EXT_meshopt_compression and KHR_meshopt_compression: what is decoded is what was encoded, and hostile bytes
// end with one line.
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/motion_document.h"
#include "tests/scene/same_scene.h"
#include "tests/support/encode_exponentials.h"

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

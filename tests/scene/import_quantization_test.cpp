// KHR_mesh_quantization: every type that it adds is read as its value, on a mesh as a whole; what it does not
// allow is refused, and what takes it is told of where the file does not name it.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/scene/gltf_document.h"

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

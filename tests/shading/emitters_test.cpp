// Tests which triangles of a mesh may emit, and the effect of their texture.
#include "renderer/gpu_scene/lights/emitters.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raygraph::emitters_test {
namespace {

// Two triangles, the halves of a square whose texture coordinates run over (low..high)^2.
scene::Primitive Square(float low, float high, uint32_t material = 0) {
    scene::Primitive square;
    square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.uv0 = {{low, low}, {high, low}, {high, high}, {low, high}};
    square.indices = {0, 1, 2, 0, 2, 3};
    square.material = material;
    return square;
}

class Emitters : public ::testing::Test {
  protected:
    void SetUp() override {
        scene.materials.resize(1);
        scene.materials[0].emissiveFactor = glm::vec3(1.0f);
    }

    // The texel at (x, y) is white where lit(x, y), else black.
    template <typename Lit>
    void SetTexture(uint32_t size, Lit&& lit, scene::WrapMode wrap = scene::WrapMode::Repeat) {
        scene::ImageData image{.name = {}, .width = size, .height = size, .rgba = {}};
        for (uint32_t y = 0; y < size; ++y)
            for (uint32_t x = 0; x < size; ++x)
                image.rgba.insert(image.rgba.end(), 4, lit(x, y) ? uint8_t{255} : uint8_t{0});
        scene.images = {image};
        scene.textures = {{.name = {}, .image = 0, .sampler = {.wrapU = wrap, .wrapV = wrap}}};
        scene.textures[0].colorSpace = scene::ColorSpace::Srgb;
        scene.materials[0].emissiveTexture.texture = 0;
    }

    std::vector<Emitter> Find(std::vector<scene::Primitive> primitives) {
        std::vector<scene::Primitive*> pointers;
        GroupTriangles triangles;
        for (uint32_t i = 0; i < primitives.size(); ++i) {
            const scene::Primitive& primitive = primitives[i];
            const auto first = static_cast<uint32_t>(triangles.positions.size());
            triangles.firstVertices.push_back(first);
            triangles.positions.insert(triangles.positions.end(), primitive.positions.begin(),
                                       primitive.positions.end());
            for (const uint32_t index : primitive.indices) triangles.indices.push_back(first + index);
            triangles.geometries.insert(triangles.geometries.end(), primitive.TriangleCount(), i);
            pointers.push_back(&primitives[i]);
        }
        return EmitterFinder(scene).Find(triangles, pointers, true).emitters;
    }

    scene::SceneData scene;
};

TEST_F(Emitters, AreTheTrianglesOfMaterialsThatEmit) {
    scene.materials.resize(3);
    scene.materials[2].emissiveFactor = glm::vec3(0.0f, 2.0f, 0.0f);
    const std::vector<Emitter> emitters = Find({Square(0, 1, 1), Square(0, 1, 2), Square(0, 1, 1)});
    ASSERT_EQ(emitters.size(), 2u);
    EXPECT_EQ(emitters[0].primitive, 2u);
    EXPECT_EQ(emitters[1].primitive, 3u);
    EXPECT_EQ(emitters[1].material, 2u);
    EXPECT_EQ(emitters[1].p2, glm::vec3(0, 1, 0));
    EXPECT_TRUE(emitters[1].isDoubleSided);
    EXPECT_EQ(TriangleLights(emitters, 6),
              (std::vector<uint32_t>{gpu::kNoLight, gpu::kNoLight, 0, 1, gpu::kNoLight, gpu::kNoLight}));
    EXPECT_TRUE(Find({Square(0, 1, 1)}).empty());
    EXPECT_TRUE(TriangleLights({}, 6).empty());
}

TEST_F(Emitters, TextureIsReadWhereItsTransformSays) {
    // The left half is lit
    SetTexture(64, [](uint32_t x, uint32_t) { return x < 32; });
    scene::TextureTransform& transform = scene.materials[0].emissiveTexture.transform;
    transform.scale = glm::vec2(0.25f);
    EXPECT_EQ(Find({Square(0, 1)}).size(), 2u);
    transform.offset = {0.625f, 0.0f};
    EXPECT_TRUE(Find({Square(0, 1)}).empty());
    transform.offset = {0.125f, 0.625f};
    EXPECT_EQ(Find({Square(0, 1)}).size(), 2u);
    // A quarter turn: u of the image is v of the square, and v goes against its u
    transform.rotation = 1.5707963f;
    EXPECT_EQ(Find({Square(0, 1)}).size(), 2u);
    transform.offset = {0.625f, 0.625f};
    EXPECT_TRUE(Find({Square(0, 1)}).empty());
}

TEST_F(Emitters, TextureCountsByItsMeanOverTheTriangle) {
    // White above the diagonal from (0, 0) to (1, 1), which is the edge between the two triangles
    SetTexture(64, [](uint32_t x, uint32_t y) { return x > y; });
    const std::vector<Emitter> emitters = Find({Square(0, 1)});
    ASSERT_EQ(emitters.size(), 2u);
    EXPECT_NEAR(emitters[0].meanTexture.x, 1.0f, 0.05f) << "below in v, right in u: white";
    EXPECT_NEAR(emitters[1].meanTexture.x, 0.0f, 0.05f);
}

TEST_F(Emitters, TrianglesOfABlackPartOfTheTextureAreLeftOut) {
    SetTexture(64, [](uint32_t x, uint32_t y) { return x == 40 && y == 40; });
    EXPECT_TRUE(Find({Square(0.0f, 0.5f)}).empty());
    EXPECT_TRUE(Find({Square(3.0f, 3.5f)}).empty()) << "repeated";
    EXPECT_EQ(Find({Square(0.6f, 0.65f)}).size(), 2u) << "one texel is enough";
    EXPECT_EQ(Find({Square(0.0f, 0.63f)}).size(), 2u) << "and so is its share in the one beside it";
    for (const Emitter& emitter : Find({Square(0.0f, 1.0f)})) EXPECT_GT(emitter.meanTexture.x, 0.0f);
}

TEST_F(Emitters, TextureCoordinatesBeyondTheEdgeFollowTheSampler) {
    const auto leftEdge = [](uint32_t x, uint32_t) { return x < 16; };
    SetTexture(64, leftEdge, scene::WrapMode::ClampToEdge);
    EXPECT_NEAR(Find({Square(-3.0f, -2.0f)}).at(0).meanTexture.x, 1.0f, 1e-6f);
    EXPECT_TRUE(Find({Square(2.0f, 3.0f)}).empty());
    SetTexture(64, leftEdge, scene::WrapMode::Repeat);
    EXPECT_NEAR(Find({Square(2.01f, 2.2f)}).at(0).meanTexture.x, 1.0f, 1e-6f);
    EXPECT_TRUE(Find({Square(-0.5f, -0.1f)}).empty());
    SetTexture(64, leftEdge, scene::WrapMode::MirroredRepeat);
    EXPECT_NEAR(Find({Square(1.8f, 1.99f)}).at(0).meanTexture.x, 1.0f, 1e-6f);
    EXPECT_NEAR(Find({Square(-0.2f, -0.01f)}).at(0).meanTexture.x, 1.0f, 1e-6f);
}

TEST_F(Emitters, ColorsAreDecodedFromSrgb) {
    SetTexture(2, [](uint32_t, uint32_t) { return true; });
    for (uint8_t& value : scene.images[0].rgba) value = 188;
    EXPECT_NEAR(Find({Square(0, 1)}).at(0).meanTexture.y, 0.5029f, 1e-3f);
    scene.textures[0].colorSpace = scene::ColorSpace::Linear;
    EXPECT_NEAR(Find({Square(0, 1)}).at(0).meanTexture.y, 188.0f / 255.0f, 1e-5f);
}

TEST_F(Emitters, AbsurdTextureCoordinatesDoNoHarm) {
    SetTexture(4, [](uint32_t x, uint32_t) { return x > 0; });
    for (const float value : {1e30f, -1e30f, 3e9f, 1e-40f})
        EXPECT_NO_THROW(Find({Square(-value, value), Square(value, value)}));
}

}  // namespace
}  // namespace raygraph::emitters_test

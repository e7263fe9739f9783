// Any-hit shaders run where alpha can be below one, and nowhere else.
#include "renderer/gpu_scene/geometry/alpha_bounds.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::alpha_bounds_test {

namespace {

constexpr auto kMask = scene::AlphaMode::Mask, kBlend = scene::AlphaMode::Blend,
               kOpaque = scene::AlphaMode::Opaque;

class AlphaBounds : public VulkanTest {
  protected:
    // Whether rays are tested for alpha on a square whose alpha is the product of these; in its texture and
    // among its vertices there are others of alpha 1.
    bool IsTested(scene::AlphaMode mode, float factor, float vertexAlpha, uint8_t texelAlpha) {
        scene::Material material = Lambert(glm::vec3(0.5f));
        material.alphaMode = mode;
        material.alphaCutoff = 0.5f;
        material.baseColorFactor.a = factor;
        material.baseColorTexture.texture = 0;
        scene::Mesh mesh = QuadMesh(0.5f);
        mesh.primitives[0].uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
        mesh.primitives[0].colors.assign(4, glm::vec4(0.5f, 1.0f, 0.25f, 1.0f));
        mesh.primitives[0].colors[2].a = vertexAlpha;
        scene::SceneData scene = SceneOf({mesh}, {material});
        scene.images = {{.name = "", .width = 2, .height = 1, .rgba = {9, 9, 9, 255, 9, 9, 9, texelAlpha}}};
        scene.textures = {{.name = "", .image = 0}};
        render.scene.SetScene(std::move(scene));
        return HasAlpha();
    }
    bool HasAlpha() {
        render.renderer.BeginFrame();
        const bool hasAlpha = render.scene.Declare(render.renderer).features.Has(kTraceAnyHit);
        render.renderer.Execute();
        return hasAlpha;
    }
    SceneRender render{Device()};
};

}  // namespace

TEST_F(AlphaBounds, OpaqueMaterialsAreNeverTested) {
    EXPECT_FALSE(IsTested(kOpaque, 0.0f, 0.0f, 0));
}

TEST_F(AlphaBounds, ColorsAndTexturesWithoutAlphaAreNotTested) {
    EXPECT_FALSE(IsTested(kBlend, 1.0f, 1.0f, 255));
    EXPECT_FALSE(IsTested(kMask, 1.0f, 1.0f, 255));
    EXPECT_FALSE(IsTested(kMask, 0.6f, 1.0f, 255)) << "above the cutoff everywhere";
    EXPECT_FALSE(IsTested(kMask, 1.0f, 0.9f, 230)) << "and so is the product";
}

TEST_F(AlphaBounds, EachThatMayBeBelowIsTested) {
    EXPECT_TRUE(IsTested(kBlend, 0.99f, 1.0f, 255));
    EXPECT_TRUE(IsTested(kBlend, 1.0f, 0.99f, 255));
    EXPECT_TRUE(IsTested(kBlend, 1.0f, 1.0f, 254));
    EXPECT_TRUE(IsTested(kMask, 0.4f, 1.0f, 255));
    EXPECT_TRUE(IsTested(kMask, 1.0f, 0.4f, 255));
    EXPECT_TRUE(IsTested(kMask, 1.0f, 1.0f, 100));
    EXPECT_TRUE(IsTested(kMask, 1.0f, 0.7f, 170)) << "their product is below the cutoff";
}

// The texture and the colors stay known when the factor is edited.
TEST_F(AlphaBounds, EditsAreSeen) {
    EXPECT_FALSE(IsTested(kBlend, 1.0f, 1.0f, 255));
    scene::Material material = Lambert(glm::vec3(0.5f));
    material.alphaMode = kBlend;
    material.baseColorFactor.a = 0.5f;
    render.scene.SetMaterial(0, material);
    EXPECT_TRUE(HasAlpha());
    material.baseColorFactor.a = 1.0f;
    render.scene.SetMaterial(0, material);
    EXPECT_FALSE(HasAlpha());
}

TEST_F(AlphaBounds, LowestOfNothingIsOne) {
    EXPECT_EQ(LowestAlpha({}), 1.0f);
    scene::SceneData scene;
    scene.materials.resize(2);
    EXPECT_EQ(LowestTextureAlphas(scene), (std::vector<float>{1.0f, 1.0f}));
}

// Once, where the image was decoded: not when the scene is shown, by when its texels may be gone.
TEST_F(AlphaBounds, WhatIsKnownOfAnImageIsNotComputedAgain) {
    scene::SceneData scene;
    scene.images.push_back({.name = {}, .width = 1, .height = 1, .rgba = {1, 2, 3, 51}, .lowestAlpha = {}});
    scene.textures.resize(1);
    scene.materials.resize(1);
    scene.materials[0].baseColorTexture.texture = 0;
    EXPECT_EQ(LowestTextureAlphas(scene), std::vector<float>{0.2f});
    scene.images[0].lowestAlpha = uint8_t{102};
    EXPECT_EQ(LowestTextureAlphas(scene), std::vector<float>{0.4f});
}

}  // namespace raygraph::testing::alpha_bounds_test

// Tests round primitives in raster views, which rays find in front of the drawn triangles.
#include "passes/raster.h"
#include "passes/see_through.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::raster_capsules_test {

using passes::FilmPosition;
using passes::Rasterizer;
using passes::TraceSettings;

namespace {

class RasterCapsules : public VulkanTest {
  protected:
    SceneRender::Hits Draw(const TraceSettings& settings, Rasterizer rasterizer, bool isBehindGlass = false) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center, rasterizer);
        if (isBehindGlass) seen = passes::DrawBehindGlass(render.renderer, ids, settings, seen);
        return render.ReadHits(passes::RasterHits(render.renderer, ids, settings, seen));
    }

    // Compares both views of a scene of so many instances, all of which are visible.
    void ExpectAgreement(size_t instanceCount) {
        const TraceSettings settings = LookAt({0.5f, 0.7f, 5}, {0, 0, 0}, 0.6f, 96);
        const SceneRender::Hits traced = render.PrimaryHits(settings);
        for (const Rasterizer rasterizer : {Rasterizer::Compute, Rasterizer::Device}) {
            const SceneRender::Hits drawn = Draw(settings, rasterizer);
            uint32_t different = 0;
            std::vector<uint32_t> seen(instanceCount);
            for (size_t i = 0; i < drawn.ids.size(); ++i) {
                different += drawn.ids[i] != traced.ids[i];
                if (drawn.ids[i] != traced.ids[i] || drawn.ids[i].x == 0xFFFFFFFFu) continue;
                seen.at(drawn.ids[i].x)++;
                ASSERT_LT(glm::distance(traced.position.values[i], drawn.position.values[i]), 1e-3f) << i;
                ASSERT_LT(glm::distance(traced.normal.values[i], drawn.normal.values[i]), 5e-3f) << i;
            }
            EXPECT_LE(different, rasterizer == Rasterizer::Compute ? 4u : 60u);
            for (const uint32_t count : seen) EXPECT_GT(count, 30u) << "each is there";
        }
    }

    SceneRender render{Device()};
};

scene::Material Glass() {
    scene::Material glass;
    glass.transmissionFactor = 1.0f;
    glass.metallicFactor = 0.0f;
    return glass;
}

}  // namespace

// The scene has a wall that cuts a ball and a bar, and another ball behind it.
TEST_F(RasterCapsules, AreSeenBeforeAndBehindTrianglesAsRaysSeeThem) {
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), RoundSphere(0.5f, 1, {-0.3f, 0, 0}),
                                   RoundMesh({{-1.5f, -0.8f, -1}, {1.5f, 0.8f, 1}}, {0, 1}, {0.1f}, 1),
                                   RoundSphere(0.4f, 1, {0.9f, 0.9f, -0.5f})},
                                  {Lambert(glm::vec3(0.5f)), Lambert({0.2f, 0.6f, 0.4f})}));
    ExpectAgreement(4);
}

// They are before the wall, and exist for half of the rays.
TEST_F(RasterCapsules, BlendedOnesAreSeenAsRaysSeeThem) {
    scene::Material veil = Lambert(glm::vec3(0.5f));
    veil.alphaMode = scene::AlphaMode::Blend;
    veil.baseColorFactor.a = 0.5f;
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), RoundSphere(0.3f, 1, {0.6f, -0.6f, 0.4f})},
                                  {Lambert(glm::vec3(0.5f)), veil}));
    ExpectAgreement(2);
}

// With more surfaces than are looked through, the glass must not be taken for what is behind it.
TEST_F(RasterCapsules, BehindMuchGlassIsNoGlass) {
    std::vector<scene::Mesh> meshes{QuadMesh(2.0f, 0)};
    for (int i = 0; i < 18; ++i) meshes.push_back(RoundSphere(0.1f, 1, {0, 0, 0.5f + 0.3f * float(i)}));
    render.scene.SetScene(SceneOf(std::move(meshes), {Lambert(glm::vec3(0.5f)), Glass()}));
    const TraceSettings settings = LookAt({0, 0, 9}, {0, 0, 0}, 0.01f, 4);
    for (const Rasterizer rasterizer : {Rasterizer::Compute, Rasterizer::Device})
        for (const glm::uvec4& ids : Draw(settings, rasterizer, true).ids) EXPECT_EQ(ids.x, 0u);
}

TEST_F(RasterCapsules, WhatIsBehindGlassIsFoundBehindRoundGlass) {
    // A ball of glass before a ball of chalk before a wall
    render.scene.SetScene(
        SceneOf({QuadMesh(2.0f, 0), RoundSphere(0.5f, 1, {0, 0, 2}), RoundSphere(0.2f, 0, {0, 0, 1})},
                {Lambert(glm::vec3(0.5f)), Glass()}));
    const TraceSettings settings = LookAt({0, 0, 6}, {0, 0, 0}, 0.25f, 32);
    const auto middle = [](const SceneRender::Hits& hits) { return hits.ids[16 * 32 + 16].x; };
    const auto besideIt = [](const SceneRender::Hits& hits) { return hits.ids[16 * 32 + 24].x; };
    for (const Rasterizer rasterizer : {Rasterizer::Compute, Rasterizer::Device}) {
        EXPECT_EQ(middle(Draw(settings, rasterizer)), 1u);
        EXPECT_EQ(middle(Draw(settings, rasterizer, true)), 2u);
        EXPECT_EQ(besideIt(Draw(settings, rasterizer)), 1u);
        EXPECT_EQ(besideIt(Draw(settings, rasterizer, true)), 0u);
    }
}

// The sun is behind a ball, whose shadow is on the floor, also if maps are requested.
TEST_F(RasterCapsules, CastShadowsOnWhatIsDrawn) {
    scene::SceneData scene =
        SceneOf({QuadMesh(2.0f, 0), RoundSphere(0.5f, 0, {0, 0, 2})}, {Lambert(glm::vec3(0.5f))});
    scene::Light sun;  // along -z
    sun.type = scene::LightType::Directional;
    sun.intensity = 2.0f;
    scene.lights = {sun};
    render.scene.SetScene(std::move(scene));
    passes::FilteredEnvironment environment("environment");
    for (const passes::RasterShadows shadows : {passes::RasterShadows::Rays, passes::RasterShadows::Maps})
        for (const auto& [x, share] : {std::pair{0.0f, 0.0f}, {0.48f, 0.0f}, {0.52f, 1.0f}}) {
            const TraceSettings settings = LookAt({x, 0, 1}, {x, 0, 0}, 1e-3f, 4);
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            const Readback readback = render.renderer.ReadBack(passes::AnyRasterShade(
                render.renderer, ids, settings, FilmPosition::Center, environment, {.shadows = shadows}));
            render.renderer.Execute();
            EXPECT_NEAR(ToFloatImage(readback).Mean().y, share * 0.5 * 2.0 / 3.14159265, 1e-3) << x;
        }
}

}  // namespace raygraph::testing::raster_capsules_test

// Tests that every option of the raster view changes the pixels that it concerns, and no other; options of
// Trace alone change nothing. Options for scattering and light sampling need a pipeline for each value, see
// tests/long/trace_options_test.cpp.
#include <algorithm>
#include <string>

#include "passes/raster.h"
#include "tests/passes/level_texture.h"
#include "tests/support/option_rows.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::raster_options_test {

using passes::RasterSettings;
using passes::RasterShadows;
using passes::TraceSettings;

namespace {

constexpr uint32_t kMiss = 0xFFFFFFFFu, kPane = 2;

class RasterOptions : public VulkanTest {
  protected:
    RasterOptions() {
        scene::Material floor = Lambert({0.7f, 0.5f, 0.3f}), pane = floor;
        floor.metallicFactor = 0.3f;
        floor.roughnessFactor = 0.6f;
        pane.metallicFactor = 0.0f;
        pane.roughnessFactor = 0.2f;
        pane.transmissionFactor = 0.9f;
        scene::Material squares = floor;
        squares.baseColorTexture = {.texture = 0};
        scene::Mesh ground = QuadMesh(1.0f, 3);
        ground.primitives[0].uv0 = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        scene::SceneData scene =
            SceneOf({ground, BoxMesh(0.3f, 0), QuadMesh(0.3f, 1), QuadMesh(0.3f, 2)},
                    {floor, pane, Lambert({}, glm::vec3(9.0f)), squares},
                    {glm::mat4x3(1.0f), Translation({0.2f, -0.1f, 0.3f}), Translation({-0.4f, -0.5f, 0.5f}),
                     Translation({0.9f, 0.9f, 1.2f})});
        scene.images = {CheckerImage(512, 200, 250)};
        scene.textures = {{.name = "squares", .image = 0}};
        scene::Light light;
        light.intensity = 2.0f;
        light.lightToWorld = Translation({-0.6f, 0.4f, 1.3f});
        scene.lights.push_back(light);
        render.scene.SetScene(std::move(scene));
        render.scene.SetEnvironment({.radiance = glm::vec3(0.4f)});
        surfaces = render.PrimaryHits(settings).ids;
    }
    FloatImage Draw(const TraceSettings& drawn, const RasterSettings& raster) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, drawn, passes::FilmPosition::Center);
        const Readback readback = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, drawn, seen, environment, raster));
        render.renderer.Execute();
        return ToFloatImage(readback);
    }
    struct Change {
        size_t pixels = 0;
        size_t elsewhere = 0;  // of these, off the tested instance, or off all surfaces
    };
    Change Compare(const FloatImage& a, const FloatImage& b, uint32_t instance = kMiss) const {
        Change change;
        for (size_t i = 0; i < a.values.size(); ++i) {
            if (a.values[i] == b.values[i]) continue;
            ++change.pixels;
            const uint32_t seen = surfaces[i].x;
            change.elsewhere += instance == kMiss ? seen == kMiss : seen != instance;
            EXPECT_EQ(a.values[i].w, b.values[i].w);
        }
        return change;
    }

    SceneRender render{Device(), {.textureLevels = true}};
    passes::FilteredEnvironment environment{"environment"};
    const TraceSettings settings = [] {
        TraceSettings view = LookAt({0.3f, -2.2f, 1.6f}, {0, -0.1f, 0.3f}, 1.0f, 32);
        view.scattering.brdf = BrdfModel::Gltf;
        return view;
    }();
    std::vector<glm::uvec4> surfaces;
};

constexpr RasterSettings kPlain{.shadows = RasterShadows::Off,
                                .hasOcclusion = false,
                                .hasTransmission = false,
                                .hasTextureLevels = false};

}  // namespace

TEST_F(RasterOptions, EachOfTheRasterViewChangesItsPixelsAlone) {
    struct Row {
        const char* name;
        void (*change)(RasterSettings&);
        RasterSettings before = kPlain;
        uint32_t instance = kMiss;  // only instance that may change; by default any surface
    };
    constexpr RasterSettings kSmallMaps{.shadows = RasterShadows::Maps,
                                        .shadowAtlasSize = 512,
                                        .hasOcclusion = false,
                                        .hasTransmission = false};
    const Row kRows[] = {
        {"rays", [](RasterSettings& s) { s.shadows = RasterShadows::Rays; }},
        {"maps",
         [](RasterSettings& s) { s.shadows = RasterShadows::Maps; },
         {.shadows = RasterShadows::Off,
          .shadowAtlasSize = 512,
          .hasOcclusion = false,
          .hasTransmission = false,
          .hasTextureLevels = false}},
        {"rays in place of maps", [](RasterSettings& s) { s.shadows = RasterShadows::Rays; }, kSmallMaps},
        {"atlas", [](RasterSettings& s) { s.shadowAtlasSize = 48; }, kSmallMaps},
        {"occlusion", [](RasterSettings& s) { s.hasOcclusion = true; }},
        {"transmission", [](RasterSettings& s) { s.hasTransmission = true; }, kPlain, kPane},
        {"texture levels", [](RasterSettings& s) { s.hasTextureLevels = true; }},
    };
    auto rows = OptionRowsOf<RasterSettings>([](RasterSettings& s) {
        auto& [shadows, shadowAtlasSize, hasOcclusion, hasTransmission, hasTextureLevels] = s;
        return std::tie(shadows, shadowAtlasSize, hasOcclusion, hasTransmission, hasTextureLevels);
    });
    for (const Row& row : kRows) {
        RasterSettings after = row.before;
        row.change(after);
        rows.Add(row.name, row.before, after);
        const Change change = Compare(Draw(settings, row.before), Draw(settings, after), row.instance);
        EXPECT_GT(change.pixels, 10u) << row.name << " does nothing";
        EXPECT_EQ(change.elsewhere, 0u) << row.name;
    }
    rows.ExpectComplete();
    // The atlas belongs to shadow maps
    for (const RasterShadows shadows : {RasterShadows::Off, RasterShadows::Rays}) {
        RasterSettings before = kPlain, after = kPlain;
        before.shadows = after.shadows = shadows;
        after.shadowAtlasSize = 48;
        EXPECT_EQ(Compare(Draw(settings, before), Draw(settings, after)).pixels, 0u);
    }
}

TEST_F(RasterOptions, WhatOnlyPathsHaveChangesNothing) {
    const FloatImage before = Draw(settings, kPlain);
    const auto draw = [&](void (*change)(TraceSettings&)) {
        TraceSettings changed = settings;
        change(changed);
        return Compare(Draw(changed, kPlain), before);
    };
    const struct {
        const char* name;
        void (*change)(TraceSettings&);
    } kOfPaths[] = {
        {"balance", [](TraceSettings& s) { s.lights.mis = MisHeuristic::Balance; }},
        {"mis off", [](TraceSettings& s) { s.lights.mis = MisHeuristic::Off; }},
        {"light sampling", [](TraceSettings& s) { s.lights.isOn = false; }},
        {"constant roulette", [](TraceSettings& s) { s.roulette.kind = Roulette::Constant; }},
        {"roulette of the frame", [](TraceSettings& s) { s.roulette.kind = Roulette::Frame; }},
        {"roulette off", [](TraceSettings& s) { s.roulette.kind = Roulette::Off; }},
        {"roulette's start", [](TraceSettings& s) { s.roulette.start = 1; }},
        {"survival", [](TraceSettings& s) { s.roulette.survival = 0.1f; }},
        {"depth", [](TraceSettings& s) { s.biases.maxDepth = 0; }},
        {"clamp", [](TraceSettings& s) { s.biases.clampIndirect = 0.0f; }},
        {"regularization", [](TraceSettings& s) { s.biases.regularize = 0.9f; }},
        {"shadow terminator", [](TraceSettings& s) { s.biases.shadowTerminator = true; }},
        {"texture levels of paths", [](TraceSettings& s) { s.biases.textureLod = 4.0f; }},
        {"aperture", [](TraceSettings& s) { s.camera.lensRadius = 0.3f; }},
    };
    for (const auto& row : kOfPaths) EXPECT_EQ(draw(row.change).pixels, 0u) << row.name;
    // The lamp is sampled differently, and lights surfaces alone
    for (const auto change :
         {+[](TraceSettings& s) { s.seed = 3; }, +[](TraceSettings& s) { s.sampleIndex = 3; }}) {
        const Change noise = draw(change);
        EXPECT_GT(noise.pixels, 10u);
        EXPECT_EQ(noise.elsewhere, 0u);
    }
}

}  // namespace raygraph::testing::raster_options_test

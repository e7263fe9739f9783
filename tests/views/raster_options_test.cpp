// Tests that every option of the raster view changes the pixels that it concerns, and no other; options of
// Trace alone change nothing. Options for scattering and light sampling need a pipeline for each value, see
// tests/long/trace_options_test.cpp.
#include <algorithm>
#include <cmath>
#include <string>

#include "passes/raster.h"
#include "passes/tonemap.h"
#include "passes/views.h"
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

// Tests the mip level at which the raster view reads textures: derivatives in a pixel, and anisotropic
// filters.
namespace raygraph::testing::raster_levels_test {

using passes::TraceSettings;

namespace {

class RasterLevels : public VulkanTest {
  protected:
    static FloatImage Draw(SceneRender& render, const TraceSettings& settings, bool hasTextureLevels = true) {
        passes::FilteredEnvironment environment{"environment"};
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::AnyVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        const Readback readback =
            render.renderer.ReadBack(passes::RasterShade(render.renderer, ids, settings, seen, environment,
                                                         {.shadows = passes::RasterShadows::Off,
                                                          .hasOcclusion = false,
                                                          .hasTransmission = false,
                                                          .hasTextureLevels = hasTextureLevels}));
        render.renderer.Execute();
        return ToFloatImage(readback);
    }
    static double CenterLevel(const FloatImage& image) {
        return LevelOf(image.At(image.extent.width / 2, image.extent.height / 2).x);
    }
};

double PixelWidth(float yFov, uint32_t size) {
    return 2.0 * std::tan(0.5 * double(yFov)) / size;
}

glm::mat4x3 Turned(float angle, float scale) {  // about x
    glm::mat4x3 matrix(scale);
    matrix[1] = scale * glm::vec3(0, std::cos(angle), std::sin(angle));
    matrix[2] = scale * glm::vec3(0, -std::sin(angle), std::cos(angle));
    return matrix;
}

}  // namespace

// Texture coordinates hardly change along x, so the texels along y decide: those of a pixel's height, divided
// by the cosine of the tilt.
TEST_F(RasterLevels, PlaneIsReadAtTheLevelOfThePixelsTexels) {
    SceneRender render(Device(), {.textureLevels = true});
    constexpr float kFov = 0.1f, kRepeats = 4.0f;
    for (const float distance : {8.0f, 30.0f})
        for (const float tilt : {0.0f, 0.9f})
            for (const float scale : {1.0f, 2.0f}) {
                SCOPED_TRACE("distance " + std::to_string(distance) + ", tilt " + std::to_string(tilt));
                render.scene.SetScene(
                    LevelScene({LevelQuad(1.0f, kRepeats)}, {LevelMaterial()}, {Turned(tilt, scale)}));
                const double texels = double(distance) * PixelWidth(kFov, 9) * double(kRepeats) *
                                      kLevelTexels / (2.0 * double(scale) * std::cos(double(tilt)));
                ASSERT_GT(texels, 1.5);
                const TraceSettings settings = LookAt({0, 0, distance}, {0, 0, 0}, kFov, 9);
                EXPECT_NEAR(CenterLevel(Draw(render, settings)), std::min(std::log2(texels), kFinestLevel),
                            0.15);
                EXPECT_NEAR(CenterLevel(Draw(render, settings, false)), 0.0, 0.1);
            }
}

TEST_F(RasterLevels, OrthographicPlaneIsReadAtTheLevelOfThePixelsTexels) {
    SceneRender render(Device(), {.textureLevels = true});
    render.scene.SetScene(LevelScene({LevelQuad(1.0f, 4.0f)}, {LevelMaterial()}, {Turned(0.9f, 1.0f)}));
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 0.4f;
    TraceSettings settings = LookAt({0, 0, 5}, {0, 0, 0}, 1.0f, 9);
    settings.camera = ToRecord(view);
    const double texels = 0.4 / 9 * 4.0 * kLevelTexels / (2.0 * std::cos(0.9));
    EXPECT_NEAR(CenterLevel(Draw(render, settings)), std::log2(texels), 0.15);
}

// Up to the horizon the derivatives leave no pixel without a color, and far away all is the mean of the
// squares.
TEST_F(RasterLevels, CheckerToTheHorizonIsItsMeanFarAway) {
    scene::Material material = LevelMaterial();
    scene::Mesh floor = QuadMesh(1000.0f);
    floor.primitives[0].uv0 = {{0, 0}, {500, 0}, {500, 500}, {0, 500}};
    for (const float anisotropy : {1.0f, 8.0f}) {
        SceneRender render(Device(), {.textureLevels = true, .maxAnisotropy = anisotropy});
        scene::SceneData scene = SceneOf({floor}, {material});
        scene.images = {CheckerImage(64, 60, 200)};
        scene.textures = {{.name = "squares", .image = 0, .colorSpace = scene::ColorSpace::Linear}};
        render.scene.SetScene(std::move(scene));
        const TraceSettings settings = LookAt({0, 0, 2}, {0, 30, 0}, 0.6f, 48);
        const FloatImage levels = Draw(render, settings), finest = Draw(render, settings, false);
        double worst = 0.0, worstFinest = 0.0;
        uint32_t count = 0;
        for (uint32_t y = 0; y < 24; ++y)
            for (uint32_t x = 0; x < 48; ++x) {
                if (levels.At(x, y).w == 0.0f) continue;
                ++count;
                worst = std::max(worst, std::abs(double{levels.At(x, y).x} - 130.0 / 255.0));
                worstFinest = std::max(worstFinest, std::abs(double{finest.At(x, y).x} - 130.0 / 255.0));
            }
        EXPECT_GT(count, 200u);
        EXPECT_LT(worst, 0.02) << anisotropy;
        EXPECT_GT(worstFinest, 0.2);
    }
}

// A footprint that is long in v and short in u is filtered along v by several samples of a finer level, so
// that lines along v, which an isotropic filter blurs, stay sharp.
TEST_F(RasterLevels, AnisotropicFilterKeepsLinesAlongAFootprint) {
    if (Device().Info().maxAnisotropy < 8.0f) GTEST_SKIP() << "the device has no anisotropic filter";
    if (Device().Info().isLavapipe) GTEST_SKIP() << "this driver filters round footprints";
    // Across 64 pixels there are 4 texels each, in lines of 8; along v there are 32 texels per pixel
    scene::Mesh quad = QuadMesh(1.0f);
    quad.primitives[0].uv0.clear();
    for (const glm::vec3& position : quad.primitives[0].positions)
        quad.primitives[0].uv0.push_back({0.5f + 0.5f * position.x, 4.0f * position.y});
    const auto contrast = [&](float anisotropy) {
        SceneRender render(Device(), {.textureLevels = true, .maxAnisotropy = anisotropy});
        scene::SceneData scene = SceneOf({quad}, {LevelMaterial()});
        scene.images = {{.name = "lines", .width = 256, .height = 256, .rgba = {}}};
        for (uint32_t i = 0; i < 256 * 256; ++i) {
            const uint8_t byte = i % 256 / 8 % 2 != 0 ? 200 : 60;
            scene.images[0].rgba.insert(scene.images[0].rgba.end(), {byte, byte, byte, 255});
        }
        scene.textures = {{.name = "lines", .image = 0, .colorSpace = scene::ColorSpace::Linear}};
        render.scene.SetScene(std::move(scene));
        scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = 2.0f;
        TraceSettings settings = LookAt({0, 0, 5}, {0, 0, 0}, 1.0f, 64);
        settings.camera = ToRecord(view);
        const FloatImage image = Draw(render, settings);
        float least = 1.0f, greatest = 0.0f;
        for (const glm::vec4& texel : image.values) {
            least = std::min(least, texel.x);
            greatest = std::max(greatest, texel.x);
        }
        return greatest - least;
    };
    EXPECT_LT(contrast(1.0f), 0.2f);
    EXPECT_GT(contrast(8.0f), 0.4f);
}

}  // namespace raygraph::testing::raster_levels_test

// Tests that a raster frame costs the host the same whatever it draws, since the device culls and draws by
// itself.
namespace raygraph::testing::raster_frame_test {

using passes::FilmPosition;
using passes::TraceSettings;

namespace {

class RasterFrame : public VulkanTest {
  protected:
    struct Cost {
        double hostMs;  // declaring, compiling and recording; the median of some frames
        size_t passCount;
    };
    Cost Measure(const TraceSettings& settings, const passes::RasterSettings& raster) {
        std::vector<double> times;
        size_t passCount = 0;
        for (int frame = 0; frame < 12; ++frame) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            const passes::RasterVisibility seen =
                passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center);
            render.renderer.Present(passes::Tonemap(
                render.renderer,
                passes::RasterShade(render.renderer, ids, settings, seen, environment, raster)));
            Device().WaitFor(render.renderer.Execute());
            for (const FrameTiming& timing : render.renderer.TakeTimings()) {
                passCount = timing.passes.size();
                if (frame > 4) times.push_back(timing.declareMs + timing.compileMs + timing.recordMs);
            }
        }
        std::ranges::sort(times);
        return {times[times.size() / 2], passCount};
    }

    // Makes boxes in a square, under a sun and a sky.
    void SetBoxes(int perSide) {
        std::vector<glm::mat4x3> places;
        for (int y = 0; y < perSide; ++y)
            for (int x = 0; x < perSide; ++x)
                places.push_back(Translation({float(x - perSide / 2), 0, float(y - perSide / 2)}));
        scene::SceneData scene;
        scene.meshes = {BoxMesh(0.3f)};
        scene.materials = {Lambert(glm::vec3(0.6f))};
        for (const glm::mat4x3& place : places) {
            scene.instances.emplace_back();
            scene.instances.back().mesh = 0;
            scene.instances.back().objectToWorld = place;
        }
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 2.0f;
        sun.lightToWorld = glm::mat4x3(glm::vec3(1, 0, 0), glm::vec3(0, 0.8f, -0.6f),
                                       glm::vec3(0, 0.6f, 0.8f), glm::vec3(0.0f));
        scene.lights = {sun};
        render.scene.SetScene(std::move(scene));
        render.scene.SetEnvironment({.radiance = glm::vec3(0.3f)});
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

}  // namespace

TEST_F(RasterFrame, CostsTheHostTheSameForAnyNumberOfInstances) {
    const TraceSettings settings = LookAt({0, 6, 12}, {0, 0, 0}, 0.8f, 32);
    const passes::RasterSettings raster{.shadows = passes::RasterShadows::Maps, .shadowAtlasSize = 256};
    SetBoxes(2);
    const Cost few = Measure(settings, raster);
    SetBoxes(128);
    const Cost many = Measure(settings, raster);
    EXPECT_EQ(many.passCount, few.passCount);
    // 4,096 times the instances: a loop over them would take milliseconds, noise does not
    EXPECT_LT(many.hostMs, 10.0 * few.hostMs + 1.0) << few.hostMs;
    RecordProperty("host ms of 4 instances", std::to_string(few.hostMs));
    RecordProperty("host ms of 16384 instances", std::to_string(many.hostMs));
    RecordProperty("passes", std::to_string(many.passCount));
}

}  // namespace raygraph::testing::raster_frame_test

// Tests screen-space effects of the raster view: occlusion of the environment, and transmission through
// glass.
#include <cmath>

#include "passes/raster.h"
#include "passes/views.h"
#include "renderer/graph/pass_harness.h"
#include "shaders/shared/blur_levels.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::raster_screen_test {

using passes::FilmPosition;
using passes::RasterVisibility;
using passes::TraceSettings;

namespace {

constexpr passes::RasterSettings kScreen{.shadows = passes::RasterShadows::Off};

class RasterScreen : public VulkanTest {
  protected:
    // Returns the mean of what `declare` makes of drawn pictures.
    template <typename Declare>
    FloatImage Mean(TraceSettings settings, uint32_t samples, FilmPosition film, Declare&& declare) {
        FloatImage sum;
        for (uint32_t i = 0; i < samples; ++i) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            const RasterVisibility seen = passes::DrawVisibility(render.renderer, ids, settings, film);
            const Readback readback = render.renderer.ReadBack(declare(ids, settings, seen));
            render.renderer.Execute();
            const FloatImage sample = ToFloatImage(readback);
            if (i == 0) sum = {sample.extent, std::vector<glm::vec4>(sample.values.size())};
            for (size_t j = 0; j < sum.values.size(); ++j) sum.values[j] += sample.values[j] / float(samples);
            ++settings.sampleIndex;
        }
        return sum;
    }
    FloatImage Draw(const TraceSettings& settings, uint32_t samples, const passes::RasterSettings& raster) {
        return Mean(settings, samples, FilmPosition::Jittered,
                    [&](const SceneIds& ids, const TraceSettings& now, const RasterVisibility& seen) {
                        return passes::RasterShade(render.renderer, ids, now, seen, environment, raster);
                    });
    }
    // The visibility is in the first channel.
    FloatImage OpenShares(const TraceSettings& settings, uint32_t samples) {
        return Mean(settings, samples, FilmPosition::Center,
                    [&](const SceneIds& ids, const TraceSettings& now, const RasterVisibility& seen) {
                        return passes::SpreadCounts(render.renderer,
                                                    passes::Occlusion(render.renderer, ids, now, seen));
                    });
    }

    // Returns the mean of the pixels at most `reach` beside this one.
    static glm::vec4 Around(const FloatImage& image, uint32_t x, uint32_t y, uint32_t reach) {
        glm::vec4 sum(0.0f);
        for (uint32_t j = y - reach; j <= y + reach; ++j)
            for (uint32_t i = x - reach; i <= x + reach; ++i) sum += image.At(i, j);
        return sum / float((2 * reach + 1) * (2 * reach + 1));
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

const glm::mat4x3 kFloor(glm::vec3(1, 0, 0), glm::vec3(0, 0, -1), glm::vec3(0, 1, 0), glm::vec3(0, -1, 1));

// Makes a floor and a wall that meet at y = -1, z = 0.
scene::SceneData Crease() {
    return SceneOf({QuadMesh(1.0f), QuadMesh(1.0f)}, {Lambert(glm::vec3(0.8f))},
                   {Translation({0, 0, 0}), kFloor});
}

// Makes a pane of glass before the left half of an emitting wall that covers the middle of the picture.
scene::SceneData Window(float roughness) {
    scene::Material glass;
    glass.baseColorFactor = {0.5f, 1.0f, 0.25f, 1.0f};
    glass.metallicFactor = 0.0f;
    glass.roughnessFactor = roughness;
    glass.transmissionFactor = 1.0f;
    glass.ior = 1.0f;  // reflects nothing
    return SceneOf({QuadMesh(0.5f, 0), QuadMesh(0.6f, 1)},
                   {Lambert(glm::vec3(0.0f), glm::vec3(2.0f, 1.0f, 4.0f)), glass},
                   {Translation({0, 0, -1}), Translation({-0.6f, 0, 0})});
}

TraceSettings ViewOfWindow() {
    TraceSettings settings = LookAt({0, 0, 6}, {0, 0, 0}, 0.3f, 64);
    settings.scattering.brdf = BrdfModel::Gltf;
    return settings;
}

}  // namespace

TEST_F(RasterScreen, AFlatSurfaceIsOpenWhicheverWayItIsSeen) {
    render.scene.SetScene(SceneOf({QuadMesh(3.0f)}, {Lambert(glm::vec3(0.8f))}));
    for (const glm::vec3& eye : {glm::vec3(0, 0, 4), glm::vec3(2, 1.5f, 2), glm::vec3(0, -3.5f, 1)}) {
        const FloatImage share = OpenShares(LookAt(eye, {0, 0, 0}, 0.3f, 32), 8);
        for (const glm::vec4& value : share.values) ASSERT_NEAR(value.x, 1.0f, 0.05f) << eye.y;
    }
}

TEST_F(RasterScreen, InACreaseHalfOfTheDirectionsAreOpen) {
    // Near the wall and far below its top, half of all directions are occluded: those behind the wall's plane
    render.scene.SetScene(Crease());
    const FloatImage share = OpenShares(LookAt({0, 2, 3}, {0, -1, 0}, 0.5f, 128), 32);
    EXPECT_NEAR(share.At(64, 66).x, 0.5f, 0.08f) << "floor";
    EXPECT_NEAR(share.At(64, 61).x, 0.5f, 0.08f) << "wall";
    EXPECT_GT(share.At(64, 96).x, 0.85f) << "far from the wall";
    EXPECT_GT(share.At(64, 96).x, share.At(64, 72).x);
}

TEST_F(RasterScreen, OcclusionDarkensTheEnvironmentAlone) {
    scene::SceneData scene = Crease();
    scene::Light sun;
    sun.type = scene::LightType::Directional;
    sun.intensity = 1.0f;
    sun.lightToWorld =
        glm::mat4x3(glm::vec3(1, 0, 0), glm::vec3(0, 0.8f, -0.6f), glm::vec3(0, 0.6f, 0.8f), glm::vec3(0.0f));
    scene.lights = {sun};
    render.scene.SetScene(std::move(scene));
    const TraceSettings settings = LookAt({0, 2, 3}, {0, -1, 0}, 0.5f, 64);
    const auto draw = [&](bool hasOcclusion) {
        return Draw(settings, 16, {.shadows = passes::RasterShadows::Off, .hasOcclusion = hasOcclusion})
            .At(32, 33);
    };
    EXPECT_EQ(draw(true), draw(false)) << "no environment, nothing to close off";
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    const glm::vec4 open = draw(false), closed = draw(true);
    EXPECT_NEAR(open.y - closed.y, 0.5f * 0.8f, 0.1f);
}

TEST_F(RasterScreen, WithOcclusionACreaseUnderAnEvenSkyIsMoreAsPathTraced) {
    render.scene.SetScene(Crease());
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, 2, 3}, {0, -1, 0}, 0.6f, 32);
    settings.biases.maxDepth = 1;
    const FloatImage traced = render.Render(settings, 64).mean;
    const FloatImage without = Draw(settings, 1, {.shadows = kScreen.shadows, .hasOcclusion = false}),
                     with = Draw(settings, 16, kScreen);
    double errorWithout = 0.0, errorWith = 0.0;
    for (size_t i = 0; i < traced.values.size(); ++i) {
        if (traced.values[i].w < 1.0f) continue;
        errorWithout += std::abs(without.values[i].y - traced.values[i].y);
        errorWith += std::abs(with.values[i].y - traced.values[i].y);
    }
    EXPECT_GT(errorWithout, 0.1 * double(traced.values.size())) << "there is something to win";
    EXPECT_LT(errorWith, 0.75 * errorWithout);
}

TEST_F(RasterScreen, ClearGlassShowsWhatIsBehindItInItsColor) {
    render.scene.SetScene(Window(0.0f));
    const FloatImage drawn = Draw(ViewOfWindow(), 4, kScreen);
    const FloatImage traced = render.Render(ViewOfWindow(), 16).mean;
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(drawn.At(22, 32)[c], 1.0f, 0.02f) << "through the pane";
        EXPECT_NEAR(traced.At(22, 32)[c], 1.0f, 0.02f);
        EXPECT_NEAR(drawn.At(40, 32)[c], traced.At(40, 32)[c], 1e-3f) << "beside it";
    }
    const passes::RasterSettings without{.shadows = kScreen.shadows, .hasTransmission = false};
    EXPECT_EQ(Draw(ViewOfWindow(), 1, without).At(22, 32).y, 0.0f) << "the environment is black";
}

// Straight transmission is in the picture of what is behind; the wall's light that the pane transmits diffusely
// is not. Half of the pane lets it through by either extension.
TEST_F(RasterScreen, GlassThatAlsoTransmitsDiffuselyIsLitByTheWallBehindIt) {
    for (const bool scatters : {false, true}) {
        scene::SceneData window = Window(0.0f);
        scene::Material& pane = window.materials[1];
        pane.transmissionFactor = scatters ? 1.0f : 0.5f;
        pane.diffuseTransmissionFactor = 1.0f;
        pane.scatterStrengthFactor = scatters ? 0.5f : 0.0f;
        pane.scatterMeanCosine = 0.999f;
        render.scene.SetScene(std::move(window));
        TraceSettings settings = ViewOfWindow();
        settings.biases.maxDepth = 1;
        const glm::vec4 drawn = Around(Draw(settings, 16, kScreen), 22, 32, 3);
        const glm::vec4 traced = Around(render.Render(settings, 16).mean, 22, 32, 3);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(drawn[c], traced[c], 0.05f * traced[c]) << c;
            EXPECT_GT(traced[c], 0.55f) << "half of what it would be as clear glass, and more";
        }
    }
}

// A sheet that scatters all that it would transmit is no glass: it is seen behind glass, here lit from behind.
TEST_F(RasterScreen, SheetThatScattersAllIsSeenBehindGlass) {
    scene::SceneData window = Window(0.0f);
    scene::Material& sheet = window.materials[0] = {};
    sheet.metallicFactor = 0.0f;
    sheet.transmissionFactor = sheet.scatterStrengthFactor = 1.0f;
    scene::Light& lamp = window.lights.emplace_back();
    lamp.intensity = 40.0f;
    lamp.lightToWorld = Translation({0, 0, -4});
    render.scene.SetScene(std::move(window));
    TraceSettings settings = ViewOfWindow();
    settings.biases.maxDepth = 1;
    const FloatImage drawn = Draw(settings, 4, kScreen);
    const FloatImage traced = render.Render(settings, 16).mean;
    for (const uint32_t column : {22u, 40u}) {
        const glm::vec4 here = Around(drawn, column, 32, 2), expected = Around(traced, column, 32, 2);
        for (int c = 0; c < 3; ++c) {
            EXPECT_GT(expected[c], 0.1f);
            EXPECT_NEAR(here[c], expected[c], 0.05f * expected[c])
                << "column " << column << ", channel " << c;
        }
    }
}

TEST_F(RasterScreen, RoughGlassBlursWhatIsBehindItAboutAsPathTraced) {
    render.scene.SetScene(Window(0.35f));
    const FloatImage drawn = Draw(ViewOfWindow(), 4, kScreen);
    const FloatImage traced = render.Render(ViewOfWindow(), 32).mean;
    // Along a column through the pane: the wall's lower edge is at row 46
    float clearest = 0.0f;
    for (uint32_t y = 32; y < 60; y += 2) {
        EXPECT_NEAR(Around(drawn, 22, y, 1).y, Around(traced, 22, y, 1).y, 0.2f) << "row " << y;
        clearest = std::max(clearest, std::abs(drawn.At(22, y).y - drawn.At(22, y + 2).y));
    }
    EXPECT_LT(clearest, 0.4f) << "an edge is left";
    EXPECT_GT(drawn.At(22, 32).y, 0.7f);
}

TEST_F(RasterScreen, BlurredLevelsKeepTheMean) {
    PassHarness harness{Device()};
    const uint32_t width = 37, height = 21;
    std::vector<float> values;
    for (uint32_t i = 0; i < width * height; ++i) {
        const float alpha = i % 3 == 0 ? 0.0f : 1.0f;
        values.insert(values.end(), {2.0f, 1.0f, 0.5f, alpha});
    }
    const Texels levels = harness.Run([&](PassHarness& h) {
        return passes::BlurLevels(h.Graph(),
                                  h.Texture("picture", {width, height}, Format::Rgba32Float, values));
    });
    for (uint32_t level = 1; level <= gpu::kBlurLevels; ++level) {
        glm::vec2 sum(0.0f);
        const uint32_t w = gpu::BlurSize(width, level), h = gpu::BlurSize(height, level);
        for (uint32_t y = 0; y < h; ++y)
            for (uint32_t x = 0; x < w; ++x) {
                const auto texel = levels.At(x, gpu::BlurRow(height, level) + y);
                EXPECT_NEAR(texel[0], 2.0f * texel[3], 1e-5f) << "multiplied by alpha";
                sum += glm::vec2(texel[0], texel[3]);
            }
        EXPECT_NEAR(sum.y / float(w * h), 2.0f / 3.0f, 0.12f) << "level " << level;
    }
}

}  // namespace raygraph::testing::raster_screen_test

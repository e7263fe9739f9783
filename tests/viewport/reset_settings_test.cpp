// Every field of the settings that a picture is traced and drawn with, and every value of their enumerations,
// restarts the views that depend on it, once and for its cause. What is shown then: reset_cause_test.cpp.
#include <span>
#include <type_traits>

#include "tests/support/option_rows.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::reset_settings_test {

using passes::RasterSettings;
using passes::RasterShadows;
using passes::ResetCause;
using scene::CameraView;
using viewport::LensSettings;
using viewport::PathSettings;

namespace {

template <typename Settings>
struct Row {
    const char* name;
    void (*change)(Settings&);
    bool resets = true;
};

const Row<PathSettings> kOfPaths[] = {
    {"pcg", [](PathSettings& s) { s.sampler = SamplerKind::Pcg; }},
    {"tea", [](PathSettings& s) { s.sampler = SamplerKind::Tea; }},
    {"seed", [](PathSettings& s) { s.seed = 5; }},
    {"gltf", [](PathSettings& s) { s.scattering.brdf = BrdfModel::Gltf; }},
    {"lafortune", [](PathSettings& s) { s.scattering.brdf = BrdfModel::Lafortune; }},
    {"beckmann", [](PathSettings& s) { s.scattering.distribution = MicrofacetModel::Beckmann; }},
    {"phong", [](PathSettings& s) { s.scattering.distribution = MicrofacetModel::Phong; }},
    {"separable", [](PathSettings& s) { s.scattering.masking = MaskingModel::Separable; }},
    {"shortcut", [](PathSettings& s) { s.scattering.masking = MaskingModel::Shortcut; }},
    {"dielectric", [](PathSettings& s) { s.scattering.fresnel = FresnelModel::Dielectric; }},
    {"conductor", [](PathSettings& s) { s.scattering.fresnel = FresnelModel::Conductor; }},
    {"lazanyi", [](PathSettings& s) { s.scattering.fresnel = FresnelModel::Lazanyi; }},
    {"no multiscatter", [](PathSettings& s) { s.scattering.multiscatter = MultiscatterKind::Off; }},
    {"walk", [](PathSettings& s) { s.scattering.multiscatter = MultiscatterKind::Walk; }},
    {"light sampling", [](PathSettings& s) { s.lights.isOn = false; }},
    {"uniform lights", [](PathSettings& s) { s.lights.sampler = LightSampler::Uniform; }},
    {"lights by power", [](PathSettings& s) { s.lights.sampler = LightSampler::Power; }},
    {"balance", [](PathSettings& s) { s.lights.mis = MisHeuristic::Balance; }},
    {"mis off", [](PathSettings& s) { s.lights.mis = MisHeuristic::Off; }},
    {"constant roulette", [](PathSettings& s) { s.roulette.kind = Roulette::Constant; }},
    {"roulette of the frame", [](PathSettings& s) { s.roulette.kind = Roulette::Frame; }},
    {"roulette off", [](PathSettings& s) { s.roulette.kind = Roulette::Off; }},
    {"roulette's start", [](PathSettings& s) { s.roulette.start = 1; }},
    {"survival", [](PathSettings& s) { s.roulette.survival = 0.5f; }},
    {"depth", [](PathSettings& s) { s.biases.maxDepth = 1; }},
    {"clamp", [](PathSettings& s) { s.biases.clampIndirect = 0.02f; }},
    {"regularization", [](PathSettings& s) { s.biases.regularize = 0.1f; }},
    {"shadow terminator", [](PathSettings& s) { s.biases.shadowTerminator = true; }},
    {"texture levels", [](PathSettings& s) { s.biases.textureLod = 0.5f; }},
    {"hidden environment", [](PathSettings& s) { s.isEnvironmentHidden = true; }},
};

const Row<CameraView> kOfCamera[] = {
    {"eye", [](CameraView& c) { c.eye.y += 0.05; }},
    {"forward", [](CameraView& c) { c.forward.x += 0.01f; }},
    {"up", [](CameraView& c) { c.up.x += 0.01f; }},
    {"right", [](CameraView& c) { c.right.x += 0.01f; }},
    {"projection", [](CameraView& c) { c.projection = scene::Projection::Orthographic; }},
    {"field of view", [](CameraView& c) { c.yFov = 1.0f; }},
    {"height", [](CameraView& c) { c.height = 1.0f; }},
    {"aspect", [](CameraView& c) { c.aspect = 3.0f; }, false},  // that of the size
    {"near", [](CameraView& c) { c.zNear = 0.02f; }},
    {"far", [](CameraView& c) { c.zFar = 90.0f; }},
};

const Row<LensSettings> kOfLens[] = {
    {"lens radius", [](LensSettings& s) { s.radius = 0.2f; }},
    {"focus distance", [](LensSettings& s) { s.focusDistance = 0.4f; }},
};

const Row<RasterSettings> kOfRaster[] = {
    {"maps", [](RasterSettings& s) { s.shadows = RasterShadows::Maps; }},
    {"rays", [](RasterSettings& s) { s.shadows = RasterShadows::Rays; }},
    {"atlas", [](RasterSettings& s) { s.shadowAtlasSize = 64; }},
    {"occlusion", [](RasterSettings& s) { s.hasOcclusion = true; }},
    {"transmission", [](RasterSettings& s) { s.hasTransmission = true; }},
    {"texture levels", [](RasterSettings& s) { s.hasTextureLevels = false; }},
};

class ViewportResetSettings : public VulkanTest {
  protected:
    // `set` gives settings to the viewport. Both views have a sample when a row changes `plain`, and the
    // frame after that shows neither, so that no pipeline is made for it.
    template <typename Settings, typename Fields, typename Set>
    void ExpectEachResets(std::span<const Row<Settings>> table, Settings plain, Fields fields, Set set,
                          ResetCause cause) {
        auto rows = OptionRowsOf<Settings>(fields);
        for (const Row<Settings>& row : table) {
            SCOPED_TRACE(row.name);
            set(plain);
            viewed.viewport.SetView(View::Wipe);
            viewed.RenderFrames(1);
            ASSERT_GE(viewed.Samples(), 1u);
            ASSERT_GE(viewed.viewport.Progress().rasterSamples, 1u);
            const uint32_t samples = viewed.Samples(), drawn = viewed.viewport.Progress().rasterSamples;
            const uint32_t resets = viewed.AllResets(), ofCause = viewed.viewport.ResetCount(cause);
            Settings changed = plain;
            row.change(changed);
            rows.Add(row.name, plain, changed);
            set(changed);
            viewed.viewport.SetView(View::Surface);
            viewed.RenderFrames(1);
            const bool isOfRasterAlone = std::is_same_v<Settings, RasterSettings>;
            const uint32_t pathResets = row.resets && !isOfRasterAlone ? 1u : 0u;
            EXPECT_EQ(viewed.Samples(), pathResets > 0 ? 0u : samples);
            EXPECT_EQ(viewed.viewport.Progress().rasterSamples, row.resets ? 0u : drawn);
            EXPECT_EQ(viewed.viewport.ResetCount(cause), ofCause + pathResets);
            EXPECT_EQ(viewed.AllResets(), resets + pathResets);
        }
        set(plain);
        rows.ExpectComplete();
    }

    ViewedScene viewed{Device()};
};

}  // namespace

TEST_F(ViewportResetSettings, EveryFieldAndValueOfPathsDoesSo) {
    ExpectEachResets(
        std::span<const Row<PathSettings>>(kOfPaths), viewed.viewport.Paths(),
        [](PathSettings& s) {
            auto& [sampler, seed, scattering, lights, roulette, biases, isEnvironmentHidden] = s;
            auto& [brdf, distribution, masking, fresnel, multiscatter] = scattering;
            auto& [isOn, lightSampler, mis] = lights;
            auto& [kind, start, survival] = roulette;
            auto& [maxDepth, clampIndirect, regularize, shadowTerminator, textureLod] = biases;
            return std::tie(sampler, seed, brdf, distribution, masking, fresnel, multiscatter, isOn,
                            lightSampler, mis, kind, start, survival, maxDepth, clampIndirect, regularize,
                            shadowTerminator, textureLod, isEnvironmentHidden);
        },
        [&](const PathSettings& s) { viewed.viewport.SetPaths(s); }, ResetCause::Settings);
}

TEST_F(ViewportResetSettings, EveryFieldOfCameraAndLensDoesSo) {
    LensSettings lens{.radius = 0.05f, .focusDistance = 1.0f};
    ExpectEachResets(
        std::span<const Row<CameraView>>(kOfCamera), InsideBoxes(),
        [](CameraView& c) {
            auto& [eye, forward, up, right, projection, yFov, height, aspect, zNear, zFar] = c;
            return std::tie(eye, forward, up, right, projection, yFov, height, aspect, zNear, zFar);
        },
        [&](const CameraView& c) { viewed.viewport.SetCamera(c, lens); }, ResetCause::Camera);
    ExpectEachResets(
        std::span<const Row<LensSettings>>(kOfLens), lens,
        [](LensSettings& s) {
            auto& [radius, focusDistance] = s;
            return std::tie(radius, focusDistance);
        },
        [&](const LensSettings& s) { viewed.viewport.SetCamera(InsideBoxes(), s); }, ResetCause::Camera);
}

TEST_F(ViewportResetSettings, EveryFieldAndValueOfTheRasterViewDoesSoToItAlone) {
    ExpectEachResets(
        std::span<const Row<RasterSettings>>(kOfRaster), PlainRaster(),
        [](RasterSettings& s) {
            auto& [shadows, shadowAtlasSize, hasOcclusion, hasTransmission, hasTextureLevels] = s;
            return std::tie(shadows, shadowAtlasSize, hasOcclusion, hasTransmission, hasTextureLevels);
        },
        [&](const RasterSettings& s) { viewed.viewport.SetRaster(s); }, ResetCause::Settings);
}

}  // namespace raygraph::testing::reset_settings_test

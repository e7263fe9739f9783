// Tests a session as a host calls it: what it refuses, and when a run ends. It needs a device.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <ostream>
#include <set>
#include <string>

#include "editor/session/file/content_hash.h"
#include "editor/session/file/merge.h"
#include "editor/session/frames/device_scene.h"
#include "editor/session/session.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/settings/setting_table.h"
#include "renderer/image/exr.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session::session_test {

namespace {

using test::ExpectError;

class SessionTest : public testing::VulkanTest {
  protected:
    static SessionDesc Small() {
        SessionDesc desc;
        desc.settings.size = {8, 8};
        return desc;
    }
    static SceneInput Cornell() { return LoadInput(test::SceneFile("cornell.gltf")); }
    static void ExpectRefused(const SessionDesc& desc, ErrorKind kind, const char* part) {
        ExpectError(
            kind, [&] { const Session session(Device(), Cornell(), desc); }, part);
    }
    static void ExpectSettingRefused(const SessionDesc& desc, SceneInput input, const char* part) {
        try {
            const Session session(Device(), std::move(input), desc);
            ADD_FAILURE() << "not refused: " << part;
        } catch (const SettingError& error) {
            EXPECT_EQ(error.Kind(), ErrorKind::Usage);
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    }
    // Loads a sphere that only an environment lights.
    static SceneInput Sphere() { return LoadInput(test::SceneFile("furnace_sphere.gltf")); }
    static image::ImageF Map(float radiance) {
        return {.width = 2,
                .height = 1,
                .rgba = {radiance, radiance, radiance, 1, radiance, radiance, radiance, 1}};
    }
};

template <typename Render>
concept CanResume = requires(Render&& render) {
    Resuming(std::forward<Render>(render));
};
static_assert(CanResume<const ResumedRender&> && CanResume<ResumedRender&>);
static_assert(!CanResume<ResumedRender> && !CanResume<const ResumedRender>, "it would be gone at once");

}  // namespace

// Without drawing, rays find visible surfaces and shadows, as in a viewport.
TEST_F(SessionTest, RasterViewIsThereOnADeviceThatCannotDrawIt) {
    const auto render = [](rhi::Device& device, const passes::RasterSettings& raster) {
        SessionDesc desc;
        desc.settings.size = {24, 24};
        desc.settings.view = View::Raster;
        desc.settings.raster = raster;
        Session session(device, LoadInput(test::SceneFile("terrace.gltf")), desc);
        session.Run({.samples = 1});
        return session.Result().render.radiance;
    };
    const Texels drawn = render(
        Device(), {.shadows = passes::RasterShadows::Rays, .hasOcclusion = false, .hasTransmission = false});
    testing::FakeLoader loader;
    loader.Tell().cannotDraw = true;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
    const Texels traced = render(*device, {.shadows = passes::RasterShadows::Rays});
    EXPECT_EQ(render(*device, {.shadows = passes::RasterShadows::Maps}), traced);
    ASSERT_EQ(traced.size(), drawn.size());
    size_t differing = 0;
    double sum = 0.0;
    for (size_t i = 0; i < traced.size(); ++i) {
        sum += static_cast<double>(traced[i]);
        differing += std::abs(traced[i] - drawn[i]) > 0.01f * std::max(1.0f, drawn[i]) ? 1 : 0;
    }
    EXPECT_GT(sum, 0.1 * static_cast<double>(traced.size()));
    EXPECT_LE(differing, traced.size() / 50) << "edges, where either surface may be seen";
}

// The file records one of them, and a resumed render would load that one.
TEST_F(SessionTest, SceneThatWasLoadedMustBeTheOneOfTheSettings) {
    const auto ofScene = [](const char* choice) {
        return LoadInput(test::SceneFile("cornell.gltf"), {.scene = choice});
    };
    SessionDesc desc = Small();
    ExpectSettingRefused(desc, ofScene("0"),
                         "scene: the default one of cornell.gltf is to be rendered, but \"0\" was loaded");
    desc.settings.scene = "0";
    ExpectSettingRefused(desc, Cornell(),
                         "scene: \"0\" of cornell.gltf is to be rendered, but the default one was loaded");
    ExpectSettingRefused(desc, MakeInput({}, "ours"), "scene: \"0\" of ours");
    Session session(Device(), ofScene("0"), desc);
    session.Run({.samples = 1});
    EXPECT_EQ(session.Result().render.settings.at("scene"), "0");
}

TEST_F(SessionTest, CameraThatIsNotInTheSceneIsASettingThatCannotBe) {
    SessionDesc desc = Small();
    desc.settings.camera = "top";
    ExpectSettingRefused(desc, Cornell(), "camera: there is no camera \"top\"; the scene has 0 \"");
    ExpectSettingRefused(desc, MakeInput({}, "ours"),
                         "camera: there is no camera \"top\"; the scene has none");
}

TEST_F(SessionTest, EnvironmentOfAHostLightsTheScene) {
    const test::TemporaryFolder folder;
    image::WriteHdr(folder / "sky.hdr", Map(2.0f));
    SceneInput fromFile = Sphere();
    LoadEnvironment(fromFile, folder / "sky.hdr");
    EXPECT_EQ(fromFile.environmentFile, "sky.hdr");
    SceneInput fromMemory = Sphere();
    SetEnvironment(fromMemory, Map(2.0f), "sky.hdr");
    EXPECT_EQ(fromMemory.environmentHash, fromFile.environmentHash);
    EXPECT_EQ(fromMemory.environmentHash, HashOf(Map(2.0f)));
    EXPECT_EQ(LoadInput(test::SceneFile("furnace_sphere.gltf"), {.environment = folder / "sky.hdr"})
                  .environmentHash,
              fromFile.environmentHash);

    const auto render = [](SceneInput input) {
        Session session(Device(), std::move(input), Small());
        session.Run({.samples = 4});
        return session.Result().render;
    };
    const RenderFile ofFile = render(std::move(fromFile)), ofMemory = render(std::move(fromMemory));
    EXPECT_EQ(ofFile.radiance, ofMemory.radiance);
    EXPECT_EQ(ofMemory.radiance.front(), 2.0f) << "the corner sees the map alone";
    EXPECT_EQ(ofMemory.environmentFile, "sky.hdr");
    EXPECT_EQ(FirstMismatch(ofFile, ofMemory), "");
}

TEST_F(SessionTest, EnvironmentOfAHostIsJudgedAsTheSceneIs) {
    const auto lit = [](float radiance, const char* name) {
        SceneInput input = Sphere();
        SetEnvironment(input, Map(radiance), name);
        return input;
    };
    SessionDesc desc = Small();
    Session session(Device(), lit(2.0f, "sky"), desc);
    session.Run({.samples = 2});
    const ResumedRender before{"a.exr", session.Result().render};
    EXPECT_EQ(Session(Device(), lit(2.0f, "sky"), Resuming(before)).SampleCount(), 2u);
    const auto expectRefused = [&](SceneInput input, const char* part) {
        ExpectError(
            ErrorKind::BadInput, [&] { Session(Device(), std::move(input), Resuming(before)); }, part);
    };
    expectRefused(lit(3.0f, "sky"), "environment: the content of sky has changed");
    expectRefused(lit(2.0f, "dusk"), "environment: sky against dusk");
    expectRefused(Sphere(), "environment: sky against none");

    desc.firstSample = 2;
    const auto partOf = [&](SceneInput input) {
        Session other(Device(), std::move(input), desc);
        other.Run({.samples = 2});
        return NamedRender{"b.exr", other.Result().render};
    };
    EXPECT_EQ(Merge({{"a.exr", before.render}, partOf(lit(2.0f, "sky"))}).environmentHash, HashOf(Map(2.0f)));
    ExpectError(
        ErrorKind::BadInput,
        [&] {
            Merge({{"a.exr", before.render}, partOf(lit(3.0f, "sky"))});
        },
        "environment: the content of sky has changed");
}

TEST(SceneInput, MapThatIsNoneChangesNothing) {
    SceneInput input = MakeInput({}, "ours");
    const image::ImageF pixel{.width = 1, .height = 1, .rgba = {1.0f, 1.0f, 1.0f, 1.0f}};
    SetEnvironment(input, pixel, "sky");
    const auto expectRefused = [&](image::ImageF map, const char* name, const char* part) {
        ExpectError(
            ErrorKind::Usage, [&] { SetEnvironment(input, std::move(map), name); }, part);
    };
    expectRefused(pixel, "", "the map has no name");
    expectRefused({}, "dusk", "\"dusk\": 0 x 0 pixels");
    expectRefused({.width = 2, .height = 1, .rgba = pixel.rgba}, "dusk", "need 8 values, and there are 4");
    ExpectError(
        ErrorKind::BadInput, [&] { LoadEnvironment(input, "missing.hdr"); }, "missing.hdr");
    EXPECT_EQ(input.environmentFile, "sky");
    EXPECT_EQ(input.environment.rgba, pixel.rgba);
}

// Settings that the parser of texts refuses could be rendered, but the file could never be read again.
TEST_F(SessionTest, SettingsThatNoTextGivesAreRefused) {
    const auto expectRefused = [](auto&& change, const char* part) {
        SessionDesc desc = Small();
        change(desc.settings);
        ExpectRefused(desc, ErrorKind::Usage, part);
    };
    expectRefused([](PictureSettings& s) { s.paths.biases.clampIndirect = 1e-7f; },
                  "clamp-indirect: \"1e-07\"");
    expectRefused([](PictureSettings& s) { s.paths.biases.regularize = NAN; }, "regularize: ");
    expectRefused([](PictureSettings& s) { s.size = {0, 8}; }, "size: \"0x8\"");
    expectRefused([](PictureSettings& s) { s.background = {0.0f, -1.0f, 0.0f}; }, "background: ");
    expectRefused([](PictureSettings& s) { s.aperture = -1.0f; }, "aperture: ");
    expectRefused([](PictureSettings& s) { s.lightGroups = {{"rest", {"Light"}}}; }, "light-group: ");
    expectRefused([](PictureSettings& s) { s.lightGroups = {{"lamps", {"a,b"}}}; }, "light-group: ");
}

TEST_F(SessionTest, RunsThatCannotEndAreRefused) {
    Session session(Device(), Cornell(), Small());
    const auto expectRefused = [&](const StopRule& rule, const char* part) {
        ExpectError(
            ErrorKind::Usage, [&] { session.Run(rule); }, part);
    };
    expectRefused({}, "without an end");
    expectRefused({.samples = 0}, "0 samples");
    for (const double seconds : {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL}) {
        SCOPED_TRACE(seconds);
        expectRefused({.samples = 2, .seconds = seconds}, "seconds");
    }
    for (const double error : {std::numeric_limits<double>::quiet_NaN(), 0.0, -0.5}) {
        SCOPED_TRACE(error);
        expectRefused({.samples = 2, .relativeError = error}, "relative error");
    }
    EXPECT_EQ(session.SampleCount(), 0u);
    session.Run({.samples = 1, .seconds = -1.0});
    EXPECT_EQ(session.SampleCount(), 1u) << "late before it began";
    expectRefused({.samples = 0}, "0 samples");
}

TEST_F(SessionTest, RunForAnErrorEndsWhereThereIsNoLight) {
    SessionDesc dark = Small();
    dark.settings.light = DefaultLight::None;
    Session session(Device(), LoadInput(test::SceneFile("furnace_sphere.gltf")), dark);
    session.Run({.samples = 200, .relativeError = 0.1});
    EXPECT_GE(session.SampleCount(), 64u);
    EXPECT_LE(session.SampleCount(), 65u);
    EXPECT_FALSE(session.Result().statistics.relativeError);
}

TEST_F(SessionTest, TimeLeftIsThatOfTheLimitThatIsReachedFirst) {
    Session session(Device(), Cornell(), Small());
    std::optional<double> left;
    session.Run({.samples = 8, .seconds = 1e6},
                [&](const ProgressState& state) { left = state.secondsLeft; });
    ASSERT_TRUE(left);
    EXPECT_LT(*left, 1e5);
    session.Run({.samples = 1u << 30, .seconds = 0.02},
                [&](const ProgressState& state) { left = state.secondsLeft; });
    EXPECT_LT(*left, 1.0);
}

// This also holds for a run that continues a picture.
TEST_F(SessionTest, SpeedIsThatOfTheSamplesOfTheRun) {
    SessionDesc desc = Small();
    desc.settings.size = {4, 4};
    Session session(Device(), Cornell(), desc);
    session.Run({.samples = 1000});
    double shown = 0.0;
    const RunSummary run =
        session.Run({.samples = 1040}, [&](const ProgressState& state) { shown = state.samplesPerSecond; });
    ASSERT_TRUE(run.samplesPerSecond);
    EXPECT_GT(shown, 0.1 * *run.samplesPerSecond);
    EXPECT_LT(shown, 10.0 * *run.samplesPerSecond);
}

TEST_F(SessionTest, ProgressEstimatesTheErrorOfTheResult) {
    Session session(Device(), Cornell(), Small());
    std::optional<double> shown;
    session.Run({.samples = 96}, [&](const ProgressState& state) { shown = state.relativeError; });
    const std::optional<double> has = session.Result().statistics.relativeError;
    ASSERT_TRUE(shown && has);
    EXPECT_GT(*shown, 0.3 * *has);
    EXPECT_LT(*shown, 3.0 * *has);
}

TEST_F(SessionTest, RenderThatNoReaderCheckedIsNotResumed) {
    SessionDesc desc = Small();
    Session session(Device(), Cornell(), desc);
    session.Run({.samples = 2});
    const ResumedRender whole{"a.exr", session.Result().render};
    desc.resumed = &whole;
    EXPECT_EQ(Session(Device(), Cornell(), desc).SampleCount(), 2u);
    const auto expectRefused = [&](auto&& change, const char* part) {
        ResumedRender broken = whole;
        change(broken.render);
        SessionDesc other = Small();
        other.resumed = &broken;
        ExpectRefused(other, ErrorKind::BadInput, part);
    };
    expectRefused([](RenderFile& r) { r.samples.clear(); }, "a.exr cannot be resumed: it has no samples");
    expectRefused([](RenderFile& r) { r.samples = {{0, 1}, {2, 1}}; }, "0-0 2-2");
    expectRefused([](RenderFile& r) { r.sums = {}; }, "sum0.R");
    expectRefused([](RenderFile& r) { r.variance.clear(); }, "variance.R");
    expectRefused([](RenderFile& r) { r.sums.radiance = passes::MakeExactSums(3, true); },
                  "sums of radiance");
}

// The editor saves renders without sums of surfaces: those are traced again at the beginning of a run.
class RestoringTest : public SessionTest {
  protected:
    RestoringTest() {
        m_whole.settings.size = {8, 8};
        m_whole.aovs = {Aov::Albedo, Aov::Normal};
        Session session(Device(), Cornell(), m_whole);
        session.Run({.samples = 3});
        m_saved = {"saved.exr", session.Result().render};
        m_saved.render.sums.albedo = {};
        m_saved.render.sums.normal = {};
    }

    SessionDesc m_whole;
    ResumedRender m_saved;
};

TEST_F(RestoringTest, SurfacesAreRestoredWithProgress) {
    Session session(Device(), Cornell(), Resuming(m_saved));
    std::vector<uint32_t> restored, done;
    session.Run({.samples = 5}, [&](const ProgressState& state) {
        EXPECT_EQ(state.samplesWanted, 5u);
        if (state.samplesRestored) {
            EXPECT_EQ(state.samplesDone, 3u);
            EXPECT_TRUE(done.empty()) << "before the samples";
            restored.push_back(*state.samplesRestored);
        } else {
            done.push_back(state.samplesDone);
        }
    });
    EXPECT_EQ(restored, (std::vector<uint32_t>{1, 2, 3}));
    EXPECT_EQ(done.size(), 2u);
    Session once(Device(), Cornell(), m_whole);
    once.Run({.samples = 5});
    EXPECT_EQ(session.Result().render.albedo, once.Result().render.albedo);
    EXPECT_EQ(session.Result().render.sums.normal.sums, once.Result().render.sums.normal.sums);
}

TEST_F(RestoringTest, StoppedRestoringIsGoneOnWith) {
    Session session(Device(), Cornell(), Resuming(m_saved));
    uint32_t asked = 0;
    const RunSummary stopped = session.Run({.samples = 5, .isStopRequested = [&] { return ++asked > 2; }});
    EXPECT_TRUE(stopped.wasStopped);
    EXPECT_EQ(asked, 3u);
    EXPECT_FALSE(session.HasResult());
    EXPECT_EQ(session.SampleCount(), 3u) << "those of the file";
    ExpectError(
        ErrorKind::Usage, [&] { session.Result(); }, "no result before a run");

    uint32_t restored = 0;
    session.Run({.samples = 4},
                [&](const ProgressState& state) { restored += state.samplesRestored ? 1 : 0; });
    EXPECT_EQ(restored, 1u) << "two were before";
    ASSERT_TRUE(session.HasResult());
    Session once(Device(), Cornell(), m_whole);
    once.Run({.samples = 4});
    EXPECT_EQ(session.Result().render.albedo, once.Result().render.albedo);
}

}  // namespace raygraph::session::session_test

// Tests of how a session decides on the studio, records it, and takes it from a file. They need a device.
namespace raygraph::session::session_light_test {

namespace {

using test::ExpectError;

class SessionLightTest : public testing::VulkanTest {
  protected:
    static SceneInput Dark() { return LoadInput(test::SceneFile("furnace_sphere.gltf")); }
    static SceneInput Lit() { return LoadInput(test::SceneFile("cornell.gltf")); }
    static PictureSettings Small(DefaultLight light = DefaultLight::Auto) {
        PictureSettings settings;
        settings.size = {8, 8};
        settings.light = light;
        return settings;
    }
    static RenderFile Render(SceneInput input, const PictureSettings& settings, uint32_t firstSample = 0) {
        Session session(Device(), std::move(input), {.settings = settings, .firstSample = firstSample});
        session.Run({.samples = 1});
        return session.Result().render;
    }
    static std::string LightOf(const RenderFile& render) {
        return render.settings.at(std::string(kLightSetting));
    }
};

}  // namespace

TEST_F(SessionLightTest, ASceneWithoutLightIsShownInTheStudio) {
    const RenderFile render = Render(Dark(), {.size = {8, 8}});
    EXPECT_EQ(LightOf(render), "studio");
    for (size_t i = 0; i < render.radiance.size(); i += 4) EXPECT_GT(render.radiance[i], 0.0f);
    const RenderFile dark = Render(Dark(), Small(DefaultLight::None));
    EXPECT_EQ(LightOf(dark), "none");
    EXPECT_EQ(test::SumOf(dark.radiance), 0.0);
    PictureSettings black = Small();
    black.background = {0.0f, 0.0f, 0.0f};
    const RenderFile withBackground = Render(Dark(), black);
    EXPECT_EQ(LightOf(withBackground), "none");
    EXPECT_EQ(test::SumOf(withBackground.radiance), 0.0);
}

TEST_F(SessionLightTest, ASceneWithALampHasTheBitsThatItHasWithoutAStudio) {
    const RenderFile render = Render(Lit(), Small());
    EXPECT_EQ(LightOf(render), "none");
    EXPECT_EQ(render.radiance, Render(Lit(), Small(DefaultLight::None)).radiance);
    const RenderFile asked = Render(Lit(), Small(DefaultLight::Studio));
    EXPECT_EQ(LightOf(asked), "studio");
    EXPECT_GT(test::SumOf(asked.radiance), 1.1 * test::SumOf(render.radiance)) << "around the box, at least";
}

TEST_F(SessionLightTest, WhatIsSeenDecidesNothing) {
    for (const bool isLit : {false, true}) {
        const SceneInput input = isLit ? Lit() : Dark();
        const DefaultLight expected = isLit ? DefaultLight::None : DefaultLight::Studio;
        PictureSettings settings = Small();
        EXPECT_EQ(ChooseLight(input, settings), expected);
        settings.size = {4096, 16};
        settings.crop = passes::Region{4000, 3, 1, 1};
        settings.camera = "0 900 0 0 1000 0 0 0 1 10";
        settings.paths.seed = 7;
        settings.isAdaptive = true;
        EXPECT_EQ(ChooseLight(input, settings), expected);
        settings.view = View::Raster;
        EXPECT_EQ(ChooseLight(input, settings), expected);
        settings.view = View::Normals;
        EXPECT_EQ(ChooseLight(input, settings), DefaultLight::None) << "it shows no light";
    }
    SceneInput mapped = Dark();
    SetEnvironment(mapped, {1, 1, {0, 0, 0, 1}}, "black");
    EXPECT_EQ(ChooseLight(mapped, Small()), DefaultLight::None);
}

TEST_F(SessionLightTest, AResumedRenderSaysWhetherThereIsAStudio) {
    for (const DefaultLight light : {DefaultLight::None, DefaultLight::Studio}) {
        ResumedRender first{"first.exr", Render(Dark(), Small(light))};
        SessionDesc desc = Resuming(first);
        desc.settings.light = DefaultLight::Auto;  // as for the pictures of a sequence
        Session session(Device(), Dark(), desc);
        session.Run({.samples = 2});
        EXPECT_EQ(LightOf(session.Result().render), Name(light));
        PictureSettings all = Small(light);
        Session whole(Device(), Dark(), {.settings = all});
        whole.Run({.samples = 2});
        EXPECT_EQ(session.Result().render.radiance, whole.Result().render.radiance);
        // A file that was rendered in the other light is refused
        const DefaultLight other = light == DefaultLight::None ? DefaultLight::Studio : DefaultLight::None;
        const ResumedRender unlike{"other.exr", Render(Dark(), Small(other))};
        ExpectError(
            ErrorKind::BadInput, [&] { session.StartPicture({.resumed = &unlike}); }, "other.exr", "light: ");
    }
}

TEST_F(SessionLightTest, RendersWithAndWithoutAStudioAreNotMerged) {
    ExpectError(
        ErrorKind::BadInput,
        [] {
            Merge({{"a.exr", Render(Dark(), Small())},
                   {"b.exr", Render(Dark(), Small(DefaultLight::None), 1)}});
        },
        "a.exr and b.exr differ", "light: studio against none");
    const RenderFile merged = Merge(
        {{"a.exr", Render(Dark(), Small())}, {"b.exr", Render(Dark(), Small(DefaultLight::Studio), 1)}});
    EXPECT_EQ(LightOf(merged), "studio");
}

TEST_F(SessionLightTest, AFileThatDoesNotSayIsWithoutAStudio) {
    const test::TemporaryFolder folder;
    WriteRenderFile(folder / "a.exr", Render(Dark(), Small(DefaultLight::None)));
    EXPECT_EQ(LightOf(ReadRenderFile(folder / "a.exr")), "none");
    image::ExrImage file = image::ReadExr(folder / "a.exr");
    ASSERT_EQ(file.attributes.erase("raygraph.setting.light"), 1u);
    image::WriteExr(folder / "old.exr", file);
    const ResumedRender old = ReadResumedRender(folder / "old.exr");
    EXPECT_EQ(LightOf(old.render), "none");
    Session session(Device(), Dark(), Resuming(old));
    session.Run({.samples = 2});
    EXPECT_EQ(test::SumOf(session.Result().render.radiance), 0.0);
}

TEST_F(SessionLightTest, AStudioGoesWithNoOtherEnvironment) {
    PictureSettings settings = Small(DefaultLight::Studio);
    settings.background = {1.0f, 1.0f, 1.0f};
    ExpectError(
        ErrorKind::Usage, [&] { const Session session(Device(), Dark(), {.settings = settings}); },
        "light: the studio takes the place of a background");
    SceneInput mapped = Dark();
    SetEnvironment(mapped, {1, 1, {1, 1, 1, 1}}, "white");
    ExpectError(
        ErrorKind::Usage,
        [&] { const Session session(Device(), mapped, {.settings = Small(DefaultLight::Studio)}); },
        "light: the studio takes the place of the map white");
}

TEST_F(SessionLightTest, TheColorOfTheStudioIsGrayAndThatOfItsTint) {
    PictureSettings settings = Small();
    settings.environmentTint = {1.0f, 0.5f, 0.25f};
    const std::optional<glm::dvec3> color = LightColor(Dark(), settings);
    ASSERT_TRUE(color);
    EXPECT_NEAR(color->y / color->x, 0.5, 1e-6);
    EXPECT_NEAR(color->z / color->x, 0.25, 1e-6);
    settings.light = DefaultLight::None;
    EXPECT_FALSE(LightColor(Dark(), settings));
}

}  // namespace raygraph::session::session_light_test

// Tests that the forms of the integrator render the same picture. It needs a device.
namespace raygraph::session::session_forms_test {

// A scene with settings that the tests render in different ways.
struct SessionCase {
    const char* scene;
    SettingTexts settings;
    bool hasAll = false;  // all channels, and light groups
};

inline void PrintTo(const SessionCase& of, std::ostream* out) {
    *out << of.scene;
    for (const auto& [name, text] : of.settings) *out << " " << name << "=" << text;
    if (of.hasAll) *out << " with all channels";
}

class SessionCaseTest : public testing::VulkanTest, public ::testing::WithParamInterface<SessionCase> {
  protected:
    // Settings in `more` replace those of the case.
    static RenderFile RenderCase(const SessionCase& of, const SettingTexts& more, uint32_t samples,
                                 uint32_t batchSize = 0, const TracingChoice& tracing = {}) {
        SettingTexts texts = more;
        texts.insert(of.settings.begin(), of.settings.end());
        SessionDesc desc;
        desc.batchSize = batchSize;
        desc.tracing = tracing;
        desc.settings = SettingsFrom(texts);
        if (of.hasAll) {
            desc.settings.lightGroups = {{"all", {"*"}}};
            for (const Aov aov : kAovs) desc.aovs.Set(aov, CanHave(aov, desc.settings));
        }
        Session session(
            Device(), LoadInput(test::SceneFile(of.scene), {.pointsAndLines = desc.settings.pointsAndLines}),
            desc);
        session.Run({.samples = samples});
        EXPECT_EQ(session.NonFiniteSamples(), 0u);
        return std::move(session.Result()).render;
    }
};

namespace {

using passes::IntegratorForm;

class SessionFormsTest : public SessionCaseTest {
  protected:
    static RenderFile Render(const SessionCase& of, const TracingChoice& tracing, uint32_t samples = 4,
                             uint32_t batchSize = 1) {
        return RenderCase(of, {{"size", "20x12"}}, samples, batchSize, tracing);
    }
    static double MeanOfColors(const Texels& texels) {
        double sum = 0.0;
        for (size_t i = 0; i < texels.size(); ++i)
            if (i % 4 != 3) sum += static_cast<double>(texels[i]);
        return sum / std::max(static_cast<double>(texels.size()), 1.0);
    }
    // Mesa's CPU driver rounds identically in all shaders. Other compilers contract expressions differently
    // in each shader, so that a few paths differ.
    static void ExpectSame(const Texels& texels, const Texels& others, const char* what) {
        ASSERT_EQ(texels.size(), others.size()) << what;
        if (Device().Info().type == rhi::DeviceType::Cpu)
            EXPECT_TRUE(texels == others) << what;
        else
            EXPECT_NEAR(MeanOfColors(texels), MeanOfColors(others), 0.1 * MeanOfColors(texels) + 1e-6)
                << what;
    }
    static void ExpectSame(const RenderFile& a, const RenderFile& b) {
        ExpectSame(a.radiance, b.radiance, "radiance");
        ASSERT_EQ(AovsOf(a), AovsOf(b));
        for (const Aov aov : kAovs)
            if (const Texels* mean = MeanOf(a, aov)) ExpectSame(*mean, *MeanOf(b, aov), Name(aov));
        ASSERT_EQ(a.lightGroups.size(), b.lightGroups.size());
        for (size_t i = 0; i < a.lightGroups.size(); ++i)
            ExpectSame(a.lightGroups[i], b.lightGroups[i], "light group");
    }
};

}  // namespace

TEST_P(SessionFormsTest, TheWavefrontGivesThePictureOfTheLoop) {
    const RenderFile loop = Render(GetParam(), {.form = IntegratorForm::Loop});
    EXPECT_GT(MeanOfColors(loop.radiance), 0.0);
    ExpectSame(loop, Render(GetParam(), {.form = IntegratorForm::Wavefront}));
}

// Hits differ in the last bits, so that a few paths differ.
TEST_P(SessionFormsTest, OwnTraversalGivesThePictureOfTheDriver) {
    const auto expectAlike = [](const Texels& own, const Texels& driver, const char* what) {
        ASSERT_EQ(own.size(), driver.size()) << what;
        size_t unlike = 0;
        for (size_t i = 0; i < own.size(); ++i)
            unlike += std::abs(own[i] - driver[i]) > 2e-3f * (0.05f + std::abs(driver[i]));
        EXPECT_LT(unlike, own.size() / 5) << what;
        EXPECT_NEAR(MeanOfColors(own), MeanOfColors(driver), 0.03 * MeanOfColors(driver) + 1e-6) << what;
    };
    const RenderFile own = Render(GetParam(), {.traversal = Traversal::Software}, 16),
                     driver = Render(GetParam(), {.traversal = Traversal::Driver}, 16);
    expectAlike(own.radiance, driver.radiance, "radiance");
    ASSERT_EQ(AovsOf(own), AovsOf(driver));
    for (const Aov aov : kAovs)
        if (const Texels* mean = MeanOf(own, aov); mean && !mean->empty())
            expectAlike(*mean, *MeanOf(driver, aov), Name(aov));
    for (size_t i = 0; i < own.lightGroups.size(); ++i)
        expectAlike(own.lightGroups[i], driver.lightGroups[i], "light group");
}

// The frames have 1, 1, 2, 4, 4 and 1 samples, as at the beginning and at the end of a picture.
TEST_P(SessionFormsTest, SeveralSamplesAtOnceGiveTheBitsOfOneAfterTheOther) {
    const TracingChoice form{.form = GetParam().hasAll ? IntegratorForm::Wavefront : IntegratorForm::Loop};
    const RenderFile one = Render(GetParam(), form, 13, 1);
    const RenderFile several = Render(GetParam(), form, 13, 4);
    EXPECT_EQ(one.sums.radiance, several.sums.radiance);
    EXPECT_EQ(one.sums.albedo, several.sums.albedo);
    EXPECT_EQ(one.sums.parts, several.sums.parts);
    EXPECT_EQ(one.sums.lightGroups, several.sums.lightGroups);
    EXPECT_TRUE(one.variance == several.variance);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, SessionFormsTest,
    ::testing::Values(
        SessionCase{"cornell.gltf",
                    {{"max-depth", "5"}, {"clamp-indirect", "0.5"}, {"crop", "3,2,9,5"}, {"aperture", "0.1"}},
                    true},
        SessionCase{"many_lights.gltf", {{"rr", "frame:0.5"}, {"sampler", "pcg"}}},
        SessionCase{"nested_dielectrics.gltf", {{"aperture", "0.2"}, {"background", "1,2,3"}}, true},
        SessionCase{"scattering_grid.gltf", {}}, SessionCase{"terrace.gltf", {{"texture-lod", "0"}}},
        SessionCase{"points_and_lines.gltf", {{"points", "2%"}, {"lines", "1%"}, {"nee", "off"}}}));

}  // namespace raygraph::session::session_forms_test

// Options of the command line as settings of the passes: each option changes its own setting and no other.
namespace raygraph::session::device_scene_test {

namespace {

using Parts = std::map<std::string, std::string>;

std::string Text(const glm::vec3& v) {
    return std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z);
}
template <typename T>
std::string Number(T value) {
    return std::to_string(static_cast<double>(value));
}

// Returns the state that determines a picture, as parts with names.
Parts PartsOf(DeviceScene& scene) {
    const passes::TraceSettings s = scene.SettingsFor(3);
    const EnvironmentSettings& environment = scene.Scene().Environment();
    constexpr uint64_t kLeastAutomatic =
        uint64_t{1} << 20;  // lower bound of the automatic budget, which depends on free memory
    const uint64_t budget = scene.Scene().Statistics().textureBudget;
    return {{"extent", Number(s.extent.width) + "x" + Number(s.extent.height)},
            {"region", Number(s.region.x) + "," + Number(s.region.y) + "," + Number(s.region.width) + "," +
                           Number(s.region.height)},
            {"eye", Text(s.camera.origin)},
            {"lens radius", Number(s.camera.lensRadius)},
            {"focus distance", Number(s.camera.focusDistance)},
            {"sampler", Number(s.sampler)},
            {"seed", Number(s.seed)},
            {"sample", Number(s.sampleIndex)},
            {"brdf", Number(s.scattering.brdf)},
            {"distribution", Number(s.scattering.distribution)},
            {"masking", Number(s.scattering.masking)},
            {"fresnel", Number(s.scattering.fresnel)},
            {"multiscatter", Number(s.scattering.multiscatter)},
            {"light sampling", Number(s.lights.isOn)},
            {"light sampler", Number(s.lights.sampler)},
            {"mis", Number(s.lights.mis)},
            {"roulette", Number(s.roulette.kind)},
            {"roulette's start", Number(s.roulette.start)},
            {"survival", Number(s.roulette.survival)},
            {"depth", Number(s.biases.maxDepth)},
            {"clamp", Number(s.biases.clampIndirect)},
            {"regularize", Number(s.biases.regularize)},
            {"shadow terminator", Number(s.biases.shadowTerminator)},
            {"hidden environment", Number(s.isEnvironmentHidden)},
            {"texture budget", budget < kLeastAutomatic ? Number(budget) : "automatic"},
            {"texture levels", Number(s.biases.textureLod)},
            {"instances", Number(scene.Scene().Statistics().instanceCount)},
            {"environment", Text(environment.radiance)},
            {"environment's rotation", Number(environment.rotation)},
            {"environment is the scene's", Number(environment.usesScene)},
            {"environment is the studio",
             Number(scene.Scene().ShownEnvironment().defaultLight == DefaultLight::Studio)}};
}

class DeviceSceneTest : public testing::VulkanTest {
  protected:
    static Parts PartsWith(const SettingTexts& texts, bool hasMap = false, bool sceneHasMap = false) {
        SceneInput input;
        if (sceneHasMap) input.data.environment.map = {1, 1, {1.0f, 1.0f, 1.0f, 1.0f}};
        scene::Camera camera;
        camera.cameraToWorld[3] = {0.0f, 0.0f, 5.0f};
        input.data.cameras.push_back(camera);
        camera.cameraToWorld[3] = {1.0f, 2.0f, 3.0f};
        input.data.cameras.push_back(camera);
        input.data.bounds.Extend(glm::vec3(0.0f));
        if (hasMap) input.environment = {.width = 1, .height = 1, .rgba = {1.0f, 1.0f, 1.0f, 1.0f}};
        PictureSettings settings = SettingsFrom(texts);
        if (settings.light == DefaultLight::Auto) settings.light = DefaultLight::None;
        DeviceScene scene(Device(), input, settings);
        return PartsOf(scene);
    }
    struct Change {
        const char* option;
        const char* text;
        std::set<std::string> parts;
        const char* value = nullptr;  // expected value of the only part
    };
    static void ExpectChange(const Change& change, bool hasMap = false) {
        SCOPED_TRACE(std::string("--") + change.option + " " + change.text);
        static std::map<bool, Parts> defaults;
        if (!defaults.contains(hasMap)) defaults[hasMap] = PartsWith({}, hasMap);
        const Parts &before = defaults[hasMap], after = PartsWith({{change.option, change.text}}, hasMap);
        std::set<std::string> changed;
        for (const auto& [name, value] : before)
            if (after.at(name) != value) changed.insert(name);
        EXPECT_EQ(changed, change.parts);
        if (change.value != nullptr) {
            EXPECT_EQ(after.at(*change.parts.begin()), change.value);
        }
    }
};

}  // namespace

TEST_F(DeviceSceneTest, EveryOptionOfThePictureChangesItsPartAlone) {
    const Change kChanges[] = {
        {"size", "64x32", {"extent"}},
        {"crop", "3,4,5,6", {"region"}, "3.000000,4.000000,5.000000,6.000000"},
        {"camera", "1", {"eye", "focus distance"}},
        {"aperture", "0.25", {"lens radius"}, "0.250000"},
        {"focus", "3.5", {"focus distance"}, "3.500000"},
        {"sampler", "tea", {"sampler"}, "2.000000"},
        {"seed", "7", {"seed"}, "7.000000"},
        {"brdf", "lafortune", {"brdf"}, "2.000000"},
        {"distribution", "phong", {"distribution"}, "2.000000"},
        {"masking", "shortcut", {"masking"}, "2.000000"},
        {"fresnel", "lazanyi", {"fresnel"}, "3.000000"},
        {"multiscatter", "walk", {"multiscatter"}, "2.000000"},
        {"nee", "off", {"light sampling"}, "0.000000"},
        {"light-sampler", "power", {"light sampler"}, "1.000000"},
        {"mis", "balance", {"mis"}, "0.000000"},
        {"rr", "off", {"roulette"}, "3.000000"},
        {"rr", "frame:0.5", {"roulette", "survival"}},
        {"rr-start", "5", {"roulette's start"}, "5.000000"},
        {"max-depth", "4", {"depth"}, "4.000000"},
        {"clamp-indirect", "2.5", {"clamp"}, "2.500000"},
        {"regularize", "0.5", {"regularize"}, "0.500000"},
        {"shadow-terminator", "on", {"shadow terminator"}, "1.000000"},
        {"texture-budget", "64K", {"texture budget"}, "65536.000000"},
        {"transparent", "on", {"hidden environment"}, "1.000000"},
        {"texture-lod", "-0.5", {"texture levels"}, "-0.500000"},
        {"light", "studio", {"environment is the studio"}, "1.000000"},
        {"background", "1,2,3", {"environment", "environment is the scene's"}, "1.000000 2.000000 3.000000"},
        {"ground", "on", {"instances"}, "1.000000"},
        {"env-rotation", "180", {"environment's rotation"}, "3.141593"},
        {"env-tint", "2,3,4", {"environment"}, "2.000000 3.000000 4.000000"},  // tints the studio
    };
    for (const Change& change : kChanges) ExpectChange(change);
    // With a map, the tint applies to it, and the background is not used
    ExpectChange({"env-tint", "2,3,4", {"environment"}, "2.000000 3.000000 4.000000"}, true);
    ExpectChange({"background", "1,2,3", {}}, true);
    // The scene's own environment is tinted, too; any background and any map replace it
    const auto environmentOf = [](const SettingTexts& texts, bool isMapGiven = false) {
        const Parts parts = PartsWith(texts, isMapGiven, true);
        return parts.at("environment") + ", " + parts.at("environment is the scene's");
    };
    EXPECT_EQ(environmentOf({}), "1.000000 1.000000 1.000000, 1.000000");
    EXPECT_EQ(environmentOf({{"env-tint", "2,3,4"}}), "2.000000 3.000000 4.000000, 1.000000");
    EXPECT_EQ(environmentOf({{"background", "1,2,3"}}), "1.000000 2.000000 3.000000, 0.000000");
    EXPECT_EQ(environmentOf({{"background", "0,0,0"}}), "0.000000 0.000000 0.000000, 0.000000");
    EXPECT_EQ(environmentOf({}, true), "1.000000 1.000000 1.000000, 0.000000");
    // Every setting is tested, except those that tell the command what to do with the picture
    for (const PictureSetting& setting : PictureSettingTable()) {
        const std::string name = setting.name;
        const bool isOfCommand = name == "view" || name == "scene" || name == "variant" || name == "at" ||
                                 name == "clips" || name == "shutter" || name == "points" ||
                                 name == "lines" || name == "shadows" || name == "light-group" ||
                                 name == "adaptive";
        const bool isHere = std::any_of(std::begin(kChanges), std::end(kChanges),
                                        [&](const Change& change) { return change.option == name; });
        EXPECT_NE(isHere, isOfCommand) << name;
    }
    EXPECT_EQ(PartsWith({}).at("sample"), "3.000000");
}

}  // namespace raygraph::session::device_scene_test

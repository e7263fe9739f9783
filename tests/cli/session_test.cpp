// Tests a session as a host calls it: what it refuses, and when a run ends. It needs a device.
#include "editor/session/session.h"

#include <cmath>
#include <limits>

#include "editor/session/file/content_hash.h"
#include "editor/session/file/merge.h"
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

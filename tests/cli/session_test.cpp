// Session as a host calls it: what it refuses, and when a run ends. A device is needed.
#include "editor/session/session.h"

#include <cmath>
#include <limits>

#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session {

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
};

}  // namespace

// What the parser of texts refuses could be rendered, but the file could never be read again.
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
    expectRefused([](PictureSettings& s) { s.background[1] = -1.0f; }, "background: ");
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
}

TEST_F(SessionTest, RunForAnErrorEndsWhereThereIsNoLight) {
    Session session(Device(), LoadInput(test::SceneFile("furnace_sphere.gltf")), Small());
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

}  // namespace raygraph::session

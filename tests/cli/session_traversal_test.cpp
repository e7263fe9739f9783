// Own traversal and the driver's give one picture, and a render keeps the one that it began with. A device is
// needed.
#include <cmath>

#include "editor/session/merge.h"
#include "editor/session/session.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/session_case.h"

namespace raygraph::session {

namespace {

using test::ExpectError;

std::string TraversalOf(const RenderFile& render) {
    return render.settings.at(std::string(kTraversalSetting));
}

class SessionTraversalTest : public SessionCaseTest {
  protected:
    static RenderFile Render(const SessionCase& of, const char* traversal, uint32_t samples = 16) {
        return RenderCase(of, {{"size", "40x24"}, {"traversal", traversal}}, samples);
    }
    // Hits differ in the last bits, so that now and then a path takes another turn.
    static void ExpectAlike(const Texels& own, const Texels& driver, const char* what) {
        ASSERT_EQ(own.size(), driver.size()) << what;
        size_t unlike = 0;
        double sum = 0.0, sumOfDriver = 0.0;
        for (size_t i = 0; i < own.size(); ++i) {
            unlike += std::abs(own[i] - driver[i]) > 2e-3f * (0.05f + std::abs(driver[i]));
            if (i % 4 == 3) continue;
            sum += double{own[i]};
            sumOfDriver += double{driver[i]};
        }
        EXPECT_LT(unlike, own.size() / 5) << what;
        EXPECT_NEAR(sum, sumOfDriver, 0.03 * sumOfDriver + 1e-6) << what;
    }
};

}  // namespace

TEST_P(SessionTraversalTest, GivesThePictureOfTheDriver) {
    const RenderFile own = Render(GetParam(), "own"), driver = Render(GetParam(), "driver");
    EXPECT_EQ(TraversalOf(own), "own");
    EXPECT_EQ(TraversalOf(driver), "driver");
    ExpectAlike(own.radiance, driver.radiance, "radiance");
    ASSERT_EQ(AovsOf(own), AovsOf(driver));
    for (const Aov aov : kAovs)
        if (const Texels* mean = MeanOf(own, aov); mean && !mean->empty())
            ExpectAlike(*mean, *MeanOf(driver, aov), Name(aov));
    for (size_t i = 0; i < own.lightGroups.size(); ++i)
        ExpectAlike(own.lightGroups[i], driver.lightGroups[i], "light group");
}

// All channels; glass in glass.
INSTANTIATE_TEST_SUITE_P(Scenes, SessionTraversalTest,
                         ::testing::Values(SessionCase{"cornell.gltf", {}, true},
                                           SessionCase{"nested_dielectrics.gltf", {{"max-depth", "8"}}}));

using SessionTraversal = SessionTraversalTest;

TEST_F(SessionTraversal, RoundPrimitivesAreTheDrivers) {
    const SessionCase round{"points_and_lines.gltf", {{"points", "2%"}, {"lines", "1%"}}};
    EXPECT_EQ(TraversalOf(Render(round, "own", 1)), "driver");
    EXPECT_EQ(TraversalOf(Render(round, "auto", 1)), "driver");
}

TEST_F(SessionTraversal, ARenderKeepsItWhenItGoesOn) {
    const SessionCase cornell{"cornell.gltf", {}};
    const auto goOn = [&](const ResumedRender& begun, const char* traversal) {
        SessionDesc desc = Resuming(begun);
        desc.settings.traversal = SettingsFrom({{"traversal", traversal}}).traversal;
        Session session(Device(), LoadInput(test::SceneFile("cornell.gltf")), desc);
        session.Run({.samples = 3});
        return TraversalOf(session.Result().render);
    };
    for (const char* traversal : {"own", "driver"}) {
        ResumedRender begun{.path = "begun.exr", .render = Render(cornell, traversal, 2)};
        EXPECT_EQ(goOn(begun, traversal), traversal);
        EXPECT_EQ(goOn(begun, "auto"), traversal);
        const std::string other = traversal == std::string("own") ? "driver" : "own";
        ExpectError(
            ErrorKind::BadInput, [&] { goOn(begun, other.c_str()); },
            std::string("traversal: ") + traversal + " against " + other);
    }
    // As files are from before there was another
    ResumedRender old{.path = "old.exr", .render = Render(cornell, "driver", 2)};
    old.render.settings.erase(std::string(kTraversalSetting));
    EXPECT_EQ(goOn(old, "auto"), "driver");
    ExpectError(
        ErrorKind::BadInput, [&] { goOn(old, "own"); }, "traversal: driver against own");
}

// As of an animation whose frames were begun on two devices.
TEST_F(SessionTraversal, EachPictureOfASeriesKeepsItsOwn) {
    const SessionCase cornell{"cornell.gltf", {}};
    const ResumedRender own{.path = "own.exr", .render = Render(cornell, "own", 2)};
    const ResumedRender driver{.path = "driver.exr", .render = Render(cornell, "driver", 2)};
    for (const bool isOwnFirst : {true, false}) {
        const ResumedRender &first = isOwnFirst ? own : driver, &second = isOwnFirst ? driver : own;
        SessionDesc desc = Resuming(first);
        desc.settings.traversal = passes::Traversal::Auto;
        desc.settings.paths.form = {};  // on a GPU the two may have another one each
        Session session(Device(), LoadInput(test::SceneFile("cornell.gltf")), desc);
        session.Run({.samples = 3});
        EXPECT_EQ(TraversalOf(session.Result().render), TraversalOf(first.render));
        session.StartPicture({.resumed = &second});
        session.Run({.samples = 3});
        EXPECT_EQ(TraversalOf(session.Result().render), TraversalOf(second.render));
    }
}

TEST(TraversalSetting, OneThatWasLeftOpenIsAny) {
    EXPECT_EQ(FirstDifference({{"traversal", "auto"}}, {{"traversal", "own"}}), "");
    EXPECT_EQ(FirstDifference({{"traversal", "driver"}}, {}), "");
    EXPECT_EQ(FirstDifference({{"traversal", "own"}}, {}), "traversal: own against driver");
    EXPECT_EQ(FirstDifference({{"traversal", "own"}}, {{"traversal", "driver"}}),
              "traversal: own against driver");
}

}  // namespace raygraph::session

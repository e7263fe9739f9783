// Verify on pictures with planted mistakes, and on right ones: it names what is off, and passes what is not.
#include "editor/session/verify/verify.h"

#include <cmath>
#include <iostream>
#include <string>

#include "editor/session/session.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"
#include "tests/verify/planted_mistakes.h"

namespace raygraph::session::verify_test {

namespace {
class VerifyTest : public testing::VulkanTest {};
}  // namespace

TEST_F(VerifyTest, PlantedMistakes_AreNamed) {
    PictureSettings settings;
    settings.size = {64, 48};
    const test::Host host{.device = Device(), .settings = settings, .samples = 192};
    Verify verify(Device(), test::PlantedScene(),
                  {.settings = settings, .minSamples = 256, .maxSamples = 256});
    const VerifyResult right = verify.Check(host.Render(test::PlantedScene()));
    EXPECT_TRUE(right.verdict.isRight);
    size_t named = 0;
    for (const test::PlantedMistake& planted : test::PlantedMistakes()) {
        const VerifyResult result = verify.Check(planted.picture(host));
        EXPECT_FALSE(result.verdict.isRight) << planted.what;
        const bool isNamed = planted.IsNamedBy(result.diagnosis);
        named += isNamed;
        std::cout << planted.what << (isNamed ? ": " : ": missed: ");
        if (!result.diagnosis.hypotheses.empty()) {
            const Hypothesis& best = result.diagnosis.hypotheses.front();
            std::cout << best.text << ", " << std::lround(100.0 * best.explained) << " %";
        }
        std::cout << std::endl;
    }
    // Seeds decide the pictures, and a CPU's driver gives the same bits each time: it is no matter of luck
    EXPECT_EQ(named, test::PlantedMistakes().size());
}

// A right picture is an independent render at its own noise. The bounds for tiles and for parts are such that
// one of a hundred fails each where errors are normal and the tolerance is 0. That of 5 % is the margin for
// which none fails; the seeds decide, so that the number is the same each time.
TEST_F(VerifyTest, RightPictures_PassAtTheirOwnNoise) {
    PictureSettings settings;
    settings.size = {32, 32};
    const auto load = [] { return LoadInput(raygraph::test::SourceFile("scenes/cornell.gltf")); };
    Verify verify(Device(), load(), {.settings = settings, .minSamples = 256, .maxSamples = 256});
    size_t passed = 0;
    for (uint32_t seed = 0; seed < 100; ++seed) {
        settings.paths.seed = seed;
        Session session(Device(), load(), {.settings = settings, .withSums = false});
        session.Run({.samples = 16});
        const VerifyResult result = verify.Check(PictureOf(session.Result().render, std::to_string(seed)));
        passed += result.verdict.isRight;
        for (const VerdictCheck& check : result.verdict.checks)
            if (!check.isPassed)
                std::cout << "seed " << seed << ": " << check.name << " " << check.value << ", limit "
                          << check.limit << std::endl;
    }
    EXPECT_EQ(passed, 100u);
}

}  // namespace raygraph::session::verify_test

// A few of the planted mistakes in small pictures; tests/long/verify_test.cpp has all.
#include "tests/verify/planted_mistakes.h"

#include <set>
#include <string>

#include "tests/support/vulkan_test.h"

namespace raygraph::session::planted_mistakes_test {

namespace {
class PlantedMistakesTest : public testing::VulkanTest {};
}  // namespace

// No pixel and no tile of a shifted picture is beyond its noise.
TEST_F(PlantedMistakesTest, Verify_NamesThem) {
    PictureSettings settings;
    settings.size = {48, 36};
    const test::Host host{.device = Device(), .settings = settings, .samples = 96};
    Verify verify(Device(), test::PlantedScene(),
                  {.settings = settings, .minSamples = 128, .maxSamples = 128});
    EXPECT_TRUE(verify.Check(host.Render(test::PlantedScene())).verdict.isRight);
    const std::set<std::string> chosen{"missing light", "shift of half a pixel"};
    size_t count = 0;
    for (const test::PlantedMistake& planted : test::PlantedMistakes()) {
        if (!chosen.contains(planted.what)) continue;
        ++count;
        const VerifyResult result = verify.Check(planted.picture(host));
        EXPECT_FALSE(result.verdict.isRight) << planted.what;
        EXPECT_TRUE(planted.IsNamedBy(result.diagnosis)) << planted.what;
    }
    EXPECT_EQ(count, chosen.size());
}

}  // namespace raygraph::session::planted_mistakes_test

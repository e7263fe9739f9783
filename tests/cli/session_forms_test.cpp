// Tests that the forms of the integrator render the same picture. It needs a device.
#include <algorithm>
#include <cmath>

#include "editor/session/session.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/session_case.h"

namespace raygraph::session::session_forms_test {

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
    const RenderFile own = Render(GetParam(), {.traversal = Traversal::Own}, 16),
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
    ::testing::Values(SessionCase{"cornell.gltf", {{"max-depth", "5"}, {"clamp-indirect", "0.5"}}, true},
                      SessionCase{"cornell.gltf", {{"nee", "off"}, {"crop", "3,2,9,5"}, {"aperture", "0.1"}}},
                      SessionCase{"many_lights.gltf", {{"rr", "frame:0.5"}, {"sampler", "pcg"}}},
                      SessionCase{"nested_dielectrics.gltf", {}, true},
                      SessionCase{"scattering_grid.gltf", {}},
                      SessionCase{"terrace.gltf", {{"texture-lod", "0"}}, true},
                      SessionCase{"glass_sphere.gltf", {{"aperture", "0.2"}, {"background", "1,2,3"}}},
                      SessionCase{"points_and_lines.gltf", {{"points", "2%"}, {"lines", "1%"}}}));

}  // namespace raygraph::session::session_forms_test

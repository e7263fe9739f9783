#include "editor/session/settings/bias.h"

#include <cmath>
#include <vector>

#include "editor/cli/outputs.h"
#include "editor/cli/report.h"
#include "tests/cli/cli_test.h"

namespace raygraph::session::bias_test {
namespace {

passes::TraceSettings AllOn() {
    passes::TraceSettings settings;
    settings.biases = {.maxDepth = 3,
                       .clampIndirect = 2.0f,
                       .regularize = 0.1f,
                       .shadowTerminator = true,
                       .textureLod = 0.0f};
    return settings;
}

TEST(Bias, OnlyWhatWasAskedForIsOn) {
    for (const Bias bias : kBiases) {
        EXPECT_FALSE(IsOn({}, bias)) << Name(bias);
        EXPECT_TRUE(IsOn(AllOn().biases, bias)) << Name(bias);
    }
    EXPECT_TRUE(IsOn({.maxDepth = 0}, Bias::MaxDepth));
}

TEST(Bias, WithoutOneTheOthersStay) {
    for (const Bias off : kBiases)
        for (const Bias bias : kBiases)
            EXPECT_EQ(IsOn(Without(AllOn(), off).biases, bias), bias != off) << Name(off) << Name(bias);
}

TEST(Bias, PathsThatOnlyTheDepthEndsEndByRoulette) {
    passes::TraceSettings settings = AllOn();
    settings.roulette.kind = Roulette::Off;
    EXPECT_EQ(Without(settings, Bias::MaxDepth).roulette.kind, Roulette::Throughput);
    EXPECT_EQ(Without(settings, Bias::ClampIndirect).roulette.kind, Roulette::Off);
    settings.roulette = {.kind = Roulette::Constant, .survival = 0.5f};
    EXPECT_EQ(Without(settings, Bias::MaxDepth).roulette.kind, Roulette::Constant);
    settings.roulette.survival = 1.0f;
    EXPECT_EQ(Without(settings, Bias::MaxDepth).roulette.kind, Roulette::Throughput);
}

TEST(Bias, RemovedLightIsMeasuredAsLuminance) {
    // Two gray pixels, and one red
    const std::vector<float> removed{1, 1, 1, 0, 3, 3, 3, 0, 1, 0, 0, 0};
    const std::vector<float> variance{4, 4, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    const std::vector<float> picture{5, 5, 5, 1, 5, 5, 5, 1, 5, 5, 5, 1};
    const RemovedLight light = MeasureRemoved(removed, variance, 4, picture);
    const double mean = (1.0 + 3.0 + 0.2126) / 3.0;
    EXPECT_NEAR(light.mean, mean, 1e-6);
    ASSERT_TRUE(light.standardError && light.share && light.shareStandardError);
    EXPECT_NEAR(*light.standardError, std::sqrt(4.0 / 4) / 3.0, 1e-6);
    EXPECT_NEAR(*light.share, mean / (5.0 + mean), 1e-6);
    EXPECT_NEAR(*light.shareStandardError, *light.standardError / (5.0 + mean), 1e-6);
    EXPECT_EQ(light.samples, 4u);
}

TEST(Bias, OneSecondTraceHasNoStandardErrorAndDarknessNoShare) {
    const std::vector<float> half(4, 0.5f), black(4, 0.0f);
    EXPECT_FALSE(MeasureRemoved(half, black, 1, half).standardError);
    EXPECT_TRUE(MeasureRemoved(half, black, 1, half).share);
    EXPECT_FALSE(MeasureRemoved(black, black, 8, black).share);
}

TEST(Bias, IsDescribedWithItsShareAndError) {
    EXPECT_EQ(cli::Describe(Bias::MaxDepth, {.share = 0.25, .shareStandardError = 0.003}),
              "--max-depth removed 25 % +- 0.3 % of the light");
    EXPECT_EQ(cli::Describe(Bias::Regularize, {.share = -0.0125}),
              "--regularize removed -1.25 % of the light");
}

TEST(Bias, AovsAreThoseOfTheBiasesThatAreOn) {
    PictureSettings settings;
    settings.paths.biases.maxDepth = 3;
    const AovSet all = cli::AovsFor(cli::ParseAovs("all"), settings);
    EXPECT_TRUE(all.Has(Aov::RemovedMaxDepth) && all.Has(Aov::Emission));
    EXPECT_FALSE(all.Has(Aov::RemovedClampIndirect) || all.Has(Aov::RemovedRegularize));
    test::ExpectError(
        ErrorKind::Usage, [&] { cli::AovsFor(cli::ParseAovs("removed_regularize"), settings); },
        "--aov removed_regularize", "--regularize is off");
}

}  // namespace
}  // namespace raygraph::session::bias_test

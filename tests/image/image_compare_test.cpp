// Tests the statistics by which other tests judge pictures: correct pictures pass as often as stated, and
// wrong ones are detected.
#include "tests/support/image_compare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace raygraph::test::image_compare_test {
namespace {

// Draws pixels around a reference with a known variance, which is that of a mean over samples.
struct NoisyPicture {
    uint32_t width, height;
    std::vector<float> reference, variance, mean;

    PlaneView View(const std::vector<float>& plane) const { return {width, height, plane}; }
    ZTestResult Test(double significance) const {
        return ZTest({View(mean), View(variance)}, {View(reference), {}}, {.significance = significance});
    }
};

// `bias` scales the pixels' expectation, `noise` their standard deviation, but not the variance that they
// state.
NoisyPicture Draw(std::mt19937& random, uint32_t width, uint32_t height, double relativeError,
                  double bias = 1.0, double noise = 1.0) {
    std::normal_distribution<double> normal;
    NoisyPicture picture{width, height, {}, {}, {}};
    for (uint32_t i = 0; i < width * height; ++i) {
        const double expected = 0.2 + (i % 17) / 8.0, error = relativeError * expected;
        picture.reference.push_back(static_cast<float>(expected));
        picture.variance.push_back(static_cast<float>(error * error));
        picture.mean.push_back(static_cast<float>(bias * expected + noise * error * normal(random)));
    }
    return picture;
}

TEST(ZTest, RightPictureIsCalledWrongAsOftenAsStated) {
    constexpr int kPictures = 2000;
    constexpr double kSignificance = 0.05;
    std::mt19937 random(1);
    int wrongCount = 0;
    for (int i = 0; i < kPictures; ++i)
        wrongCount += Draw(random, 16, 16, 0.1).Test(kSignificance).HasFailures();
    // The count is binomial: five standard deviations either way are allowed.
    const double deviation = std::sqrt(kPictures * kSignificance * (1 - kSignificance));
    EXPECT_NEAR(wrongCount, kPictures * kSignificance, 5 * deviation);
}

TEST(ZTest, NominalFractionOfARightPictureIsTheSignificance) {
    std::mt19937 random(2);
    const ZTestResult result = Draw(random, 200, 200, 0.1).Test(0.05);
    EXPECT_NEAR(result.nominalFraction, 0.05, 5 * std::sqrt(0.05 * 0.95 / 40000));
    EXPECT_LT(std::abs(result.overallZ), 5.0);
}

TEST(ZTest, BiasOfOnePercentIsFoundByTheSumWhereNoPixelShowsIt) {
    std::mt19937 random(3);
    const ZTestResult result = Draw(random, 200, 200, 0.1, 1.01).Test(0.01);
    EXPECT_FALSE(result.HasFailures());
    EXPECT_GT(result.overallZ, 8.0);
    EXPECT_LT(Draw(random, 200, 200, 0.1, 0.99).Test(0.01).overallZ, -8.0);
}

TEST(ZTest, BiasOfOnePercentFailsAlmostEveryPixelOfAQuietPicture) {
    std::mt19937 random(4);
    EXPECT_GT(Draw(random, 100, 100, 0.001, 1.01).Test(0.01).failedFraction, 0.99);
}

TEST(ZTest, OneWrongPixelIsFoundAndNamed) {
    std::mt19937 random(5);
    NoisyPicture picture = Draw(random, 100, 100, 0.1);
    ASSERT_FALSE(picture.Test(0.01).HasFailures());
    picture.mean[4321] += 8.0f * std::sqrt(picture.variance[4321]);
    const ZTestResult result = picture.Test(0.01);
    EXPECT_EQ(result.failedCount, 1u);
    EXPECT_EQ(result.failedFraction, 1e-4);
    EXPECT_EQ(result.greatestPixel, 4321u);
}

TEST(ZTest, UnderstatedVarianceRaisesTheNominalFraction) {
    std::mt19937 random(6);
    EXPECT_GT(Draw(random, 100, 100, 0.1, 1.0, 1.5).Test(0.05).nominalFraction, 0.15);
}

TEST(ZTest, VarianceOfTheReferenceCounts) {
    const std::vector<float> reference = {1.0f}, mean = {1.5f}, variance = {0.0625f}, large = {0.1875f};
    const auto view = [](const std::vector<float>& plane) { return PlaneView{1, 1, plane}; };
    EXPECT_NEAR(ZTest({view(mean), view(variance)}, {view(reference), {}}).greatestZ, 2.0, 1e-12);
    EXPECT_NEAR(ZTest({view(mean), view(variance)}, {view(reference), view(large)}).greatestZ, 1.0, 1e-12);
}

TEST(ZTest, WithoutVarianceOnlyRoundingPasses) {
    const std::vector<float> reference = {1.0f, 0.0f}, rounded = {1.000001f, 0.0f}, wrong = {1.001f, 0.0f};
    const auto view = [](const std::vector<float>& plane) { return Estimate{{2, 1, plane}, {}}; };
    EXPECT_FALSE(ZTest(view(rounded), view(reference)).HasFailures());
    EXPECT_EQ(ZTest(view(wrong), view(reference)).failedCount, 1u);
}

TEST(ZTest, NonFinitePixelFails) {
    const float bad[] = {std::nanf(""), std::numeric_limits<float>::infinity()};
    const std::vector<float> good = {1.0f, 1.0f}, variance = {1.0f, 1.0f};
    for (const float value : bad) {
        const std::vector<float> broken = {1.0f, value};
        const auto test = [&](const std::vector<float>& mean, const std::vector<float>& varianceOfMean) {
            return ZTest({{2, 1, mean}, {2, 1, varianceOfMean}}, {{2, 1, good}, {}}).failedCount;
        };
        EXPECT_EQ(test(broken, variance), 1u);
        EXPECT_EQ(test(good, broken), 1u);
        EXPECT_EQ(test(good, variance), 0u);
    }
}

TEST(ZTest, ThresholdIsSidakCorrected) {
    EXPECT_NEAR(TwoSidedDeviate(0.05), 1.959963984540054, 1e-9);
    EXPECT_NEAR(TwoSidedProbability(-3.0), 0.0026997960632602, 1e-12);
    std::mt19937 random(7);
    const ZTestResult result = Draw(random, 100, 10, 0.1).Test(0.05);
    EXPECT_NEAR(std::pow(1 - TwoSidedProbability(result.threshold), 1000), 0.95, 1e-9);
}

TEST(ZTest, PlanesMustFit) {
    const std::vector<float> four(4), three(3);
    const Estimate square{{2, 2, four}, {}};
    EXPECT_THROW(ZTest(square, {{4, 1, four}, {}}), std::invalid_argument);
    EXPECT_THROW(ZTest(square, {{2, 2, three}, {}}), std::invalid_argument);
    EXPECT_THROW(ZTest(square, {{2, 2, four}, {1, 3, three}}), std::invalid_argument);
    EXPECT_THROW(Mean({}), std::invalid_argument);
}

TEST(ImageCompare, ClosedValues) {
    const std::vector<float> rgba = {1, 0, 2, 0, 3, 0, 6, 0};
    const PlaneView red{2, 1, rgba, 4}, blue{2, 1, std::span<const float>(rgba).subspan(2), 4};
    EXPECT_EQ(Mean(red), 2.0);
    EXPECT_EQ(Mean(blue), 4.0);
    EXPECT_EQ(MaxAbsDifference(red, blue), 3.0);
    EXPECT_DOUBLE_EQ(RelativeMse(red, blue, 0.0), (1.0 / 4 + 9.0 / 36) / 2);
    EXPECT_DOUBLE_EQ(RelativeMse(red, blue, 5.0), (1.0 / 9 + 9.0 / 41) / 2);
    const std::vector<float> broken = {1, std::nanf("")};
    EXPECT_TRUE(std::isnan(MaxAbsDifference(red, {2, 1, broken})));
}

TEST(ImageCompare, BlocksAtTheEdgeAreMeansOfWhatTheyHold) {
    std::vector<float> values;
    for (int i = 0; i < 5 * 3; ++i) values.push_back(static_cast<float>(i));
    const BlockMeans blocks = MeansOfBlocks({5, 3, values}, 2);
    EXPECT_EQ(blocks.columns, 3u);
    EXPECT_EQ(blocks.rows, 2u);
    EXPECT_EQ(blocks.means, (std::vector<double>{3, 5, 6.5, 10.5, 12.5, 14}));
}

}  // namespace
}  // namespace raygraph::test::image_compare_test

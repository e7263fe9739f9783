// The chi-square test itself, on samples whose distribution is known.
#include "tests/support/chi_square.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace raygraph::test::chi_square_test {
namespace {

TEST(ChiSquare, IncompleteGammaMeetsItsClosedForms) {
    for (double x : {1e-8, 0.001, 0.1, 0.5, 1.0, 1.49, 1.51, 2.0, 5.0, 20.0, 100.0}) {
        // Q(1/2, x) = erfc(sqrt x), Q(1, x) = e^-x.
        EXPECT_NEAR(RegularizedGammaQ(0.5, x), std::erfc(std::sqrt(x)), 1e-13) << x;
        EXPECT_NEAR(RegularizedGammaQ(1.0, x) / std::exp(-x), 1.0, 1e-12) << x;
        // Q(n, x): the chance of fewer than n events where x are expected.
        for (int n : {2, 5, 17, 60}) {
            double term = std::exp(-x);
            double sum = term;
            for (int k = 1; k < n; ++k) sum += term *= x / k;
            EXPECT_NEAR(RegularizedGammaQ(n, x), sum, 2e-13) << n << ' ' << x;
        }
    }
    EXPECT_EQ(RegularizedGammaQ(3.0, 0.0), 1.0);
}

TEST(ChiSquare, IncompleteGammaObeysItsRecurrenceForLargeArguments) {
    // Q(a + 1, x) = Q(a, x) + x^a e^-x / Gamma(a + 1).
    for (double a : {10.5, 400.0, 5000.25, 200000.0}) {
        for (double ratio : {0.97, 0.999, 1.0, 1.001, 1.03}) {
            const double x = a * ratio;
            const double step = std::exp(a * std::log(x) - x - std::lgamma(a + 1.0));
            EXPECT_NEAR(RegularizedGammaQ(a + 1.0, x), RegularizedGammaQ(a, x) + step, 2e-9) << a << ' ' << x;
        }
    }
}

TEST(ChiSquare, PValuesMeetPublishedTables) {
    // Upper critical values (NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.4), to the digits
    // printed.
    struct Row {
        double degrees, value, p;
    };
    for (const Row& row :
         {Row{1, 3.841, 0.05}, Row{1, 6.635, 0.01}, Row{2, 5.991, 0.05}, Row{5, 15.086, 0.01},
          Row{10, 18.307, 0.05}, Row{10, 29.588, 0.001}, Row{50, 76.154, 0.01}, Row{100, 124.342, 0.05},
          Row{100, 135.807, 0.01}, Row{100, 149.449, 0.001}}) {
        EXPECT_NEAR(ChiSquarePValue(row.value, row.degrees), row.p, row.p * 5e-4) << row.degrees;
    }
}

TEST(ChiSquare, SidakLevelKeepsTheFamilysError) {
    EXPECT_DOUBLE_EQ(SidakLevel(0.01, 1), 0.01);
    for (int n : {2, 100, 100000}) EXPECT_NEAR(1.0 - std::pow(1.0 - SidakLevel(0.01, n), n), 0.01, 1e-9);
}

TEST(ChiSquare, FairDieIsAcceptedAndLoadedDieRefused) {
    std::mt19937 generator(7);
    const auto roll = [&](double excess) {
        std::vector<double> counts(6, 0.0);
        for (int i = 0; i < 600'000; ++i) {
            const double u = static_cast<double>(generator()) * 0x1p-32;
            counts[static_cast<size_t>(u < excess ? 0.0 : 6.0 * (u - excess) / (1.0 - excess))] += 1.0;
        }
        return counts;
    };
    const std::vector<double> expected(6, 100'000.0);
    EXPECT_GT(ChiSquareTest(roll(0.0), expected).pValue, 0.01);
    EXPECT_LT(ChiSquareTest(roll(0.005), expected).pValue, 1e-6);
}

TEST(ChiSquare, PValuesOfTrueHypothesesAreUniform) {
    // Were the statistic or its degrees of freedom wrong, these would crowd at one end.
    std::mt19937 generator(11);
    std::array<double, 10> histogram{};
    for (int repeat = 0; repeat < 2000; ++repeat) {
        std::vector<double> counts(16, 0.0);
        for (int i = 0; i < 1600; ++i) counts[generator() >> 28] += 1.0;
        const double p = ChiSquareTest(counts, std::vector<double>(16, 100.0)).pValue;
        histogram[std::min(static_cast<size_t>(p * 10.0), size_t{9})] += 1.0;
    }
    EXPECT_GT(
        ChiSquareTest(histogram, std::array<double, 10>{200, 200, 200, 200, 200, 200, 200, 200, 200, 200})
            .pValue,
        0.001);
}

TEST(ChiSquare, SmallCellsAreMerged) {
    const std::vector<double> expected = {100.0, 1.0, 2.0, 3.0, 100.0, 0.5};
    const std::vector<double> observed = {90.0, 2.0, 1.0, 4.0, 110.0, 0.0};
    // 0.5 + 1 + 2 + 3 make one cell of 6.5, which saw 7.
    const ChiSquareResult result = ChiSquareTest(observed, expected);
    EXPECT_EQ(result.degreesOfFreedom, 2);
    EXPECT_NEAR(result.statistic, 1.0 + 1.0 + 0.25 / 6.5, 1e-12);
}

TEST(ChiSquare, HitWhereNothingIsExpectedIsRefused) {
    const std::vector<double> expected = {100.0, 0.0, 100.0};
    EXPECT_EQ(ChiSquareTest(std::vector<double>{100.0, 1.0, 99.0}, expected).pValue, 0.0);
    EXPECT_EQ(ChiSquareTest(std::vector<double>{100.0, 0.0, 100.0}, expected).pValue, 1.0);
}

TEST(ChiSquare, SphereIntegralsMeetClosedForms) {
    constexpr double kPi = std::numbers::pi;
    EXPECT_NEAR(IntegrateOverSphere([](glm::vec3) { return 1.0; }, -1.0, 1.0, 0.0, 2.0 * kPi), 4.0 * kPi,
                1e-9);
    EXPECT_NEAR(
        IntegrateOverSphere([](glm::vec3 w) { return std::max(0.0f, w.z) / kPi; }, -1.0, 1.0, 0.0, 2.0 * kPi),
        1.0, 1e-6);
    // A lobe of (n + 1) / 2pi cos^n, n = 2000: a few degrees wide.
    const auto peak = [](glm::vec3 w) {
        return w.x > 0.0f ? 2001.0 / (2.0 * kPi) * std::pow(static_cast<double>(w.x), 2000.0) : 0.0;
    };
    EXPECT_NEAR(IntegrateOverSphere(peak, -1.0, 1.0, -kPi, kPi), 1.0, 2e-5);
}

TEST(ChiSquare, WrongDirectionDensityIsRefused) {
    const auto sample = [](float, glm::vec2 u) -> std::optional<glm::vec3> {
        const float r = std::sqrt(1.0f - u.x * u.x);
        const float phi = 2.0f * std::numbers::pi_v<float> * u.y;
        return glm::vec3(r * std::cos(phi), r * std::sin(phi), u.x);
    };
    DirectionTest test;
    test.sampleCount = 100'000;
    const double uniform = 0.5 / std::numbers::pi;
    EXPECT_GT(ChiSquareOfDirections(
                  sample, [&](glm::vec3 w) { return w.z > 0.0f ? uniform : 0.0; }, test)
                  .pValue,
              0.01);
    // A density tilted with the azimuth, and one that leaves a fiftieth for failures that never come.
    const auto tilted = [&](glm::vec3 w) { return w.z > 0.0f ? uniform * (1.0 + 0.15 * w.x) : 0.0; };
    EXPECT_LT(ChiSquareOfDirections(sample, tilted, test).pValue, 1e-6);
    const auto thin = [&](glm::vec3 w) { return w.z > 0.0f ? uniform * 0.98 : 0.0; };
    EXPECT_LT(ChiSquareOfDirections(sample, thin, test).pValue, 1e-6);
}

}  // namespace
}  // namespace raygraph::test::chi_square_test

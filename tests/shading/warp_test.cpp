// Warps, and the test that judges samples.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/warp.glsl"
#include "tests/support/chi_square.h"

namespace raygraph::shading::warp_test {
namespace {

using test::ChiSquareOfDirections;
using test::ChiSquareTest;
using test::DirectionTest;

constexpr int kSampleCount = 1'000'000;
// Six tests below; together they err with chance 0.01.
const double kLevel = test::SidakLevel(0.01, 6);

vec2 NextUniform2D(std::mt19937& generator) {
    const float x = static_cast<float>(generator() >> 8) * 0x1p-24f;
    const float y = static_cast<float>(generator() >> 8) * 0x1p-24f;
    return vec2(x, y);
}

// The corners, edges and center of the unit square, where divisions and roots go wrong.
std::vector<vec2> EdgePoints() {
    const float last = 1.0f - 0x1p-24f;
    std::vector<vec2> points;
    for (float x : {0.0f, 0x1p-24f, 0.25f, 0.5f, 0.5f + 0x1p-24f, last})
        for (float y : {0.0f, 0x1p-24f, 0.25f, 0.5f, 0.5f + 0x1p-24f, last}) points.emplace_back(x, y);
    return points;
}

TEST(Math, CosSinOctantIsExactToRounding) {
    for (int i = -100'000; i <= 100'000; ++i) {
        const float x = kPiOver4 * static_cast<float>(i) / 100'000.0f;
        const vec2 cs = CosSinOctant(x);
        ASSERT_NEAR(static_cast<double>(cs.x), std::cos(static_cast<double>(x)), 1.2e-7) << x;
        ASSERT_NEAR(static_cast<double>(cs.y), std::sin(static_cast<double>(x)), 1.2e-7 * std::abs(x)) << x;
    }
}

TEST(Math, CosSinTurnIsExactOnQuartersAndNearElsewhere) {
    EXPECT_EQ(CosSinTurn(0.0f), vec2(1.0f, 0.0f));
    EXPECT_EQ(CosSinTurn(0.25f), vec2(0.0f, 1.0f));
    EXPECT_EQ(CosSinTurn(0.5f), vec2(-1.0f, 0.0f));
    EXPECT_EQ(CosSinTurn(0.75f), vec2(0.0f, -1.0f));
    EXPECT_EQ(CosSinTurn(1.0f), vec2(1.0f, 0.0f));
    for (int i = 0; i <= 1'000'000; ++i) {
        const float turn = static_cast<float>(i) / 1'000'000.0f;
        const vec2 cs = CosSinTurn(turn);
        ASSERT_NEAR(static_cast<double>(cs.x), std::cos(2.0 * M_PI * turn), 2.5e-7) << turn;
        ASSERT_NEAR(static_cast<double>(cs.y), std::sin(2.0 * M_PI * turn), 2.5e-7) << turn;
    }
}

TEST(Warp, DiskIsUniform) {
    // Cells of equal area in (r^2, phi).
    constexpr int kRings = 20;
    constexpr int kSectors = 40;
    std::vector<double> counts(kRings * kSectors, 0.0);
    std::mt19937 generator(1);
    for (int i = 0; i < kSampleCount; ++i) {
        const vec2 d = SampleUniformDiskConcentric(NextUniform2D(generator));
        const double r2 = static_cast<double>(d.x) * d.x + static_cast<double>(d.y) * d.y;
        const double turn =
            std::atan2(static_cast<double>(d.y), static_cast<double>(d.x)) / (2.0 * M_PI) + 0.5;
        const int ring = std::min(static_cast<int>(r2 * kRings), kRings - 1);
        const int sector = std::min(static_cast<int>(turn * kSectors), kSectors - 1);
        counts[static_cast<size_t>(ring * kSectors + sector)] += 1.0;
    }
    const std::vector<double> expected(counts.size(),
                                       UniformDiskPDF() * M_PI * kSampleCount / (kRings * kSectors));
    EXPECT_GT(ChiSquareTest(counts, expected).pValue, kLevel);
}

TEST(Warp, DiskStaysInsideAtEdges) {
    for (vec2 u : EdgePoints()) {
        const vec2 d = SampleUniformDiskConcentric(u);
        EXPECT_LE(d.x * d.x + d.y * d.y, 1.0f + 1e-6f) << u.x << ' ' << u.y;
    }
    EXPECT_EQ(SampleUniformDiskConcentric(vec2(0.5f, 0.5f)), vec2(0.0f));
}

TEST(Warp, DiskMapKeepsNeighborsTogether) {
    // Continuous over the whole square: stratified points stay stratified.
    for (int i = 0; i < 512; ++i) {
        for (int j = 0; j < 511; ++j) {
            const vec2 u(static_cast<float>(i) / 512.0f, static_cast<float>(j) / 512.0f);
            const vec2 a = SampleUniformDiskConcentric(u);
            const vec2 b = SampleUniformDiskConcentric(vec2(u.x, u.y + 1.0f / 512.0f));
            const vec2 c = SampleUniformDiskConcentric(vec2(u.y, u.x));
            const vec2 d = SampleUniformDiskConcentric(vec2(u.y + 1.0f / 512.0f, u.x));
            ASSERT_LT(length(a - b), 3.2f / 512.0f);
            ASSERT_LT(length(c - d), 3.2f / 512.0f);
        }
    }
}

TEST(Warp, CosineHemisphereFollowsItsPDF) {
    const auto result = ChiSquareOfDirections(
        [](float, vec2 u) { return SampleCosineHemisphere(u); },
        [](vec3 w) { return static_cast<double>(CosineHemispherePDF(w.z)); }, {.seed = 2});
    EXPECT_GT(result.pValue, kLevel);
}

TEST(Warp, UniformHemisphereFollowsItsPDF) {
    const auto result = ChiSquareOfDirections(
        [](float, vec2 u) { return SampleUniformHemisphere(u); },
        [](vec3 w) { return w.z > 0.0f ? static_cast<double>(UniformHemispherePDF()) : 0.0; }, {.seed = 3});
    EXPECT_GT(result.pValue, kLevel);
}

TEST(Warp, UniformSphereFollowsItsPDF) {
    const auto result =
        ChiSquareOfDirections([](float, vec2 u) { return SampleUniformSphere(u); },
                              [](vec3) { return static_cast<double>(UniformSpherePDF()); }, {.seed = 4});
    EXPECT_GT(result.pValue, kLevel);
}

TEST(Warp, DirectionsAreOfUnitLength) {
    std::mt19937 generator(5);
    std::vector<vec2> points = EdgePoints();
    for (int i = 0; i < 100'000; ++i) points.push_back(NextUniform2D(generator));
    for (vec2 u : points) {
        ASSERT_NEAR(length(SampleCosineHemisphere(u)), 1.0f, 1e-6f) << u.x << ' ' << u.y;
        ASSERT_NEAR(length(SampleUniformSphere(u)), 1.0f, 1e-6f) << u.x << ' ' << u.y;
        ASSERT_NEAR(length(SampleUniformHemisphere(u)), 1.0f, 1e-6f) << u.x << ' ' << u.y;
        ASSERT_GE(SampleCosineHemisphere(u).z, 0.0f);
        ASSERT_GE(SampleUniformHemisphere(u).z, 0.0f);
    }
}

TEST(Warp, TriangleIsUniform) {
    // A grid over (b0, b1): whole cells below the diagonal, half cells on it.
    constexpr int kGrid = 32;
    std::vector<double> counts(kGrid * kGrid, 0.0);
    std::vector<double> expected(counts.size(), 0.0);
    std::mt19937 generator(6);
    for (int i = 0; i < kSampleCount; ++i) {
        const vec3 b = SampleUniformTriangle(NextUniform2D(generator));
        const int x = std::min(static_cast<int>(b.x * kGrid), kGrid - 1);
        const int y = std::min(static_cast<int>(b.y * kGrid), kGrid - 1);
        counts[static_cast<size_t>(x * kGrid + y)] += 1.0;
    }
    for (int x = 0; x < kGrid; ++x) {
        for (int y = 0; y < kGrid; ++y) {
            const double share = x + y < kGrid - 1 ? 1.0 : x + y == kGrid - 1 ? 0.5 : 0.0;
            expected[static_cast<size_t>(x * kGrid + y)] =
                share * UniformTrianglePDF() * kSampleCount / (kGrid * kGrid);
        }
    }
    // Rounding may put a point of the hypotenuse one cell over.
    for (int x = 1; x < kGrid; ++x) {
        const auto over = static_cast<size_t>(x * kGrid + kGrid - x);
        ASSERT_LE(counts[over], 2.0);
        counts[over - 1] += counts[over];
        counts[over] = 0.0;
    }
    EXPECT_GT(ChiSquareTest(counts, expected).pValue, kLevel);
}

TEST(Warp, TriangleMapsHalvesOfTheTriangleAlike) {
    // Uniform also within the triangle's own thirds: the mean of each barycentric is 1/3.
    std::mt19937 generator(7);
    double sum[3] = {};
    for (int i = 0; i < kSampleCount; ++i) {
        const vec3 b = SampleUniformTriangle(NextUniform2D(generator));
        ASSERT_GE(min(b.x, min(b.y, b.z)), 0.0f);
        ASSERT_NEAR(b.x + b.y + b.z, 1.0f, 1e-6f);
        sum[0] += b.x;
        sum[1] += b.y;
        sum[2] += b.z;
    }
    // The deviation of one barycentric is sqrt(1/18); five of the mean's.
    for (double s : sum) EXPECT_NEAR(s / kSampleCount, 1.0 / 3.0, 5.0 * std::sqrt(1.0 / 18.0 / kSampleCount));
}

TEST(Warp, PDFsIntegrateToOne) {
    const auto whole = [](const std::function<double(glm::vec3)>& pdf) {
        return test::IntegrateOverSphere(pdf, -1.0, 0.0, 0.0, 2.0 * M_PI) +
               test::IntegrateOverSphere(pdf, 0.0, 1.0, 0.0, 2.0 * M_PI);
    };
    EXPECT_NEAR(whole([](vec3 w) { return static_cast<double>(CosineHemispherePDF(w.z)); }), 1.0, 1e-6);
    EXPECT_NEAR(whole([](vec3 w) { return w.z > 0.0f ? static_cast<double>(UniformHemispherePDF()) : 0.0; }),
                1.0, 1e-6);
    EXPECT_NEAR(whole([](vec3) { return static_cast<double>(UniformSpherePDF()); }), 1.0, 1e-6);
    EXPECT_NEAR(static_cast<double>(UniformDiskPDF()) * M_PI, 1.0, 1e-6);
    EXPECT_NEAR(static_cast<double>(UniformTrianglePDF()) * 0.5, 1.0, 1e-6);
}

}  // namespace
}  // namespace raygraph::shading::warp_test

// The chi-square test itself, on samples whose distribution is known.
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

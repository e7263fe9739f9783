// Colors, and tone mapping.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "core/color.glsl"
#include "core/ramp.glsl"
#include "core/tonemap.glsl"

namespace raygraph::shading::color_test {
namespace {

TEST(Color, SrgbMeetsPublishedPairs) {
    // Code value / 255 against linear light, IEC 61966-2-1.
    EXPECT_EQ(SrgbEncode(0.0f), 0.0f);
    EXPECT_NEAR(SrgbEncode(1.0f), 1.0f, 1e-6f);
    EXPECT_NEAR(SrgbEncode(0.5f), 0.7353570f, 1e-6f);
    EXPECT_NEAR(SrgbEncode(0.18f), 0.4613561f, 1e-6f);
    EXPECT_NEAR(SrgbDecode(0.5f), 0.2140411f, 1e-6f);
    EXPECT_NEAR(SrgbDecode(1.0f / 255.0f), 3.035270e-4f, 1e-9f);
    EXPECT_NEAR(SrgbDecode(186.0f / 255.0f), 0.4910209f, 1e-6f);
}

TEST(Color, IdsAreDistinctColorsOfTwoBrightnesses) {
    std::vector<vec3> colors;
    for (uint id = 0; id < 64; ++id) {
        const vec3 color = IdColor(id);
        EXPECT_FLOAT_EQ(std::max({color.x, color.y, color.z}), id % 2 == 0 ? 0.95f : 0.7f) << id;
        EXPECT_GE(std::min({color.x, color.y, color.z}), 0.17f) << id;
        for (size_t other = 0; other < colors.size(); ++other)
            EXPECT_GT(length(colors[other] - color), other + 1 == id ? 0.2f : 0.004f)
                << other << " and " << id;
        colors.push_back(color);
    }
}

TEST(Color, SrgbIsMonotonicAndInvertible) {
    float previous = -1.0f;
    for (int i = 0; i <= 100'000; ++i) {
        const float x = static_cast<float>(i) / 100'000.0f;
        const float encoded = SrgbEncode(x);
        // The standard's two pieces meet to within 3e-8 in its rounded constants.
        ASSERT_GT(encoded, previous - 1e-7f) << x;
        ASSERT_NEAR(SrgbDecode(encoded), x, 2e-6f) << x;
        previous = encoded;
    }
}

TEST(Color, LuminanceOfWhiteIsOne) {
    EXPECT_NEAR(Luminance(vec3(1.0f)), 1.0f, 1e-6f);
    EXPECT_EQ(Luminance(vec3(0.0f, 1.0f, 0.0f)), 0.7152f);
}

}  // namespace
}  // namespace raygraph::shading::color_test

namespace raygraph::shading::tonemap_test {
namespace {

class TonemapTest : public ::testing::TestWithParam<TonemapOperator> {
  protected:
    uint Operator() const { return static_cast<uint>(GetParam()); }
    float Gray(float x) const { return TonemapLinearLight(vec3(x), Operator()).y; }
};

std::string OperatorName(const ::testing::TestParamInfo<TonemapOperator>& info) {
    return Name(info.param);
}

INSTANTIATE_TEST_SUITE_P(Operators, TonemapTest, ::testing::ValuesIn(Values<TonemapOperator>()),
                         OperatorName);

TEST_P(TonemapTest, BlackStaysBlack) {
    // AgX's published curve starts within 3e-8 of 0.
    EXPECT_LT(Gray(0.0f), 1e-12f);
    const vec3 c = Tonemap(vec3(0.0f), 0.0f, Operator());
    EXPECT_LT(max(c.x, max(c.y, c.z)), 1e-9f);
}

TEST_P(TonemapTest, BrightEndsNearWhite) {
    EXPECT_GT(Gray(1e5f), 0.99f);
}

TEST_P(TonemapTest, GraysAreMonotonicAndInUnitRange) {
    float previous = -1.0f;
    for (int i = 0; i <= 100'000; ++i) {
        const float x = std::exp2(-20.0f + 40.0f * static_cast<float>(i) / 100'000.0f);
        const float y = Gray(x);
        ASSERT_GE(y, previous - 2e-7f) << x;
        ASSERT_GE(y, 0.0f) << x;
        ASSERT_LE(y, 1.0f) << x;
        previous = y;
    }
}

TEST_P(TonemapTest, GraysStayGray) {
    for (float x : {0.01f, 0.18f, 1.0f, 10.0f}) {
        const vec3 c = TonemapLinearLight(vec3(x), Operator());
        // The rows of the published matrices of ACES and AgX add up to 1 within 5e-4.
        EXPECT_NEAR(c.x, c.y, 5e-4f) << x;
        EXPECT_NEAR(c.z, c.y, 5e-4f) << x;
    }
}

TEST_P(TonemapTest, EveryColorMapsIntoUnitRange) {
    std::mt19937 generator(1);
    std::uniform_real_distribution<float> stops(-15.0f, 15.0f);
    const auto expectInRange = [&](vec3 c) {
        const vec3 mapped = Tonemap(c, 1.0f, Operator());
        for (int i = 0; i < 3; ++i) {
            ASSERT_GE(mapped[i], 0.0f) << c.x << ' ' << c.y << ' ' << c.z;
            ASSERT_LE(mapped[i], 1.0f + 1e-6f) << c.x << ' ' << c.y << ' ' << c.z;
        }
    };
    for (int i = 0; i < 100'000; ++i) {
        vec3 c(std::exp2(stops(generator)), std::exp2(stops(generator)), std::exp2(stops(generator)));
        // Pure primaries and colors outside the gamut too.
        if (i % 3 == 0) c[i % 9 / 3] = 0.0f;
        if (i % 5 == 0) c[i % 15 / 5] *= -0.1f;
        expectInRange(c);
    }
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    expectInRange(vec3(infinity, 1.0f, infinity));
    expectInRange(vec3(nan, 0.5f, -infinity));
    expectInRange(vec3(std::numeric_limits<float>::max()));
    expectInRange(vec3(std::numeric_limits<float>::denorm_min()));
}

TEST_P(TonemapTest, ExposureIsInStops) {
    const vec3 c(0.1f, 0.07f, 0.02f);
    EXPECT_EQ(Tonemap(c, 2.0f, Operator()), Tonemap(4.0f * c, 0.0f, Operator()));
    EXPECT_EQ(Tonemap(c, -1.0f, Operator()), Tonemap(0.5f * c, 0.0f, Operator()));
}

TEST(Tonemap, LinearIsNotEncodedAndSrgbIs) {
    EXPECT_EQ(Tonemap(vec3(0.5f, 0.25f, 2.0f), 0.0f, kTonemapLinear), vec3(0.5f, 0.25f, 1.0f));
    EXPECT_NEAR(Tonemap(vec3(0.5f), 0.0f, kTonemapSrgb).x, 0.7353570f, 1e-6f);
}

TEST(Tonemap, ReinhardHalvesOne) {
    EXPECT_EQ(TonemapReinhard(vec3(1.0f, 3.0f, 0.0f)), vec3(0.5f, 0.75f, 0.0f));
}

TEST(Tonemap, AcesPutsMiddleGrayNearTenNitsOfAHundred) {
    // ACES renders 18 % gray at 10 cd/m2 of 100; the fit comes within 6 %.
    EXPECT_NEAR(TonemapLinearLight(vec3(0.18f), kTonemapAces).y, 0.10f, 0.006f);
    // A scalar evaluation of the published rational function.
    const double v = 0.5;
    EXPECT_NEAR(AcesFitCurve(vec3(0.5f)).x,
                (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081), 1e-6);
}

TEST(Tonemap, AgXPutsMiddleGrayAtHalfTheDisplaysCode) {
    EXPECT_NEAR(AgXChannel(0.18f), 0.5f, 1e-5f);
    EXPECT_NEAR(TonemapLinearLight(vec3(0.18f), kTonemapAgX).y, std::pow(0.5f, 2.2f), 2e-4f);
    // The ends of its 16.5 stops.
    EXPECT_NEAR(AgXChannel(0.18f * std::exp2(-10.0f)), 0.0f, 1e-5f);
    EXPECT_NEAR(AgXChannel(0.18f * std::exp2(6.5f)), 1.0f, 1e-5f);
}

TEST(Tonemap, AgXSigmoidMatchesThePublishedPolynomial) {
    // The degree 6 polynomial in wide use (B. Wrensch, "Minimal AgX Implementation") was fitted to a table of
    // the curve with a mean squared error of 3.7e-6.
    double squares = 0.0;
    for (int i = 0; i <= 1000; ++i) {
        const double x = i / 1000.0;
        const double polynomial =
            ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232);
        const double difference = static_cast<double>(AgXSigmoid(static_cast<float>(x))) - polynomial;
        EXPECT_LT(std::abs(difference), 0.01) << x;
        squares += difference * difference / 1001.0;
    }
    EXPECT_LT(squares, 1e-5);
}

TEST(Tonemap, AgXSigmoidHasSlopeTwoAtItsPivot) {
    const double pivot = 10.0 / 16.5;
    for (double h : {0.01, -0.01}) {
        const auto at = [](double x) { return static_cast<double>(AgXSigmoid(static_cast<float>(x))); };
        EXPECT_NEAR((at(pivot + h) - at(pivot)) / h, 2.0, 1e-3);
    }
}

TEST(Tonemap, AgXOutsetUndoesItsInset) {
    // A flat color far from the curve's ends: equal channels after the inset stay equal after the outset,
    // and the sum of each row is 1 within the rounding of the published digits.
    for (float x : {0.05f, 0.18f, 0.5f}) {
        const vec3 c = TonemapAgX(vec3(x));
        const float expected = std::pow(AgXChannel(x), 2.2f);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(c[i], expected, 5e-4f);
    }
}

TEST(Tonemap, NeutralKeepsColorsBelowItsCompressionButForFourPercent) {
    for (vec3 c : {vec3(0.1f, 0.2f, 0.3f), vec3(0.08f, 0.5f, 0.79f), vec3(0.7f, 0.7f, 0.7f)}) {
        const vec3 mapped = TonemapNeutral(c);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(mapped[i], c[i] - 0.04f, 1e-6f);
    }
    // Below 8 % the offset fades as x - 6.25 x^2, so that black stays black.
    EXPECT_NEAR(TonemapNeutral(vec3(0.04f)).x, 6.25f * 0.04f * 0.04f, 1e-7f);
}

TEST(Tonemap, NeutralMeetsItsSpecificationAboveTheCompression) {
    // Gray 1 + 0.04: peak 1, compressed to 1 - 0.24^2 / (1 + 0.24 - 0.76).
    EXPECT_NEAR(TonemapNeutral(vec3(1.04f)).x, 0.88f, 1e-6f);
    // A saturated color: scaled to the new peak, then mixed towards it by 1 - 1 / (0.15 (peak - newPeak) +
    // 1).
    const double peak = 4.0;
    const double newPeak = 1.0 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
    const double white = 1.0 - 1.0 / (0.15 * (peak - newPeak) + 1.0);
    const vec3 mapped = TonemapNeutral(vec3(4.0f, 0.0f, 0.0f));
    EXPECT_NEAR(mapped.x, newPeak, 1e-6);
    EXPECT_NEAR(mapped.y, newPeak * white, 1e-6);
    EXPECT_NEAR(mapped.z, newPeak * white, 1e-6);
}

TEST(Tonemap, NeutralIsSmoothWhereCompressionStarts) {
    const auto at = [](double x) {
        return static_cast<double>(TonemapNeutral(vec3(static_cast<float>(x), 0.1f, 0.1f)).x);
    };
    const double start = 0.8;  // 0.76 after the offset of 0.04
    EXPECT_NEAR(at(start + 1e-5), at(start - 1e-5), 1e-4);
    EXPECT_NEAR((at(start + 0.01) - at(start)) / 0.01, 1.0, 0.05);
    EXPECT_NEAR((at(start) - at(start - 0.01)) / 0.01, 1.0, 0.05);
}

}  // namespace
}  // namespace raygraph::shading::tonemap_test

// Tests the contract of every sampler: uniform numbers in [0, 1) that depend only on (seed, pixel, sample,
// dimension) and look independent along each of the four.
#include "core/rng.glsl"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tests/support/chi_square.h"

namespace raygraph::shading::rng_test {
namespace {

class SamplerTest : public ::testing::TestWithParam<SamplerKind> {
  protected:
    void SetUp() override { threadSamplerKind = GetParam(); }
    void TearDown() override { threadSamplerKind = SamplerKind::Sobol; }
};

std::string KindName(const ::testing::TestParamInfo<SamplerKind>& info) {
    return Name(info.param);
}

INSTANTIATE_TEST_SUITE_P(Kinds, SamplerTest, ::testing::ValuesIn(Values<SamplerKind>()), KindName);

vec2 Draw2D(uvec2 pixel, uint sampleIndex, uint seed, uint dimension) {
    Sampler rng = StartPixelSample(pixel, sampleIndex, seed);
    rng.dimension = dimension;
    return Get2D(rng);
}

float Draw1D(uvec2 pixel, uint sampleIndex, uint seed, uint dimension) {
    Sampler rng = StartPixelSample(pixel, sampleIndex, seed);
    rng.dimension = dimension;
    return Get1D(rng);
}

// The p-value of independent uniform pairs on a grid of 32 x 32 cells.
double PairPValue(int count, const std::function<vec2(uint)>& pair) {
    constexpr int kGrid = 32;
    std::vector<double> counts(kGrid * kGrid, 0.0);
    for (int i = 0; i < count; ++i) {
        const vec2 u = pair(static_cast<uint>(i));
        counts[static_cast<size_t>(u.x * kGrid) * kGrid + static_cast<size_t>(u.y * kGrid)] += 1.0;
    }
    const std::vector<double> expected(counts.size(), count / static_cast<double>(counts.size()));
    return test::ChiSquareTest(counts, expected).pValue;
}

// A 512 x 512 image walked in scan order.
uvec2 PixelOf(uint i) {
    return uvec2(i % 512u, i / 512u);
}
constexpr int kPixelCount = 512 * 512;

// Each of the tests below makes at most this many comparisons, and each family errs with chance 0.01.
const double kLevel = test::SidakLevel(0.01, 40);

TEST_P(SamplerTest, ValuesAreInUnitIntervalBelowOne) {
    float largest = 0.0f;
    for (uint i = 0; i < 200'000; ++i) {
        const vec2 u = Draw2D(PixelOf(i), i * 7919u, 3u, i % 13u);
        ASSERT_GE(min(u.x, u.y), 0.0f);
        ASSERT_LT(max(u.x, u.y), 1.0f);
        const float v = Draw1D(PixelOf(i), i * 7919u, 3u, i % 13u);
        ASSERT_GE(v, 0.0f);
        ASSERT_LT(v, 1.0f);
        largest = max(largest, max(v, max(u.x, u.y)));
    }
    EXPECT_GT(largest, 1.0f - 1e-4f);
}

TEST_P(SamplerTest, NumbersDependOnTheirFourArgumentsAlone) {
    for (uint i = 0; i < 1000; ++i) {
        const uvec2 pixel(i * 31u % 65536u, i * 17u % 65536u);
        // The draw is repeated after others, in another order.
        Sampler rng = StartPixelSample(pixel, i, 9u);
        const vec2 first = Get2D(rng);
        const float second = Get1D(rng);
        const vec2 third = Get2D(rng);
        ASSERT_EQ(rng.dimension, 5u);
        ASSERT_EQ(third, Draw2D(pixel, i, 9u, 3u));
        ASSERT_EQ(second, Draw1D(pixel, i, 9u, 2u));
        ASSERT_EQ(first, Draw2D(pixel, i, 9u, 0u));
    }
}

TEST_P(SamplerTest, EachArgumentChangesTheNumbers) {
    const vec2 base = Draw2D(uvec2(10u, 20u), 5u, 1u, 4u);
    EXPECT_NE(base, Draw2D(uvec2(11u, 20u), 5u, 1u, 4u));
    EXPECT_NE(base, Draw2D(uvec2(10u, 21u), 5u, 1u, 4u));
    EXPECT_NE(base, Draw2D(uvec2(20u, 10u), 5u, 1u, 4u));
    EXPECT_NE(base, Draw2D(uvec2(10u, 20u), 6u, 1u, 4u));
    EXPECT_NE(base, Draw2D(uvec2(10u, 20u), 5u, 2u, 4u));
    EXPECT_NE(base, Draw2D(uvec2(10u, 20u), 5u, 1u, 5u));
}

TEST_P(SamplerTest, PixelsAreUniformAtEverySampleAndDimension) {
    for (uint sample : {0u, 1u, 2u, 1023u, 0xffffffffu}) {
        for (uint dimension : {0u, 1u, 2u, 64u}) {
            EXPECT_GT(
                PairPValue(kPixelCount, [&](uint i) { return Draw2D(PixelOf(i), sample, 1u, dimension); }),
                kLevel)
                << sample << ' ' << dimension;
        }
    }
}

TEST_P(SamplerTest, NeighboringPixelsAreIndependent) {
    for (uvec2 step : {uvec2(1u, 0u), uvec2(0u, 1u), uvec2(1u, 1u), uvec2(0u, 256u)}) {
        for (uint dimension : {0u, 2u, 7u}) {
            EXPECT_GT(PairPValue(kPixelCount,
                                 [&](uint i) {
                                     return vec2(Draw2D(PixelOf(i), 0u, 1u, dimension).x,
                                                 Draw2D(PixelOf(i) + step, 0u, 1u, dimension).x);
                                 }),
                      kLevel)
                << step.x << ' ' << step.y << ' ' << dimension;
        }
    }
}

TEST_P(SamplerTest, DimensionsAreIndependent) {
    // Both over pixels at one sample and over the samples of a few pixels, where padded sequences could
    // conspire.
    struct Pair {
        uint a, b;
    };
    const Pair pairs[] = {{0u, 2u}, {0u, 1u}, {2u, 4u}, {1u, 9u}, {0u, 32u}, {5u, 1029u}};
    for (const Pair& pair : pairs) {
        const uint a = pair.a;
        const uint b = pair.b;
        const auto overPixels = [&](uint i) {
            return vec2(Draw2D(PixelOf(i), 3u, 1u, a).x, Draw2D(PixelOf(i), 3u, 1u, b).x);
        };
        EXPECT_GT(PairPValue(kPixelCount, overPixels), kLevel) << a << ' ' << b;
        const auto crossed = [&](uint i) {
            return vec2(Draw2D(PixelOf(i), 3u, 1u, a).y, Draw2D(PixelOf(i), 3u, 1u, b).x);
        };
        EXPECT_GT(PairPValue(kPixelCount, crossed), kLevel) << a << ' ' << b;
        // Four samples of each pixel: few enough that stratification within one dimension does not show.
        const auto overSamples = [&](uint i) {
            return vec2(Draw2D(PixelOf(i / 4u), i % 4u, 1u, a).x, Draw2D(PixelOf(i / 4u), i % 4u, 1u, b).x);
        };
        EXPECT_GT(PairPValue(kPixelCount, overSamples), kLevel) << a << ' ' << b;
        const auto oneAndTwo = [&](uint i) {
            return vec2(Draw1D(PixelOf(i), 1u, 1u, a), Draw2D(PixelOf(i), 1u, 1u, b).y);
        };
        EXPECT_GT(PairPValue(kPixelCount, oneAndTwo), kLevel) << a << ' ' << b;
    }
}

TEST_P(SamplerTest, SeedsAreIndependent) {
    for (uint other : {1u, 2u, 0x80000000u, 0xffffffffu}) {
        EXPECT_GT(PairPValue(kPixelCount,
                             [&](uint i) {
                                 return vec2(Draw2D(PixelOf(i), 0u, 0u, 0u).x,
                                             Draw2D(PixelOf(i), 0u, other, 0u).x);
                             }),
                  kLevel)
            << other;
    }
}

TEST_P(SamplerTest, LowBitsAreUniformToo) {
    // The last 5 of the 24 bits of both coordinates.
    const auto low = [](float u) { return fract(u * 0x1p19f); };
    for (uint dimension : {0u, 3u}) {
        EXPECT_GT(PairPValue(kPixelCount,
                             [&](uint i) {
                                 const vec2 u = Draw2D(PixelOf(i), 6u, 1u, dimension);
                                 return vec2(low(u.x), low(u.y));
                             }),
                  kLevel);
    }
}

TEST_P(SamplerTest, CorrelationsVanish) {
    // Pearson's r between dimensions over 2^14 samples of single pixels: below 5 / sqrt(n) for independent
    // numbers.
    constexpr uint kCount = 1u << 14u;
    const double bound = 5.0 / std::sqrt(static_cast<double>(kCount));
    for (uint pixel = 0; pixel < 8; ++pixel) {
        std::vector<std::vector<double>> columns;
        for (uint dimension = 0; dimension < 6; ++dimension) {
            std::vector<double> column;
            for (uint i = 0; i < kCount; ++i)
                column.push_back((Draw1D(uvec2(pixel, 3u), i, 1u, dimension) - 0.5) * std::sqrt(12.0));
            columns.push_back(column);
        }
        for (size_t a = 0; a < columns.size(); ++a) {
            for (size_t b = a + 1; b < columns.size(); ++b) {
                double sum = 0.0;
                for (size_t i = 0; i < kCount; ++i) sum += columns[a][i] * columns[b][i];
                EXPECT_LT(std::abs(sum / kCount), bound) << pixel << ' ' << a << ' ' << b;
            }
        }
    }
}

// Each of several surfaces behind one another blocks its fraction of the rays that the earlier ones transmit.
TEST_P(SamplerTest, PartlyTransparentSurfacesStopRaysIndependently) {
    const auto draw = [](uvec2 pixel, uint sampleIndex, uint ray, uint surface) {
        return AlphaTestSample(AlphaSeed(StartPixelSample(pixel, sampleIndex, 1u), ray), surface);
    };
    struct Place {
        uint ray, surface;
    };
    // The triangles of one instance, its neighbor's, and the next rays'
    const Place places[] = {{1u, 0u}, {1u, 1u}, {1u, 0x9e3779b9u}, {1u, 0x9e3779bau}, {2u, 0u}, {3u, 1u}};
    for (const Place& a : places)
        for (const Place& b : places) {
            if (&a >= &b) continue;
            const auto overPixels = [&](uint i) {
                return vec2(draw(PixelOf(i), 3u, a.ray, a.surface), draw(PixelOf(i), 3u, b.ray, b.surface));
            };
            EXPECT_GT(PairPValue(kPixelCount, overPixels), kLevel) << a.surface << ' ' << b.surface;
            const auto overSamples = [&](uint i) {
                const uvec2 pixel = PixelOf(i / 4u);
                return vec2(draw(pixel, i % 4u, a.ray, a.surface), draw(pixel, i % 4u, b.ray, b.surface));
            };
            EXPECT_GT(PairPValue(kPixelCount, overSamples), kLevel) << a.surface << ' ' << b.surface;
            // In each pixel the fraction that two surfaces of 0.5 transmit tends to a quarter
            for (uint pixel = 0; pixel < 8; ++pixel) {
                constexpr uint kCount = 1u << 12u;
                uint through = 0;
                for (uint i = 0; i < kCount; ++i)
                    through += draw(uvec2(pixel, 9u), i, a.ray, a.surface) >= 0.5f &&
                               draw(uvec2(pixel, 9u), i, b.ray, b.surface) >= 0.5f;
                EXPECT_NEAR(through, kCount / 4.0, 5.0 * std::sqrt(kCount * 3.0 / 16.0)) << pixel;
            }
        }
}

class IndependentSamplerTest : public SamplerTest {};

INSTANTIATE_TEST_SUITE_P(Kinds, IndependentSamplerTest, ::testing::Values(SamplerKind::Pcg, SamplerKind::Tea),
                         KindName);

TEST_P(IndependentSamplerTest, SamplesOfOnePixelAreUniformAndSeriallyIndependent) {
    for (uint dimension : {0u, 5u}) {
        const uvec2 pixel(7u, 8u);
        EXPECT_GT(PairPValue(kPixelCount, [&](uint i) { return Draw2D(pixel, i, 1u, dimension); }), kLevel);
        for (uint lag : {1u, 2u, 256u}) {
            const auto pair = [&](uint i) {
                return vec2(Draw1D(pixel, i, 1u, dimension), Draw1D(pixel, i + lag, 1u, dimension));
            };
            EXPECT_GT(PairPValue(kPixelCount, pair), kLevel) << dimension << ' ' << lag;
        }
    }
}

TEST(Rng, Pcg4dMeetsItsDefinition) {
    // The values come from a second implementation, in integers of arbitrary size.
    EXPECT_EQ(Pcg4d(uvec4(1u, 2u, 3u, 4u)), uvec4(0x3622cd16u, 0xf11471d8u, 0xe1109b3fu, 0x02b94c2fu));
    EXPECT_EQ(Pcg4d(uvec4(0xffffffffu, 7u, 0x80000000u, 12345u)),
              uvec4(0xef915379u, 0xd05f9fcbu, 0x52c5ef09u, 0xeadb4cc0u));
}

TEST(Rng, TeaMeetsItsDefinition) {
    // The values come from a second implementation, checked against the published vector of 32 rounds; used
    // are 8 rounds and the top 24 bits.
    Sampler rng;
    rng.pixelSeed = 0xdeadbeefu;
    rng.index = 77u;
    rng.dimension = 5u;
    EXPECT_EQ(TeaDraw(rng), vec2(3014675.0f * 0x1p-24f, 5038225.0f * 0x1p-24f));
}

TEST(Rng, MixingIsOneToOne) {
    // Inverted: odd factors have inverses modulo 2^32, a xorshift undoes itself.
    const auto inverse = [](uint x) {
        x ^= (x >> 15u) ^ (x >> 30u);
        x *= 0x97132227u;
        x ^= (x >> 15u) ^ (x >> 30u);
        x *= 0x333c4925u;
        x ^= x >> 16u;
        return x;
    };
    ASSERT_EQ(0x735a2d97u * 0x97132227u, 1u);
    ASSERT_EQ(0x21f0aaadu * 0x333c4925u, 1u);
    for (uint i = 0; i < 1'000'000; ++i) ASSERT_EQ(inverse(MixBits(i * 4093u)), i * 4093u);
}

TEST(Rng, PixelsOfOneSeedHaveDistinctStates) {
    std::set<uint> states;
    for (uint y = 0; y < 300; ++y)
        for (uint x = 0; x < 300; ++x) states.insert(StartPixelSample(uvec2(x, y), 0u, 42u).pixelSeed);
    EXPECT_EQ(states.size(), 300u * 300u);
}

TEST(Rng, LargestBitsStayBelowOne) {
    EXPECT_LT(BitsToUnit(0xffffffffu), 1.0f);
    EXPECT_EQ(BitsToUnit(0u), 0.0f);
    EXPECT_EQ(BitsToUnit(0x80000000u), 0.5f);
}

}  // namespace
}  // namespace raygraph::shading::rng_test

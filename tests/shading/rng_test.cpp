// Random numbers: generators, Sobol's sequence, and the time of a sample.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/rng.glsl"
#include "editor/session/frames/sample_frames.h"
#include "tests/support/chi_square.h"

// Tests the contract of every sampler: uniform numbers in [0, 1) that depend only on (seed, pixel, sample,
// dimension) and look independent along each of the four.
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
    for (uint pixel = 0; pixel < 4; ++pixel) {
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
            for (uint pixel = 0; pixel < 4; ++pixel) {
                constexpr uint kCount = 1u << 10u;
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

// Tests what the default sampler promises beyond uniformity: stratification and faster convergence.
namespace raygraph::shading::sobol_test {
namespace {

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

TEST(Sobol, SecondDimensionFollowsItsDirectionNumbers) {
    // The definition: v_0 = 2^31, v_k = v_(k-1) xor v_(k-1) / 2; the point of index i is the xor of v_k over
    // its bits.
    const auto byDefinition = [](uint index) {
        uint v = 0x80000000u;
        uint point = 0u;
        for (; index != 0u; index >>= 1u, v ^= v >> 1u)
            if ((index & 1u) != 0u) point ^= v;
        return point;
    };
    for (uint bit = 0; bit < 32; ++bit) {
        const uint i = 1u << bit;
        ASSERT_EQ(bitfieldReverse(SobolSecondReversed(i)), byDefinition(i)) << i;
    }
    for (uint n = 0; n < 100'000; ++n) {
        const uint i = n * 2654435761u;
        ASSERT_EQ(bitfieldReverse(SobolSecondReversed(i)), byDefinition(i)) << i;
    }
}

TEST(Sobol, ScramblingIsNested) {
    // Bit k of the result depends on bits 0..k alone, and flips with bit k: then each level of the tree of
    // intervals is permuted within its parent, which is what keeps elementary intervals.
    for (uint n = 0; n < 2000; ++n) {
        const uint x = MixBits(n);
        const uint seed = MixBits(n + 77u);
        const uint y = OwenScrambleReversed(x, seed);
        for (uint k = 0; k < 32; ++k) {
            const uint difference = y ^ OwenScrambleReversed(x ^ (1u << k), seed);
            ASSERT_EQ(difference & ((1u << k) - 1u), 0u) << n << ' ' << k;
            ASSERT_EQ((difference >> k) & 1u, 1u) << n << ' ' << k;
        }
    }
}

TEST(Sobol, ScramblingFlipsEveryBitHalfTheTime) {
    // Over seeds, bit k of the result is a fair coin, and so is whether a change of the bit below it changes
    // it.
    constexpr uint kSeeds = 1u << 16u;
    const double bound = 5.0 * std::sqrt(0.25 / kSeeds);
    for (uint k = 0; k < 32; ++k) {
        uint ones = 0;
        uint carried = 0;
        for (uint n = 0; n < kSeeds; ++n) {
            const uint seed = MixBits(n * 31u + k);
            const uint x = MixBits(n ^ 0x5bd1e995u);
            const uint y = OwenScrambleReversed(x, seed);
            ones += (y >> k) & 1u;
            if (k > 0u) carried += ((y ^ OwenScrambleReversed(x ^ (1u << (k - 1u)), seed)) >> k) & 1u;
        }
        EXPECT_NEAR(ones / static_cast<double>(kSeeds), 0.5, bound) << k;
        if (k > 0u) {
            EXPECT_NEAR(carried / static_cast<double>(kSeeds), 0.5, 0.1) << k;
        }
    }
}

// Every elementary interval [a / 2^p, (a+1) / 2^p) x [b / 2^q, (b+1) / 2^q) with p + q = k holds exactly one
// of the 2^k points.
void ExpectNet(const std::vector<vec2>& points, int k) {
    for (int p = 0; p <= k; ++p) {
        std::vector<int> hits(points.size(), 0);
        for (vec2 u : points) {
            const auto a = static_cast<size_t>(std::ldexp(u.x, p));
            const auto b = static_cast<size_t>(std::ldexp(u.y, k - p));
            ++hits[(a << (k - p)) + b];
        }
        for (int hit : hits) ASSERT_EQ(hit, 1) << "k = " << k << ", p = " << p;
    }
}

TEST(Sobol, AlignedPowersOfTwoAreNetsAfterScrambling) {
    for (uint seed = 0; seed < 6; ++seed) {
        const uvec2 pixel(seed * 101u, 65535u - seed);
        const uint dimension = seed * 3u;
        for (int k = 0; k <= 12; ++k) {
            // The first block, a later one, and the very last of all indices.
            const uint count = 1u << k;
            for (uint first : {0u, 5u * count, 0u - count}) {
                std::vector<vec2> points;
                for (uint i = 0; i < count; ++i) points.push_back(Draw2D(pixel, first + i, seed, dimension));
                ExpectNet(points, k);
                if (HasFatalFailure()) return;
            }
        }
    }
}

TEST(Sobol, ThreeDimensionsTogetherAreNets) {
    // Every elementary box of volume 2 / 2^k holds exactly two of the 2^k points
    for (uint seed = 0; seed < 4; ++seed) {
        for (int k = 1; k <= 11; ++k) {
            const uint count = 1u << k;
            for (uint first : {0u, 5u * count, 0u - count}) {
                std::vector<vec3> points;
                for (uint i = 0; i < count; ++i) {
                    Sampler rng = StartPixelSample(uvec2(seed * 7u, 3u), first + i, seed);
                    rng.dimension = seed * 5u;
                    points.push_back(Get3D(rng));
                    ASSERT_EQ(rng.dimension, seed * 5u + 3u);
                }
                for (int p = 0; p < k; ++p) {
                    for (int q = 0; p + q < k; ++q) {
                        const int r = k - 1 - p - q;
                        std::vector<int> hits(count / 2, 0);
                        for (vec3 u : points) {
                            const auto a = static_cast<size_t>(std::ldexp(u.x, p));
                            const auto b = static_cast<size_t>(std::ldexp(u.y, q));
                            const auto c = static_cast<size_t>(std::ldexp(u.z, r));
                            ++hits[(((a << q) + b) << r) + c];
                        }
                        for (int hit : hits) ASSERT_EQ(hit, 2) << "k = " << k << ", " << p << ", " << q;
                    }
                }
            }
        }
    }
}

// The digits of a polynomial over the field of two elements in the base of another, lowest first.
uint DigitsInBase(uint number, uint base, int degree) {
    uint digits = 0u;
    for (int at = 0; number != 0u; at += degree) {
        uint quotient = 0u;
        for (int bit = 31; bit >= degree; --bit) {
            if ((number >> bit & 1u) == 0u) continue;
            quotient |= 1u << (bit - degree);
            number ^= base << (bit - degree);
        }
        digits |= number << at;
        number = quotient;
    }
    return digits;
}

TEST(Sobol, ThirdDimensionsAreDigitsInTheirBases) {
    for (uint n = 0; n < 100'000; ++n) {
        const uint i = n * 2654435761u;
        ASSERT_EQ(SobolThirdReversed(i), DigitsInBase(i, 0b111u, 2)) << i;
        ASSERT_EQ(SobolThirdOfPairReversed(i), DigitsInBase(i, 0b1011u, 3)) << i;
    }
}

TEST(Sobol, PairsOfDrawsAreNetsTogether) {
    constexpr uint kFirst = 7u;
    for (uint seed = 0; seed < 4; ++seed) {
        const auto draw = [seed](uint i, uint dimension) {
            Sampler rng = StartPixelSample(uvec2(seed * 7u, 3u), i, seed);
            rng.dimension = dimension;
            const vec3 u = Get3DOfPair(rng, kFirst);
            EXPECT_EQ(rng.dimension, dimension + 3u);
            return u;
        };
        for (int k = 0; k <= 5; ++k) {
            const uint count = 1u << (2 * k);
            for (uint start : {0u, 5u * count, 0u - count}) {
                std::vector<vec4> points;
                std::vector<vec2> firsts, seconds;
                for (uint i = 0; i < count; ++i) {
                    const vec3 u = draw(start + i, kFirst);
                    const vec3 v = draw(start + i, kFirst + 10u);
                    points.emplace_back(u.x, u.y, v.x, v.y);
                    firsts.emplace_back(u.x, u.y);
                    seconds.emplace_back(v.x, v.y);
                }
                ExpectNet(firsts, 2 * k);
                ExpectNet(seconds, 2 * k);
                // Every box of 4^-a x 4^-b x 4^-c x 4^-d with a + b + c + d = k holds exactly one
                for (int a = 0; a <= k; ++a) {
                    for (int b = 0; a + b <= k; ++b) {
                        for (int c = 0; a + b + c <= k; ++c) {
                            const int powers[] = {a, b, c, k - a - b - c};
                            std::set<uint> boxes;
                            for (const vec4& point : points) {
                                uint box = 0u;
                                for (int axis = 0; axis < 4; ++axis)
                                    box = (box << (2 * powers[axis])) +
                                          static_cast<uint>(std::ldexp(point[axis], 2 * powers[axis]));
                                boxes.insert(box);
                            }
                            ASSERT_EQ(boxes.size(), count) << k << ": " << a << ' ' << b << ' ' << c;
                        }
                    }
                }
            }
        }
    }
}

TEST(Sobol, NumbersOfAPairAreStratifiedWithTheThird) {
    // Every box of volume 4 / 2^k holds exactly four of the 2^k points, of either draw
    for (uint dimension : {4u, 11u}) {
        for (int k = 2; k <= 11; ++k) {
            const uint count = 1u << k;
            for (int p = 0; p <= k - 2; ++p) {
                for (int q = 0; p + q <= k - 2; ++q) {
                    const int r = k - 2 - p - q;
                    std::vector<int> hits(count / 4, 0);
                    for (uint i = 0; i < count; ++i) {
                        Sampler rng = StartPixelSample(uvec2(5u, 3u), i, 2u);
                        rng.dimension = dimension;
                        const vec3 u = Get3DOfPair(rng, 4u);
                        const auto a = static_cast<size_t>(std::ldexp(u.x, p));
                        const auto b = static_cast<size_t>(std::ldexp(u.y, q));
                        ++hits[(((a << q) + b) << r) + static_cast<size_t>(std::ldexp(u.z, r))];
                    }
                    for (int hit : hits) ASSERT_EQ(hit, 4) << "k = " << k << ", " << p << ", " << q;
                }
            }
        }
    }
}

TEST(Sobol, OneDimensionalDrawsAreStratified) {
    for (uint dimension = 0; dimension < 20; ++dimension) {
        for (int k = 0; k <= 12; ++k) {
            std::set<int> strata;
            for (uint i = 0; i < (1u << k); ++i) {
                const float u = Draw1D(uvec2(5u, dimension), i, 8u, dimension);
                strata.insert(static_cast<int>(std::ldexp(u, k)));
            }
            ASSERT_EQ(strata.size(), size_t{1} << k) << dimension;
        }
    }
}

TEST(Sobol, EachSurfaceStopsItsShareOfEveryBlockOfSamples) {
    for (uint surface = 0; surface < 20; ++surface)
        for (int k = 0; k <= 10; ++k) {
            std::set<int> strata;
            for (uint i = 3u << k; i < 4u << k; ++i) {
                const Sampler rng = StartPixelSample(uvec2(5u, surface), i, 8u);
                strata.insert(static_cast<int>(std::ldexp(AlphaTestSample(AlphaSeed(rng, 2u), surface), k)));
            }
            ASSERT_EQ(strata.size(), size_t{1} << k) << surface;
        }
}

TEST(Sobol, CoordinatesAreScrambledIndependently) {
    // Counts the points of a net, of 16 with one in each row and column of a 16 x 16 grid, that lie on the
    // diagonal: one in the mean. If both coordinates were scrambled equally, the count would be the number of
    // solutions of a linear system of rank 2: none in three nets of four, four in the fourth.
    constexpr int kNets = 4000;
    double sum = 0.0;
    double squares = 0.0;
    for (uint net = 0; net < kNets; ++net) {
        int count = 0;
        for (uint i = 0; i < 16; ++i) {
            const vec2 u = Draw2D(uvec2(net, 2u), i, 1u, 0u);
            if (static_cast<int>(u.x * 16.0f) == static_cast<int>(u.y * 16.0f)) ++count;
        }
        sum += count;
        squares += count * count;
    }
    const double mean = sum / kNets;
    const double variance = squares / kNets - mean * mean;
    EXPECT_NEAR(mean, 1.0, 0.1);
    EXPECT_LT(variance, 1.5);
    RecordProperty("variance", std::to_string(variance));
}

TEST(Sobol, PaddedDrawsPairAtRandom) {
    // The points (draw a, draw b) of one pixel's 1024 samples on a 4 x 4 grid. Under ideal nested shuffles
    // the samples fall into 256 groups of four, each a random permutation of the rows against the columns: a
    // cell's count is a sum of 256 coins of chance 1/4.
    constexpr int kGrid = 4;
    constexpr uint kSamples = 1024;
    constexpr int kPixels = 400;
    for (uint other : {1u, 2u, 4u, 17u}) {
        double variance = 0.0;
        for (uint pixel = 0; pixel < kPixels; ++pixel) {
            std::vector<double> counts(kGrid * kGrid, 0.0);
            for (uint i = 0; i < kSamples; ++i) {
                const float a = Draw2D(uvec2(pixel, 0u), i, 1u, 0u).x;
                const float b = Draw2D(uvec2(pixel, 0u), i, 1u, other).x;
                counts[static_cast<size_t>(a * kGrid) * kGrid + static_cast<size_t>(b * kGrid)] += 1.0;
            }
            for (double count : counts) variance += (count - 64.0) * (count - 64.0) / (16.0 * kPixels);
        }
        const double expected = 256.0 * 0.25 * 0.75;
        // 9 independent cells in each of 400 pixels.
        EXPECT_NEAR(variance, expected, 5.0 * expected * std::sqrt(2.0 / (9.0 * kPixels))) << other;
    }
}

// The root of the mean squared error of an integral over many pixels.
double IntegrationError(SamplerKind kind, uint sampleCount) {
    threadSamplerKind = kind;
    const double side = std::sqrt(M_PI) * 0.5 * std::erf(1.0);
    constexpr uint kPixels = 300;
    double sum = 0.0;
    for (uint pixel = 0; pixel < kPixels; ++pixel) {
        double estimate = 0.0;
        for (uint i = 0; i < sampleCount; ++i) {
            const vec2 u = Draw2D(uvec2(pixel, 1u), i, 5u, 2u);
            estimate += std::exp(-static_cast<double>(u.x) * u.x - static_cast<double>(u.y) * u.y);
        }
        const double error = estimate / sampleCount - side * side;
        sum += error * error;
    }
    threadSamplerKind = SamplerKind::Sobol;
    return std::sqrt(sum / kPixels);
}

TEST(Sobol, ConvergesFasterThanIndependentSamplesOnSmoothIntegrand) {
    double previous = 0.0;
    for (uint n : {64u, 256u, 1024u, 4096u}) {
        const double sobol = IntegrationError(SamplerKind::Sobol, n);
        const double independent = IntegrationError(SamplerKind::Pcg, n);
        RecordProperty("sobol_" + std::to_string(n), std::to_string(sobol));
        // Theory: sigma / sqrt(n) against about n^-1.5.
        EXPECT_LT(sobol * 10.0, independent) << n;
        if (previous > 0.0) {
            EXPECT_GT(std::log(previous / sobol) / std::log(4.0), 1.3) << n;
        }
        previous = sobol;
    }
}

TEST(Sobol, EstimatesAreUnbiased) {
    // The mean of 4-sample estimates of x^2 y over many pixels, against 1/6, in its own deviations.
    double sum = 0.0;
    double squares = 0.0;
    constexpr uint kPixels = 50'000;
    for (uint pixel = 0; pixel < kPixels; ++pixel) {
        double estimate = 0.0;
        for (uint i = 0; i < 4; ++i) {
            const vec2 u = Draw2D(uvec2(pixel, 9u), i, 1u, 4u);
            estimate += 0.25 * static_cast<double>(u.x) * u.x * u.y;
        }
        sum += estimate;
        squares += estimate * estimate;
    }
    const double mean = sum / kPixels;
    const double deviation = std::sqrt((squares / kPixels - mean * mean) / kPixels);
    EXPECT_NEAR(mean, 1.0 / 6.0, 4.0 * deviation);
}

}  // namespace
}  // namespace raygraph::shading::sobol_test

// Times of samples in a shutter.
namespace raygraph::session::sample_time_test {
namespace {

TEST(SampleTime, EachAlignedBlockHasOneTimeInEachPart) {
    for (const uint32_t seed : {0u, 7u, 0xffffffffu})
        for (const uint32_t first : {0u, 64u, 0xffffffc0u})
            for (uint32_t count = 1; count <= 64; count *= 2) {
                std::vector<uint32_t> times(count);
                for (uint32_t i = 0; i < count; ++i) {
                    const double position = ShutterPosition(first + i, seed);
                    ASSERT_GE(position, 0.0);
                    ASSERT_LT(position, 1.0);
                    ++times[static_cast<size_t>(position * count)];
                }
                EXPECT_EQ(times, std::vector<uint32_t>(count, 1)) << seed << " " << first << " " << count;
            }
}

// A picture of few samples must be right in the mean: over seeds, the time of any sample is uniform.
TEST(SampleTime, TimesOfASampleAreUniformOverSeeds) {
    constexpr uint32_t kSeeds = 65536, kBins = 32;
    for (const uint32_t sample : {0u, 1u, 5u, 4096u}) {
        std::vector<double> counts(kBins), expected(kBins, double{kSeeds} / kBins);
        for (uint32_t seed = 0; seed < kSeeds; ++seed)
            ++counts[static_cast<size_t>(ShutterPosition(sample, seed) * kBins)];
        EXPECT_GT(test::ChiSquareTest(counts, expected).pValue, 1e-4) << sample;
    }
}

// Were the two coupled, a pixel would see each time through one part of its area only, at any number of
// samples.
TEST(SampleTime, TimesAreIndependentOfWhereAPixelIsSampled) {
    constexpr uint32_t kSamples = 65536, kBins = 8;
    for (const uint32_t dimension : {0u, 1u, 2u, 17u}) {
        std::vector<double> counts(kBins * kBins),
            expected(kBins * kBins, double{kSamples} / (kBins * kBins));
        for (uint32_t i = 0; i < kSamples; ++i) {
            shading::Sampler rng = shading::StartPixelSample(shading::uvec2(3, 5), i, 0);
            rng.dimension = dimension;
            const auto across = static_cast<size_t>(shading::Get1D(rng) * kBins);
            ++counts[kBins * static_cast<size_t>(ShutterPosition(i, 0) * kBins) + across];
        }
        EXPECT_GT(test::ChiSquareTest(counts, expected).pValue, 1e-4) << dimension;
    }
}

}  // namespace
}  // namespace raygraph::session::sample_time_test

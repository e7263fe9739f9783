// Tests what the default sampler promises beyond uniformity: stratification and faster convergence.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "core/rng.glsl"
#include "tests/support/chi_square.h"

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

// Times of samples in a shutter.
#include "editor/session/frames/sample_frames.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/rng.glsl"
#include "tests/support/chi_square.h"

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

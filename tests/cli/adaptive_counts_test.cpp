// Tests, on the host alone, which pixels of an adaptive render get samples, and how many.
#include "editor/session/frames/adaptive_frames.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>

#include "shaders/shared/mix_bits.h"
#include "tests/cli/adaptive_picture.h"
#include "tests/cli/cli_test.h"

namespace raygraph::session::adaptive_counts_test {

using namespace adaptive_picture;

namespace {

using Extent2D = rhi::Extent2D;

double AverageOf(std::span<const uint32_t> counts) {
    return static_cast<double>(std::accumulate(counts.begin(), counts.end(), uint64_t{0})) /
           static_cast<double>(counts.size());
}

uint32_t ColorOf(size_t pixel) {
    return (pixel % 24 + pixel / 24) % 2;
}

// Returns `noted` with the values of `changed` in the pixels of color `ofColor`.
PixelVariances WithColor(PixelVariances noted, uint32_t ofColor, const PixelVariances& changed) {
    ForPixelsOfColor(kPicture, ofColor, [&](size_t i) {
        noted.variance[i] = changed.variance[i];
        noted.mean[i] = changed.mean[i];
    });
    return noted;
}

// Allocates samples for both colors.
std::vector<uint32_t> Allocate(const PixelVariances& noted, std::span<const uint32_t> least,
                               uint32_t average = 64) {
    std::vector<uint32_t> wanted(kPixels);
    for (const uint32_t color : {0u, 1u}) AllocateSamples(kPicture, color, noted, least, average, wanted);
    return wanted;
}

}  // namespace

TEST(AdaptiveCounts, AllocationGoesWithTheDeviationAndHasTheAverage) {
    const std::vector<uint32_t> wanted = Allocate(Noted(), std::vector<uint32_t>(kPixels, 16));
    double ofColor[2] = {}, pixelsOfColor[2] = {};
    for (size_t i = 0; i < kPixels; ++i) {
        EXPECT_GE(wanted[i], 16u);
        EXPECT_LE(wanted[i], 16u * 64u);
        EXPECT_TRUE(std::has_single_bit(wanted[i])) << wanted[i];
        ofColor[ColorOf(i)] += wanted[i];
        pixelsOfColor[ColorOf(i)] += 1.0;
    }
    // Each color has its own average, and never less
    for (const int color : {0, 1}) {
        EXPECT_GE(ofColor[color] / pixelsOfColor[color], 64.0);
        EXPECT_LE(ofColor[color] / pixelsOfColor[color], 65.0);
    }
    EXPECT_EQ(wanted[20 * 1 + 24 * 14], 16u) << "far from any noise";
    EXPECT_GT(wanted[24 * 5 + 4], 100u);
    EXPECT_LT(wanted[24 * 5 + 20], wanted[24 * 5 + 4] / 4);
}

// A pixel's error counts relative to its brightness, except in the dark.
TEST(AdaptiveCounts, AllocationIsRelativeToTheMean) {
    const std::vector<uint32_t> least(kPixels, 1);
    const std::vector<float> ones(kPixels, 1.0f);
    PixelVariances bright{ones, ones}, dark{ones, ones};
    for (size_t i = 0; i < kPixels; ++i)
        if (i % 24 < 12) {
            bright.mean[i] = 2.0f;
            bright.variance[i] = 4.0f;
            dark.mean[i] = 1e-4f;
            dark.variance[i] = 1e-8f;
        }
    const std::vector<uint32_t> even = Allocate(bright, least);
    EXPECT_NEAR(even[24 * 8 + 4], 64.0, 16.0);
    EXPECT_NEAR(even[24 * 8 + 20], 64.0, 16.0);
    const std::vector<uint32_t> uneven = Allocate(dark, least);
    EXPECT_LT(uneven[24 * 8 + 4], 8u);
    EXPECT_GT(uneven[24 * 8 + 20], 100u);
}

TEST(AdaptiveCounts, AllocationIsWithinItsBoundsWhereFewPixelsVary) {
    const std::vector<uint32_t> least(kPixels, 16);
    const PixelVariances still{std::vector<float>(kPixels, 0.0f), std::vector<float>(kPixels, 1.0f)};
    // Without noise all pixels get equally many
    for (const uint32_t count : Allocate(still, least)) EXPECT_EQ(count, 64u);
    // Around a single noisy pixel, its neighbors get the most, and the others the rest
    PixelVariances lone = still;
    lone.variance[24 * 8 + 12] = 1.0f;
    const std::vector<uint32_t> wanted = Allocate(lone, least);
    EXPECT_NEAR(AverageOf(wanted), 64.0, 0.64);
    EXPECT_GT(wanted[24 * 8 + 13], 8u * 64u);
    // The noisy pixel's own color must not depend on this noise
    EXPECT_NEAR(wanted[24 * 8 + 12], 64.0, 4.0);
    EXPECT_LT(wanted[1], 64u);
    // A picture of one pixel has no neighbor
    std::vector<uint32_t> one(1);
    AllocateSamples({1, 1}, 0, {{1.0f}, {1.0f}}, std::vector<uint32_t>{16}, 64, one);
    EXPECT_EQ(one, std::vector<uint32_t>{64});
    // Pixels that already have more keep it
    std::vector<uint32_t> uneven(kPixels, 16);
    uneven[3] = 200;
    EXPECT_GE(Allocate(Noted(), uneven)[3], 200u);
}

// Otherwise the number of a pixel's samples would depend on their values, and bias the mean.
TEST(AdaptiveCounts, WhatAPixelGetsIsAFunctionOfTheOtherColorAlone) {
    const std::vector<uint32_t> least(kPixels, 16);
    for (const uint32_t changed : {0u, 1u}) {
        const std::vector<uint32_t> before = Allocate(AnyNoted(7), least);
        const std::vector<uint32_t> after = Allocate(WithColor(AnyNoted(7), changed, AnyNoted(8)), least);
        size_t others = 0;
        for (size_t i = 0; i < kPixels; ++i) {
            if (ColorOf(i) == changed) {
                EXPECT_EQ(after[i], before[i]) << i;
            } else {
                others += after[i] != before[i] ? 1 : 0;
            }
        }
        EXPECT_GT(others, kPixels / 4) << "those of the other color follow";
    }
}

// This holds wherever a render ends: one number of samples for both colors would tell each of the other's.
TEST(AdaptiveCounts, WhereARenderEndsAColorIsAFunctionOfTheOtherAlone) {
    for (const uint32_t average : {16u, 17u, 40u, 64u, 65u, 100u, 127u, 128u, 129u, 130u, 200u, 256u, 300u})
        for (const uint32_t changed : {0u, 1u}) {
            AdaptiveCounts before(kPicture), after(kPicture);
            RunTo(before, average, 1000, AnyNoted(7));
            RunTo(after, average, 1000, WithColor(AnyNoted(7), changed, AnyNoted(8)));
            const std::vector<uint32_t> countsBefore = before.State().counts,
                                        countsAfter = after.State().counts;
            size_t own = 0, others = 0;
            for (size_t i = 0; i < kPixels; ++i)
                (ColorOf(i) == changed ? own : others) += countsAfter[i] != countsBefore[i] ? 1 : 0;
            EXPECT_EQ(own, 0u) << average << ", color " << changed;
            // The changed color also keeps the average, to less than one sample per pixel
            uint64_t total = 0;
            ForPixelsOfColor(kPicture, changed, [&](size_t i) { total += countsAfter[i]; });
            EXPECT_EQ(total / PixelsOfColor(kPicture, changed), average);
            if (average > 20) {
                EXPECT_GT(others, kPixels / 8) << average;
            }
        }
}

TEST(AdaptiveCounts, StagesHaveTheirBaseAndTheirAverage) {
    AdaptiveCounts counts(kPicture);
    EXPECT_EQ(counts.WalkPixels(0).size(), kPixels) << "the first samples are of all pixels";
    RunTo(counts, 16, 1000, Noted());
    EXPECT_EQ(counts.State().counts, std::vector<uint32_t>(kPixels, 16));
    for (uint32_t stage = 128; stage <= 1024; stage *= 2) {
        RunTo(counts, stage, 1000, Noted());
        const AdaptiveState state = counts.State();
        EXPECT_EQ(state.stages, (std::array<uint32_t, 2>{stage, stage}));
        EXPECT_EQ(counts.Least(), std::ranges::min(state.counts));
        EXPECT_GE(counts.Least(), stage / 4) << "the base of the next one";
        EXPECT_NEAR(AverageOf(state.counts), stage, 0.02 * stage);
        EXPECT_LE(std::ranges::max(state.counts), 16 * stage);
    }
    // A color never has less than its average, however counts are rounded
    for (uint32_t seed = 0; seed < 20; ++seed) {
        AdaptiveCounts any(kPicture);
        RunTo(any, 256, 1000, AnyNoted(seed));
        EXPECT_EQ(any.State().stages, (std::array<uint32_t, 2>{256, 256})) << seed;
    }
}

// The values that are noted at a base are thus those of its samples alone.
TEST(AdaptiveCounts, NoStepCrossesABaseAndEachIsNoted) {
    AdaptiveCounts counts(kPicture);
    RunTo(counts, 16, 1000, AnyNoted(7));
    std::map<uint32_t, std::vector<bool>> noted;
    for (uint32_t average = 17; average <= 600; ++average) {
        while (true) {
            const AdaptiveCounts::Next next = counts.NextTo(average);
            if (next.kind == AdaptiveCounts::Next::Kind::Nothing) break;
            if (next.kind == AdaptiveCounts::Next::Kind::Decision) {
                const AdaptiveState state = counts.State();
                const uint32_t base = BaseAfter(state.stages[next.color]);
                ForPixelsOfColor(kPicture, 1 - next.color, [&](size_t i) {
                    EXPECT_TRUE(state.counts[i] == base || (state.counts[i] > base && noted[base].at(i)))
                        << i << " has " << state.counts[i] << ", base " << base;
                });
                counts.Decide(next.color, AnyNoted(7));
                continue;
            }
            const std::vector<AdaptiveCounts::WalkPixel>& pixels = counts.WalkPixels(next.color);
            const uint32_t base = counts.BaseToRecord(next.color);
            for (uint32_t i = 0; i < next.pixels; ++i) {
                const uint32_t count = pixels[i].count + next.taken;
                for (uint32_t crossed = 16; crossed < 4096; crossed *= 2)
                    EXPECT_FALSE(count < crossed && count + next.length > crossed);
                if (base > 0 && count == base) {
                    noted[base].resize(kPixels);
                    noted[base][pixels[i].pixel] = true;
                }
            }
            counts.Advance(next, next.length);
        }
        const std::vector<uint32_t> now = counts.State().counts;
        EXPECT_EQ(counts.Least(), std::ranges::min(now));
        EXPECT_EQ(counts.Average(), average);
    }
}

TEST(AdaptiveCounts, NeitherStepsNorStopsChangeWhatComesNext) {
    const PixelVariances noted = AnyNoted(3);
    AdaptiveCounts one(kPicture), many(kPicture);
    RunTo(one, 300, 1, noted);
    RunTo(many, 300, 1000, noted);
    EXPECT_EQ(one.State(), many.State());
    EXPECT_GE(one.Total(), 300u * kPixels);
    EXPECT_LT(one.Total(), 301u * kPixels);
    // Continues from the state that a file would have, at several averages
    AdaptiveCounts stopped(kPicture);
    for (const uint32_t average : {1u, 7u, 16u, 17u, 40u, 64u, 65u, 128u, 129u, 130u, 131u, 256u, 300u}) {
        RunTo(stopped, average, 1000, noted);
        EXPECT_EQ(stopped.Average(), average);
        EXPECT_EQ(stopped.Average(), stopped.State().Average());
        stopped = AdaptiveCounts(kPicture, stopped.State());
        EXPECT_EQ(stopped.Least(), std::ranges::min(stopped.State().counts));
    }
    EXPECT_EQ(one.State(), stopped.State());
}

// Otherwise a render of many pixels would wait for the host: steps are the first pixels of one list.
TEST(AdaptiveCounts, AStageHasFewWalksAndSteps) {
    AdaptiveCounts counts(kPicture);
    RunTo(counts, 128, 1000, AnyNoted(3));
    uint32_t steps = 0, walks = 0;
    uint64_t last = 0;
    while (true) {
        const AdaptiveCounts::Next next = counts.NextTo(256);
        if (next.kind == AdaptiveCounts::Next::Kind::Nothing) break;
        if (next.kind == AdaptiveCounts::Next::Kind::Decision) {
            counts.Decide(next.color, AnyNoted(3));
            continue;
        }
        walks += std::exchange(last, counts.WalkId(next.color)) != last ? 1 : 0;
        ++steps;
        const std::vector<AdaptiveCounts::WalkPixel>& pixels = counts.WalkPixels(next.color);
        EXPECT_TRUE(std::ranges::is_sorted(pixels, std::greater{}, &AdaptiveCounts::WalkPixel::missing));
        counts.Advance(next, next.length);
    }
    EXPECT_LT(walks, 60u);
    EXPECT_LT(steps, 600u);
}

namespace {

// Draws samples from a heavy-tailed distribution of mean 1: mostly 0, and now and then 50. `shared` is the
// number of consecutive pixels with the same numbers.
class HeavyTail {
  public:
    HeavyTail(uint32_t seed, uint32_t shared) : m_seed(seed), m_shared(shared) {}
    double At(size_t pixel, uint32_t index) const {
        const auto stream = static_cast<uint32_t>(pixel / m_shared);
        const uint32_t bits = gpu::MixBits(gpu::MixBits(stream * 65536 + index) ^ gpu::MixBits(m_seed));
        return bits < 0xFFFFFFFFu / 50 ? 50.0 : 0.0;
    }
    // Returns the variance of the first `count` samples.
    float VarianceOf(size_t pixel, uint32_t count) const {
        const double mean = MeanOf(pixel, count);
        return static_cast<float>((mean * 50.0 - mean * mean) * count / (count - 1.0));
    }
    double MeanOf(size_t pixel, uint32_t count) const {
        double sum = 0.0;
        for (uint32_t i = 0; i < count; ++i) sum += At(pixel, i);
        return sum / count;
    }

  private:
    uint32_t m_seed, m_shared;
};

// Returns how far the mean over many renders of `average` samples is from 1, in standard errors.
double DeviationOfMean(uint32_t average, uint32_t renders, uint32_t shared) {
    using Kind = AdaptiveCounts::Next::Kind;
    constexpr Extent2D kSmall{8, 8};
    double sum = 0.0, squares = 0.0;
    for (uint32_t seed = 0; seed < renders; ++seed) {
        const HeavyTail values(seed, shared);
        AdaptiveCounts counts(kSmall);
        for (auto next = counts.NextTo(average); next.kind != Kind::Nothing; next = counts.NextTo(average)) {
            if (next.kind == Kind::Samples) {
                counts.Advance(next, next.length);
                continue;
            }
            const uint32_t base = BaseAfter(counts.State().stages[next.color]);
            PixelVariances noted;
            for (size_t i = 0; i < 64; ++i) {
                noted.variance.push_back(values.VarianceOf(i, base));
                noted.mean.push_back(static_cast<float>(values.MeanOf(i, base)));
            }
            counts.Decide(next.color, noted);
        }
        const std::vector<uint32_t> taken = counts.State().counts;
        double mean = 0.0;
        for (size_t i = 0; i < 64; ++i) mean += values.MeanOf(i, taken[i]) / 64.0;
        sum += mean;
        squares += mean * mean;
    }
    const double mean = sum / renders;
    const double variance = (squares / renders - mean * mean) / (renders - 1.0);
    return (mean - 1.0) / std::sqrt(variance);
}

}  // namespace

// The mean is exact for any distribution, and wherever a render ends. Where pixels share random numbers, a
// neighbor's samples are the pixel's own, and decide for it: the test would find such a bias if a pixel's
// samples decided about itself, which is why adaptive renders refuse samplers that pixels share.
TEST(AdaptiveCounts, MeanIsUnbiasedUnlessPixelsShareTheirNumbers) {
    for (const auto& [average, renders] : {std::pair{64u, 1500u}, {100u, 1500u}, {200u, 600u}})
        EXPECT_LT(std::abs(DeviationOfMean(average, renders, 1)), 3.3) << average;
    for (const uint32_t average : {64u, 100u}) EXPECT_LT(DeviationOfMean(average, 1500, 2), -5.0) << average;
}

TEST(AdaptiveCounts, AStageThatEndsEarlyHasExtraSamplesEverywhere) {
    AdaptiveCounts half(kPicture), whole(kPicture);
    RunTo(half, 192, 1000, Noted());
    RunTo(whole, 256, 1000, Noted());
    const std::vector<uint32_t> ofHalf = half.State().counts, ofWhole = whole.State().counts;
    const auto noisiest = static_cast<size_t>(std::ranges::max_element(ofWhole) - ofWhole.begin());
    EXPECT_GE(ofHalf[noisiest], ofWhole[noisiest] / 2);
    for (size_t i = 0; i < kPixels; ++i) EXPECT_LE(ofHalf[i], ofWhole[i]);
}

}  // namespace raygraph::session::adaptive_counts_test

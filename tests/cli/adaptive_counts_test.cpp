// Which pixels of an adaptive render get samples, and how many: on the host alone.
#include "editor/session/adaptive_counts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>

#include "shaders/shared/mix_bits.h"
#include "tests/cli/cli_test.h"

namespace raygraph::session {
namespace {

using Extent2D = rhi::Extent2D;

constexpr Extent2D kPicture{24, 17};
constexpr size_t kPixels = size_t{24} * 17;

// Noise on the left that is ten times that on the right, and none on the lower rows.
std::vector<float> Variances() {
    std::vector<float> variance(kPixels);
    for (size_t i = 0; i < kPixels; ++i) variance[i] = i / 24 > 11 ? 0.0f : i % 24 < 12 ? 1.0f : 0.01f;
    return variance;
}

double AverageOf(std::span<const uint32_t> counts) {
    return static_cast<double>(std::accumulate(counts.begin(), counts.end(), uint64_t{0})) /
           static_cast<double>(counts.size());
}

bool IsWhite(size_t pixel) {
    return (pixel % 24 + pixel / 24) % 2 == 0;
}

// Runs until the average is reached, at most `atOnce` samples a step.
void RunTo(AdaptiveCounts& counts, uint32_t average, uint32_t atOnce, std::span<const float> variance) {
    while (counts.Average() < average) {
        if (counts.NeedsDecision()) counts.Decide(variance);
        const uint64_t missing = uint64_t{average} * kPixels - counts.Total();
        const uint64_t members = counts.Members().size();
        counts.Advance(std::min(
            {static_cast<uint32_t>((missing + members - 1) / members), counts.StepLength(), atOnce}));
    }
}

}  // namespace

TEST(AdaptiveCounts, AllocationGoesWithTheDeviationAndHasTheAverage) {
    const std::vector<uint32_t> least(kPixels, 16);
    const std::vector<uint32_t> wanted = AllocateSamples(kPicture, Variances(), least, 64, 4);
    double ofColor[2] = {}, pixelsOfColor[2] = {};
    for (size_t i = 0; i < kPixels; ++i) {
        EXPECT_GE(wanted[i], 16u);
        EXPECT_LE(wanted[i], 16u * 64u + 4u);
        EXPECT_EQ(wanted[i] % 4, 0u);
        ofColor[IsWhite(i)] += wanted[i];
        pixelsOfColor[IsWhite(i)] += 1.0;
    }
    // Each color has its own
    for (const int color : {0, 1}) EXPECT_NEAR(ofColor[color] / pixelsOfColor[color], 64.0, 0.5);
    EXPECT_GE(AverageOf(wanted), 64.0);
    EXPECT_EQ(wanted[20 * 1 + 24 * 14], 16u) << "far from any noise";
    EXPECT_GT(wanted[24 * 5 + 4], 100u);
    EXPECT_LT(wanted[24 * 5 + 20], wanted[24 * 5 + 4] / 4);
}

TEST(AdaptiveCounts, AllocationIsWithinItsBoundsWhereFewPixelsVary) {
    const std::vector<uint32_t> least(kPixels, 16);
    // Without any noise all get as many
    for (const uint32_t count : AllocateSamples(kPicture, std::vector<float>(kPixels, 0.0f), least, 64, 4))
        EXPECT_EQ(count, 64u);
    // One pixel: those around it get the most, and the others what is left
    std::vector<float> lone(kPixels, 0.0f);
    lone[24 * 8 + 12] = 1.0f;
    const std::vector<uint32_t> wanted = AllocateSamples(kPicture, lone, least, 64, 4);
    EXPECT_NEAR(AverageOf(wanted), 64.0, 0.64);
    EXPECT_NEAR(wanted[24 * 8 + 13], 16 * 64, 4);
    // Its own color has no noise that it may know of
    EXPECT_NEAR(wanted[24 * 8 + 12], 64.0, 4.0);
    EXPECT_LT(wanted[1], 64u);
    // A picture of one pixel has no neighbor
    EXPECT_EQ(AllocateSamples({1, 1}, std::vector<float>{1.0f}, std::vector<uint32_t>{16}, 64, 4),
              std::vector<uint32_t>{64});
    // Those that have more keep it
    std::vector<uint32_t> uneven(kPixels, 16);
    uneven[3] = 200;
    EXPECT_GE(AllocateSamples(kPicture, Variances(), uneven, 64, 4)[3], 200u);
}

// Else the number of a pixel's samples would say something of their values, and the mean would be biased.
TEST(AdaptiveCounts, WhatAPixelGetsIsAFunctionOfTheOtherColorAlone) {
    std::mt19937 random(7);
    std::lognormal_distribution<float> any(0.0f, 2.0f);
    std::vector<float> variance(kPixels);
    for (float& value : variance) value = any(random);
    std::vector<float> changed = variance;
    for (size_t i = 0; i < kPixels; ++i)
        if (IsWhite(i)) changed[i] = any(random);
    const std::vector<uint32_t> least(kPixels, 16);
    const std::vector<uint32_t> before = AllocateSamples(kPicture, variance, least, 64, 4);
    const std::vector<uint32_t> after = AllocateSamples(kPicture, changed, least, 64, 4);
    size_t others = 0;
    for (size_t i = 0; i < kPixels; ++i) {
        if (IsWhite(i)) {
            EXPECT_EQ(after[i], before[i]) << i;
        } else {
            others += after[i] != before[i] ? 1 : 0;
        }
    }
    EXPECT_GT(others, kPixels / 4) << "the black ones follow the white ones";
}

TEST(AdaptiveCounts, StagesHaveTheirBaseAndTheirAverage) {
    AdaptiveCounts counts(kPicture);
    const std::vector<float> variance = Variances();
    EXPECT_EQ(counts.Members().size(), kPixels) << "the first samples are of all pixels";
    for (uint32_t stage = 64; stage <= 512; stage *= 2) {
        while (!counts.NeedsDecision()) {
            for (const uint32_t base : counts.BasesToNote())
                EXPECT_GT(base, stage / 8) << "decided by already";
            counts.Advance(counts.StepLength());
        }
        EXPECT_EQ(counts.Base(), stage / 4);
        EXPECT_GE(counts.Least(), stage / 4);
        if (stage > 64) EXPECT_NEAR(AverageOf(counts.State().counts), stage / 2.0, stage / 8.0);
        counts.Decide(variance);
        while (counts.State().isDecided && !counts.NeedsDecision()) {
            // No step crosses a base
            for (const uint32_t pixel : counts.Members()) {
                const uint32_t count = counts.State().counts[pixel];
                EXPECT_LE(count + counts.StepLength(), std::max(std::bit_ceil(count + 1), 16u));
            }
            counts.Advance(counts.StepLength());
        }
        const double average = AverageOf(counts.State().counts);
        if (!counts.NeedsDecision()) EXPECT_NEAR(average, stage, 0.01 * stage);
    }
}

TEST(AdaptiveCounts, NeitherStepsNorStopsChangeWhatComesNext) {
    const std::vector<float> variance = Variances();
    AdaptiveCounts one(kPicture), many(kPicture);
    RunTo(one, 300, 1, variance);
    RunTo(many, 300, 1000, variance);
    EXPECT_EQ(one.State(), many.State());
    EXPECT_GE(one.Total(), 300u * kPixels);
    EXPECT_LT(one.Total(), 301u * kPixels);
    // From the state that a file has, at any time
    AdaptiveCounts stopped(kPicture);
    for (const uint32_t average : {1u, 7u, 16u, 17u, 40u, 64u, 65u, 130u, 300u}) {
        RunTo(stopped, average, 1000, variance);
        EXPECT_EQ(stopped.Average(), average);
        stopped = AdaptiveCounts(kPicture, stopped.State());
    }
    EXPECT_EQ(one.State(), stopped.State());
}

namespace {

// Samples of a heavy tail and mean 1: mostly nothing, and now and then 50. `shared`: so many pixels in a row
// have the same numbers.
class HeavyTail {
  public:
    HeavyTail(uint32_t seed, uint32_t shared) : m_seed(seed), m_shared(shared) {}
    double At(size_t pixel, uint32_t index) const {
        const auto stream = static_cast<uint32_t>(pixel / m_shared);
        const uint32_t bits = gpu::MixBits(gpu::MixBits(stream * 65536 + index) ^ gpu::MixBits(m_seed));
        return bits < 0xFFFFFFFFu / 50 ? 50.0 : 0.0;
    }
    // Of the first ones.
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

// How far the mean over all pixels of many renders of `average` samples is from 1, in standard errors.
double DeviationOfMean(uint32_t average, uint32_t renders, uint32_t shared) {
    constexpr Extent2D kSmall{8, 8};
    double sum = 0.0, squares = 0.0;
    for (uint32_t seed = 0; seed < renders; ++seed) {
        const HeavyTail values(seed, shared);
        AdaptiveCounts counts(kSmall);
        while (counts.Average() < average) {
            if (counts.NeedsDecision()) {
                std::vector<float> variance(64);
                for (size_t i = 0; i < 64; ++i) variance[i] = values.VarianceOf(i, counts.Base());
                counts.Decide(variance);
            }
            counts.Advance(counts.StepLength());
        }
        double mean = 0.0;
        for (size_t i = 0; i < 64; ++i) mean += values.MeanOf(i, counts.State().counts[i]) / 64.0;
        sum += mean;
        squares += mean * mean;
    }
    const double mean = sum / renders;
    const double variance = (squares / renders - mean * mean) / (renders - 1.0);
    return (mean - 1.0) / std::sqrt(variance);
}

}  // namespace

// Exactly: of any distribution. Where pixels share random numbers, those of a neighbor are its own, and where
// they decide for the pixel, rare bright samples bring more samples that dilute them: this is what the test
// would find if a pixel's samples decided about itself, and why a sampler that pixels share is no sampler for
// this.
TEST(AdaptiveCounts, MeanIsUnbiasedUnlessPixelsShareTheirNumbers) {
    for (const auto& [average, renders] : {std::pair{64u, 1500u}, {256u, 300u}}) {
        EXPECT_LT(std::abs(DeviationOfMean(average, renders, 1)), 3.3) << average;
        EXPECT_LT(DeviationOfMean(average, renders, 2), -5.0) << average;
    }
}

// A quarter of a stage's extra samples gives some to all that get any.
TEST(AdaptiveCounts, AStageThatEndsEarlyHasExtraSamplesEverywhere) {
    const std::vector<float> variance = Variances();
    AdaptiveCounts half(kPicture), whole(kPicture);
    RunTo(half, 192, 1000, variance);
    RunTo(whole, 256, 1000, variance);
    const auto noisiest =
        static_cast<size_t>(std::ranges::max_element(whole.State().counts) - whole.State().counts.begin());
    EXPECT_GT(half.State().counts[noisiest], whole.State().counts[noisiest] / 2);
    for (size_t i = 0; i < kPixels; ++i) EXPECT_LE(half.State().counts[i], whole.State().counts[i]);
}

TEST(AdaptiveCounts, FlawsOfAStateAreNamed) {
    AdaptiveCounts counts(kPicture);
    RunTo(counts, 100, 1000, Variances());
    AdaptiveState good = counts.State();
    const uint32_t most = std::ranges::max(good.counts);
    ASSERT_TRUE(good.isDecided);
    for (uint32_t base = 2 * counts.Base(); base < most; base *= 2)
        good.variances[base].assign(kPixels, 1.0f);
    EXPECT_EQ(FlawOf(good, kPixels), "");
    ASSERT_FALSE(good.variances.empty());
    const auto expectFlaw = [&](const char* part, auto&& change) {
        AdaptiveState bad = good;
        change(bad);
        EXPECT_NE(FlawOf(bad, kPixels).find(part), std::string::npos) << part << ": " << FlawOf(bad, kPixels);
    };
    expectFlaw("counts", [](AdaptiveState& s) { s.counts.pop_back(); });
    expectFlaw("without a sample", [](AdaptiveState& s) { s.counts[5] = 0; });
    expectFlaw("wanted", [](AdaptiveState& s) { s.wanted.pop_back(); });
    expectFlaw("more samples than it is to have", [](AdaptiveState& s) { s.wanted[5] = s.counts[5] - 1; });
    expectFlaw("than its stage gives", [](AdaptiveState& s) { s.wanted[5] = 0xFFFFFFFFu; });
    expectFlaw("stage of 96", [](AdaptiveState& s) { s.stage = 96; });
    expectFlaw("stage of 0", [](AdaptiveState& s) { s.stage = 0; });
    expectFlaw("no variance of", [](AdaptiveState& s) { s.variances.clear(); });
    expectFlaw("not of its pixels", [](AdaptiveState& s) { s.variances.begin()->second.pop_back(); });
    expectFlaw("is no number", [](AdaptiveState& s) { s.variances.begin()->second[1] = -1.0f; });
    expectFlaw("is no number", [](AdaptiveState& s) { s.variances.begin()->second[1] = INFINITY; });
    // Of a file without sums, which cannot go on
    AdaptiveState ended{.counts = good.counts, .wanted = {}, .variances = {}};
    EXPECT_EQ(FlawOf(ended, kPixels), "");
}

}  // namespace raygraph::session

#include "editor/session/file/sum_residuals.h"

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "tests/cli/cli_test.h"

namespace raygraph::session::sum_residuals_test {
namespace {

constexpr uint32_t kWidth = 7;

PredictedSums Back(const SumResiduals& residuals, size_t channels, uint32_t width,
                   const SumPrediction& prediction) {
    std::array<std::span<const uint32_t>, kSumWordCount> words;
    for (size_t i = 0; i < kSumWordCount; ++i) words[i] = residuals.words[i];
    return SumsOf(words, channels, width, prediction, 5);
}

// Returns the sums of samples of which some are dark, some bright, some negative.
passes::ExactSums SumsOfSamples(size_t pixels, uint32_t count) {
    std::mt19937 random(count);
    passes::ExactSums sums = passes::MakeExactSums(pixels, true);
    for (uint32_t n = 0; n < count; ++n) {
        Texels sample(4 * pixels);
        for (float& value : sample)
            value = std::ldexp(static_cast<float>(random()) / 4294967296.0f - 0.2f,
                               static_cast<int>(random() % 12) - 6);
        passes::AddSample(sums, sample);
    }
    return sums;
}

size_t WordsOf(const SumResiduals& residuals, bool ofSquares, bool onlyNonZero) {
    size_t words = 0;
    for (size_t i = 0; i < kSumWordCount; ++i) {
        const LargeArray<uint32_t>& of = residuals.words[i];
        const bool isAnything = std::ranges::any_of(of, [](uint32_t word) { return word != 0; });
        if (kSumWords[i].isSquareSum == ofSquares && !of.empty() && (isAnything || !onlyNonZero))
            words = std::max(words, kSumWords[i].word + 1);
    }
    return words;
}

TEST(SumResiduals, OfOneSampleThereAreNone) {
    const passes::ExactSums sums = SumsOfSamples(3 * kWidth, 1);
    const Texels mean = passes::MeanOf(sums, 1), variance = passes::VarianceOf(sums, 1);
    const std::vector<uint32_t> counts{1};
    const SumResiduals residuals = ResidualsOf(sums, 4, kWidth, {mean, variance, counts}, 5);
    EXPECT_EQ(WordsOf(residuals, false, true), 0u);
    EXPECT_EQ(WordsOf(residuals, true, true), 0u);
    // The lowest words tell that there are sums
    EXPECT_EQ(WordsOf(residuals, false, false), 1u);
    EXPECT_EQ(WordsOf(residuals, true, false), 1u);
    EXPECT_EQ(Back(residuals, 4, kWidth, {mean, variance, counts}).sums, sums);
}

TEST(SumResiduals, TakeTwoWordsWhereSumsTakeFour) {
    constexpr uint32_t kCount = 512;
    const passes::ExactSums sums = SumsOfSamples(3 * kWidth, kCount);
    const Texels mean = passes::MeanOf(sums, kCount), variance = passes::VarianceOf(sums, kCount);
    const std::vector<uint32_t> counts{kCount};
    const SumResiduals residuals = ResidualsOf(sums, 4, kWidth, {mean, variance, counts}, 5);
    EXPECT_EQ(WordsOf(residuals, false, true), 2u);
    EXPECT_EQ(WordsOf(residuals, true, true), 2u);
    const PredictedSums back = Back(residuals, 4, kWidth, {mean, variance, counts});
    EXPECT_EQ(back.sums, sums);
    EXPECT_EQ(back.digest, residuals.digest);
}

// Programs may have stored anything as mean and variance.
TEST(SumResiduals, GiveSumsBackWhateverIsPredicted) {
    constexpr size_t kPixels = 300 * kWidth;
    std::mt19937 generator(1);
    const auto random = [&] { return static_cast<uint32_t>(generator()); };
    passes::ExactSums sums = passes::MakeExactSums(kPixels, true);
    for (auto* planes : {&sums.sums, &sums.squares})
        for (passes::ExactSums::Plane& plane : *planes)
            for (uint32_t& word : plane) word = random() % 3 == 0 ? 0xFFFFFFFFu : random() % 2 * random();
    for (size_t i = 0; i < kPixels; ++i) sums.squares[3][4 * i + 3] = 0;  // unused
    Texels mean(4 * kPixels), variance(4 * kPixels);
    for (Texels* texels : {&mean, &variance})
        for (float& value : *texels) value = std::bit_cast<float>(random());
    mean[0] = variance[0] = std::numeric_limits<float>::quiet_NaN();
    mean[1] = variance[1] = std::numeric_limits<float>::infinity();
    mean[2] = variance[2] = -std::numeric_limits<float>::max();
    mean[4] = variance[4] = std::numeric_limits<float>::denorm_min();
    std::vector<uint32_t> counts(kPixels);
    for (uint32_t& count : counts) count = random() % 4 == 0 ? random() % 2 : random();
    counts[0] = counts[1] = 0xFFFFFFFFu;
    const SumPrediction prediction{mean, variance, counts};
    const PredictedSums back = Back(ResidualsOf(sums, 4, kWidth, prediction, 5), 4, kWidth, prediction);
    for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k) {
        EXPECT_EQ(back.sums.sums[k], sums.sums[k]) << k;
        EXPECT_EQ(back.sums.squares[k], sums.squares[k]) << k;
    }
}

// Large pictures are processed by several threads.
TEST(SumResiduals, OfLargePicturesAreThoseOfTheirRows) {
    constexpr uint32_t kLargeWidth = 1000, kHeight = 300;
    const passes::ExactSums sums = SumsOfSamples(size_t{kLargeWidth} * kHeight, 3);
    const Texels mean = passes::MeanOf(sums, 3), variance = passes::VarianceOf(sums, 3);
    const std::vector<uint32_t> counts{3};
    const SumResiduals residuals = ResidualsOf(sums, 4, kLargeWidth, {mean, variance, counts}, 5);
    const PredictedSums back = Back(residuals, 4, kLargeWidth, {mean, variance, counts});
    EXPECT_TRUE(back.sums == sums);
    EXPECT_EQ(back.digest, residuals.digest);
    const auto rowOf = [&](const passes::ExactSums::Plane& plane, size_t y) {
        return passes::ExactSums::Plane(plane.begin() + 4 * y * kLargeWidth,
                                        plane.begin() + 4 * (y + 1) * kLargeWidth);
    };
    for (const size_t y : {size_t{0}, size_t{149}, size_t{150}, size_t{kHeight - 1}}) {
        passes::ExactSums row;
        for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k) {
            row.sums[k] = rowOf(sums.sums[k], y);
            row.squares[k] = rowOf(sums.squares[k], y);
        }
        const size_t first = 4 * y * kLargeWidth, size = 4 * kLargeWidth;
        const SumResiduals ofRow = ResidualsOf(
            row, 4, kLargeWidth,
            {std::span(mean).subspan(first, size), std::span(variance).subspan(first, size), counts}, 5);
        for (size_t i = 0; i < kSumWordCount; ++i) {
            if (ofRow.words[i].empty()) continue;
            const auto inPicture = std::span(residuals.words[i]).subspan(y * kLargeWidth, kLargeWidth);
            EXPECT_TRUE(std::ranges::equal(ofRow.words[i], inPicture)) << "row " << y << ", word " << i;
        }
    }
}

TEST(SumResiduals, OtherSumsHaveOtherDigests) {
    passes::ExactSums sums = SumsOfSamples(3 * kWidth, 4);
    const Texels mean = passes::MeanOf(sums, 4);
    const std::vector<uint32_t> counts{4};
    const auto digest = [&](size_t channels, uint64_t seed) {
        return ResidualsOf(sums, channels, kWidth, {mean, {}, counts}, seed).digest;
    };
    const uint64_t first = digest(4, 5);
    EXPECT_EQ(digest(4, 5), first);
    EXPECT_NE(digest(3, 5), first);
    EXPECT_NE(digest(4, 6), first);
    sums.sums[0][11] ^= 1u;
    EXPECT_NE(digest(4, 5), first);
}

}  // namespace
}  // namespace raygraph::session::sum_residuals_test

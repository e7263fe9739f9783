// SumResiduals stores exact sums in a file. The file also has mean and variance of the samples, from which
// its reader predicts the sums up to the rounding of these floats. Stored is the residual, the difference
// between a sum and its prediction, a signed integer of few bits, as zigzag code (0, -1, 1, -2, 2 are 0, 1,
// 2, 3, 4):
//   sum:     mean * count
//   squares: variance * (count - 1) + sum^2 / count
// each in units of 2^-64, in integers alone, so that any machine predicts the same bits.
//
// A word of these codes is a channel of the file. Of its bytes, a row has the lowest of all pixels first,
// then the next ones, so that bytes which are noise and bytes which are mostly 0 do not alternate: deflate
// finds the zeros. For editor/session/ alone. Threads: pure functions; with large pictures they have other
// threads work for them until they return.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/large_pages.h"
#include "passes/accumulate.h"

namespace raygraph::session {

// Selects a word of a pixel's sums, lowest first.
struct SumWord {
    bool isSquareSum = false;
    size_t channel = 0, word = 0;
};
inline constexpr size_t kSumWordCount = 4 * passes::ExactSums::kPlanes + 3 * (passes::ExactSums::kPlanes + 1);
inline constexpr std::array<SumWord, kSumWordCount> kSumWords = [] {
    std::array<SumWord, kSumWordCount> words;
    size_t i = 0;
    for (size_t c = 0; c < 4; ++c)
        for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k) words[i++] = {false, c, k};
    for (size_t c = 0; c < 3; ++c)
        for (size_t k = 0; k <= passes::ExactSums::kPlanes; ++k) words[i++] = {true, c, k};
    return words;
}();

// The sums of a file are predicted from these.
struct SumPrediction {
    std::span<const float> mean, variance;  // RGBA; a variance only if there are squares
    std::span<const uint32_t> counts;       // samples of each pixel, or one count for all
};

struct SumResiduals {
    // By kSumWords, for all pixels. An empty array stands for 0 in all pixels, or for words that are not
    // stored; the lowest words of stored sums are never empty.
    std::array<LargeArray<uint32_t>, kSumWordCount> words;
    uint64_t digest = 0;  // digest of the sums
};

// Computes residuals of the first `channels` of them, in rows of `width` pixels. `seed` is part of the
// digest.
SumResiduals ResidualsOf(const passes::ExactSums& sums, size_t channels, uint32_t width,
                         const SumPrediction& prediction, uint64_t seed);

// Returns the sums of these residuals, with squares if the prediction has a variance. Empty words are 0.
struct PredictedSums {
    passes::ExactSums sums;
    uint64_t digest = 0;  // see SumResiduals
};
PredictedSums SumsOf(const std::array<std::span<const uint32_t>, kSumWordCount>& residuals, size_t channels,
                     uint32_t width, const SumPrediction& prediction, uint64_t seed);

}  // namespace raygraph::session

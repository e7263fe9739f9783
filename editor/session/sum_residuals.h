// Exact sums as a file stores them. The file has mean and variance of the samples too, and from these its
// reader predicts the sums up to the roundings of these floats. Stored is what a sum is beyond its
// prediction, a signed integer of few bits, as zigzag code (0, -1, 1, -2, 2 are 0, 1, 2, 3, 4):
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
#include "passes/exact_sums.h"

namespace raygraph::session {

// Which word of a pixel's sums, lowest first.
struct SumWord {
    bool isOfSquares = false;
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

// What the sums of a file are predicted from.
struct SumPrediction {
    std::span<const float> mean, variance;  // RGBA; a variance only where there are squares
    std::span<const uint32_t> counts;       // of the samples of each pixel, or one for all
};

struct SumResiduals {
    // By kSumWords, of all pixels. Empty: 0 for all, or not stored; the lowest words of what is stored never
    // are.
    std::array<LargeArray<uint32_t>, kSumWordCount> words;
    uint64_t digest = 0;  // of the sums
};

// Of the first `channels` of them, in rows of `width` pixels. `seed` is part of the digest.
SumResiduals ResidualsOf(const passes::ExactSums& sums, size_t channels, uint32_t width,
                         const SumPrediction& prediction, uint64_t seed);

// Sums of which these are the residuals; with squares if the prediction has a variance. Empty words are 0.
struct PredictedSums {
    passes::ExactSums sums;
    uint64_t digest = 0;  // as of SumResiduals
};
PredictedSums SumsOf(const std::array<std::span<const uint32_t>, kSumWordCount>& residuals, size_t channels,
                     uint32_t width, const SumPrediction& prediction, uint64_t seed);

}  // namespace raygraph::session

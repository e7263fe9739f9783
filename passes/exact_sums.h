// ExactSums: the sums of Accumulate on the host: to be stored, restored, and added to the sums of other
// samples. How a sample becomes an integer is in shaders/shared/exact_sums.h. Threads: plain values and pure
// functions, for any thread; with large pictures they have other threads work for them, until they return.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/api.h"
#include "base/large_pages.h"

namespace raygraph::passes {

// Texels of four words, rows from the top, as the device keeps them in textures of rgba32ui: component c of
// plane k is word k of the sum of channel c. Squares are of the channels 0 to 2 and have a fifth word, which
// is component 3 of plane c. Component 3 of the last plane of squares is unused.
struct ExactSums {
    static constexpr size_t kPlanes = 4;
    using Plane = LargeArray<uint32_t>;
    std::array<Plane, kPlanes> sums;
    std::array<Plane, kPlanes> squares;  // empty: not accumulated

    bool IsEmpty() const { return sums[0].empty(); }
    bool HasSquares() const { return !squares[0].empty(); }
    size_t PixelCount() const { return sums[0].size() / 4; }
    bool operator==(const ExactSums&) const = default;
};

// Returns the sums of no samples: zeros.
RAYGRAPH_API ExactSums MakeExactSums(size_t pixelCount, bool withSquares);

// Adds a sample of every pixel, RGBA, or the sums over other samples. The bits do not depend on the order.
// Error{Usage} unless both are of as many pixels, and with or without squares.
RAYGRAPH_API void AddSample(ExactSums& sums, std::span<const float> rgba);
RAYGRAPH_API void AddSums(ExactSums& sums, const ExactSums& others);

// Return the mean of `sampleCount` samples, at least 1, and their unbiased variance, 0 below two: RGBA, each
// the float nearest to the exact value. w of the variance is 0. The bits are those of Accumulate.
RAYGRAPH_API std::vector<float> MeanOf(const ExactSums& sums, uint32_t sampleCount);
RAYGRAPH_API std::vector<float> VarianceOf(const ExactSums& sums, uint32_t sampleCount);

// Sums on their way to another process: pixel by pixel a record, which holds all words of its channels.
// Words of one record.
RAYGRAPH_API size_t WordsOfRecord(bool withSquares);
// The records of as many pixels as `records` has room for, from `firstPixel` on; and back.
RAYGRAPH_API void PackSums(const ExactSums& sums, size_t firstPixel, std::span<uint32_t> records);
RAYGRAPH_API void UnpackSums(std::span<const uint32_t> records, size_t firstPixel, ExactSums& sums);
// Adds records as AddSums adds sums; both sides have the same number.
RAYGRAPH_API void AddRecords(std::span<uint32_t> records, std::span<const uint32_t> others, bool withSquares);

}  // namespace raygraph::passes

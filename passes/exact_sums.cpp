#include "passes/exact_sums.h"

#include <bit>
#include <string>

#include "base/check.h"
#include "base/in_parts.h"
#include "base/text.h"
#include "shaders/shared/exact_sums.h"

namespace raygraph::passes {

namespace {

static_assert(ExactSums::kPlanes == gpu::kSumWords && ExactSums::kPlanes + 1 == gpu::kSquareWords);

void RequireComparable(size_t pixels, size_t otherPixels, bool isAlike) {
    if (pixels != otherPixels || !isAlike)
        throw MakeError(ErrorKind::Usage, "exact sums: {} pixels to add to {}{}", otherPixels, pixels,
                        (isAlike ? "" : ", and the squares of one side alone"));
}

// Adds a word with the carry from the word below, and leaves its own.
void AddWord(uint32_t& word, uint32_t added, uint32_t& carry) {
    const uint64_t sum = uint64_t{word} + added + carry;
    word = static_cast<uint32_t>(sum);
    carry = static_cast<uint32_t>(sum >> 32);
}

// Word k of the squares of a channel.
template <typename Planes>
auto& SquareWord(Planes& squares, size_t pixel, size_t channel, size_t k) {
    return k < ExactSums::kPlanes ? squares[k][4 * pixel + channel] : squares[channel][4 * pixel + 3];
}

gpu::ExactSum SumOf(const ExactSums& sums, size_t pixel, size_t channel) {
    gpu::ExactSum sum;
    for (size_t k = 0; k < ExactSums::kPlanes; ++k) sum.words[k] = sums.sums[k][4 * pixel + channel];
    return sum;
}

}  // namespace

ExactSums MakeExactSums(size_t pixelCount, bool withSquares) {
    ExactSums sums;
    sums.sums.fill(ExactSums::Plane(4 * pixelCount, 0u));
    if (withSquares) sums.squares = sums.sums;
    return sums;
}

void AddSample(ExactSums& sums, std::span<const float> rgba) {
    RequireComparable(sums.PixelCount(), rgba.size() / 4, true);
    for (size_t i = 0; i < rgba.size(); ++i) {
        const gpu::ExactValue value = gpu::ExactSample(std::bit_cast<uint32_t>(rgba[i]));
        const gpu::ExactWords words = gpu::WordsOf(value);
        uint32_t carry = words.complement & 1u;
        for (int k = 0; k < gpu::kSumWords; ++k) AddWord(sums.sums[k][i], gpu::WordOf(words, k), carry);
        if (!sums.HasSquares() || i % 4 == 3) continue;
        const gpu::ExactWords square = gpu::WordsOf(gpu::ExactSquare(value));
        carry = 0;
        for (int k = 0; k < gpu::kSquareWords; ++k)
            AddWord(SquareWord(sums.squares, i / 4, i % 4, k), gpu::WordOf(square, k), carry);
    }
}

void AddSums(ExactSums& sums, const ExactSums& others) {
    RequireComparable(sums.PixelCount(), others.PixelCount(), sums.HasSquares() == others.HasSquares());
    InParts(sums.PixelCount(), [&](size_t first, size_t end) {
        for (size_t i = 4 * first; i < 4 * end; ++i) {
            uint32_t carry = 0;
            for (size_t k = 0; k < ExactSums::kPlanes; ++k)
                AddWord(sums.sums[k][i], others.sums[k][i], carry);
            if (!sums.HasSquares() || i % 4 == 3) continue;
            carry = 0;
            for (size_t k = 0; k <= ExactSums::kPlanes; ++k)
                AddWord(SquareWord(sums.squares, i / 4, i % 4, k),
                        SquareWord(others.squares, i / 4, i % 4, k), carry);
        }
    });
}

std::vector<float> MeanOf(const ExactSums& sums, uint32_t sampleCount) {
    RG_CHECK(sampleCount > 0);
    const gpu::ExactDivisor divisor = gpu::DivisorOf(sampleCount);
    std::vector<float> mean(4 * sums.PixelCount());
    InParts(sums.PixelCount(), [&](size_t first, size_t end) {
        for (size_t i = 4 * first; i < 4 * end; ++i)
            mean[i] = std::bit_cast<float>(gpu::MeanOfExactSum(SumOf(sums, i / 4, i % 4), divisor));
    });
    return mean;
}

std::vector<float> VarianceOf(const ExactSums& sums, uint32_t sampleCount) {
    RG_CHECK(sums.HasSquares());
    std::vector<float> variance(4 * sums.PixelCount(), 0.0f);
    InParts(sums.PixelCount(), [&](size_t first, size_t end) {
        for (size_t i = 4 * first; i < 4 * end; ++i) {
            if (i % 4 == 3) continue;
            gpu::ExactSquares squares;
            for (size_t k = 0; k <= ExactSums::kPlanes; ++k)
                squares.words[k] = SquareWord(sums.squares, i / 4, i % 4, k);
            variance[i] = std::bit_cast<float>(
                gpu::VarianceOfExactSums(SumOf(sums, i / 4, i % 4), squares, sampleCount));
        }
    });
    return variance;
}

// A record: for each channel the words of its sum, lowest first; then likewise of its squares.
size_t WordsOfRecord(bool withSquares) {
    return 4 * ExactSums::kPlanes + (withSquares ? 3 * (ExactSums::kPlanes + 1) : 0);
}

namespace {

// Calls `move(word of the record, word of the planes)` for each.
template <typename Words, typename Sums, typename Move>
void ForEachWord(Words records, Sums& sums, size_t firstPixel, Move&& move) {
    const bool withSquares = sums.HasSquares();
    const size_t count = records.size() / WordsOfRecord(withSquares);
    RG_CHECK(firstPixel + count <= sums.PixelCount());
    size_t at = 0;
    for (size_t pixel = firstPixel; pixel < firstPixel + count; ++pixel) {
        for (size_t c = 0; c < 4; ++c)
            for (size_t k = 0; k < ExactSums::kPlanes; ++k) move(records[at++], sums.sums[k][4 * pixel + c]);
        for (size_t c = 0; c < 3 && withSquares; ++c)
            for (size_t k = 0; k <= ExactSums::kPlanes; ++k)
                move(records[at++], SquareWord(sums.squares, pixel, c, k));
    }
}

}  // namespace

void PackSums(const ExactSums& sums, size_t firstPixel, std::span<uint32_t> records) {
    ForEachWord(records, sums, firstPixel, [](uint32_t& record, uint32_t word) { record = word; });
}

void UnpackSums(std::span<const uint32_t> records, size_t firstPixel, ExactSums& sums) {
    ForEachWord(records, sums, firstPixel, [](uint32_t record, uint32_t& word) { word = record; });
}

void AddRecords(std::span<uint32_t> records, std::span<const uint32_t> others, bool withSquares) {
    RG_CHECK_EQ(records.size(), others.size());
    size_t at = 0;
    const auto addNumber = [&](size_t words) {
        uint32_t carry = 0;
        for (size_t k = 0; k < words; ++k, ++at) AddWord(records[at], others[at], carry);
    };
    while (at < records.size()) {
        for (size_t c = 0; c < 4; ++c) addNumber(ExactSums::kPlanes);
        for (size_t c = 0; c < 3 && withSquares; ++c) addNumber(ExactSums::kPlanes + 1);
    }
}

}  // namespace raygraph::passes

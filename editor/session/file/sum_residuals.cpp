#include "editor/session/file/sum_residuals.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <mutex>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/check.h"
#include "base/in_parts.h"
#include "shaders/shared/exact_sums.h"

namespace raygraph::session {

namespace {

__extension__ using Wide = unsigned __int128;

// Describes an integer of 160 bits, as two's complement.
struct Squares {
    Wide low = 0;
    uint32_t high = 0;
};
Squares operator+(const Squares& a, const Squares& b) {
    const Wide low = a.low + b.low;
    return {low, a.high + b.high + (low < a.low ? 1u : 0u)};
}
Squares operator-(const Squares& a, const Squares& b) {
    return {a.low - b.low, a.high - b.high - (a.low < b.low ? 1u : 0u)};
}

// Maps 0, -1, 1, -2, 2 to 0, 1, 2, 3, 4.
Wide ZigZag(Wide value) {
    return (value << 1) ^ (Wide{0} - (value >> 127));
}
Wide FromZigZag(Wide code) {
    return (code >> 1) ^ (Wide{0} - (code & 1));
}
Squares ZigZag(const Squares& value) {
    const uint32_t sign = value.high >> 31;
    return {(value.low << 1) ^ (Wide{0} - sign),
            ((value.high << 1) | static_cast<uint32_t>(value.low >> 127)) ^ (0u - sign)};
}
Squares FromZigZag(const Squares& code) {
    const auto sign = static_cast<uint32_t>(code.low & 1);
    return {((code.low >> 1) | (Wide{code.high & 1u} << 127)) ^ (Wide{0} - sign),
            (code.high >> 1) ^ (0u - sign)};
}

// Returns value * 2^shift in 160 bits; half a unit is rounded up.
Squares Shifted(Wide value, int shift) {
    if (shift <= -128 || shift >= 160) return {};
    if (shift < 0) return {(value >> -shift) + ((value >> (-shift - 1)) & 1)};
    if (shift == 0) return {value};
    if (shift < 128) return {value << shift, static_cast<uint32_t>(value >> (128 - shift))};
    return {0, static_cast<uint32_t>(value) << (shift - 128)};
}

// Returns |value| * factor; 0 for denormals and for infinities and NaN.
Squares Product(float value, uint32_t factor) {
    const uint32_t bits = std::bit_cast<uint32_t>(value) & 0x7FFFFFFFu, exponent = bits >> 23;
    if (exponent == 0 || exponent == 255) return {};
    const uint64_t mantissa = (bits & 0x7FFFFFu) | 0x800000u;
    return Shifted(mantissa * factor, static_cast<int>(exponent) - 150 - gpu::kUnitExponent);
}

Wide PredictedSum(float mean, uint32_t count) {
    const Wide magnitude = Product(mean, count).low;
    return std::bit_cast<uint32_t>(mean) >> 31 != 0 ? Wide{0} - magnitude : magnitude;
}

Squares PredictedSquares(Wide sum, float variance, uint32_t count) {
    if (count == 0) return {};
    const Squares spread = Product(variance, count - 1);
    const Wide magnitude = sum >> 127 != 0 ? Wide{0} - sum : sum;
    if (magnitude == 0) return spread;
    // The highest 64 bits suffice: they contain all bits of a single sample
    const auto high = static_cast<uint64_t>(magnitude >> 64);
    const int zeros =
        high != 0 ? std::countl_zero(high) : 64 + std::countl_zero(static_cast<uint64_t>(magnitude));
    const auto top = static_cast<uint64_t>((magnitude << zeros) >> 64);
    return spread + Shifted(Wide{top} * top / count, 2 * (64 - zeros) + gpu::kUnitExponent);
}

// Holds the sums of a pixel.
struct Pixel {
    std::array<Wide, 4> sums{};
    std::array<Squares, 3> squares{};

    uint64_t Digest(uint64_t seed) const {
        std::array<uint64_t, 17> words;
        size_t i = 0;
        const auto add = [&](Wide value) {
            words[i++] = static_cast<uint64_t>(value);
            words[i++] = static_cast<uint64_t>(value >> 64);
        };
        for (const Wide sum : sums) add(sum);
        for (const Squares& of : squares) {
            add(of.low);
            words[i++] = of.high;
        }
        return XXH3_64bits_withSeed(words.data(), sizeof words, seed);
    }
};

Wide LowWords(const std::array<passes::ExactSums::Plane, passes::ExactSums::kPlanes>& planes, size_t i) {
    Wide value = 0;
    for (size_t k = 0; k < planes.size(); ++k) value |= Wide{planes[k][i]} << (32 * k);
    return value;
}
void SetLowWords(std::array<passes::ExactSums::Plane, passes::ExactSums::kPlanes>& planes, size_t i,
                 Wide value) {
    for (size_t k = 0; k < planes.size(); ++k) planes[k][i] = static_cast<uint32_t>(value >> (32 * k));
}

// Gives the range of a sum's words in kSumWords.
struct Words {
    size_t first, count;
};
Words WordsOfSum(size_t channel) {
    return {passes::ExactSums::kPlanes * channel, passes::ExactSums::kPlanes};
}
Words WordsOfSquares(size_t channel) {
    constexpr size_t kCount = passes::ExactSums::kPlanes + 1;
    return {WordsOfSum(4).first + kCount * channel, kCount};
}

// The codes rely on it that byte 0 of a row of words is the lowest one of the first pixel.
static_assert(std::endian::native == std::endian::little);

// Collects the codes of a row on their way into the picture. Threads: one at a time.
class CodesOfRow {
  public:
    explicit CodesOfRow(size_t width) : m_width(width), m_words(kSumWordCount * width) {}

    void Set(const Words& words, size_t x, Squares code) {
        for (size_t b = 0; code.low != 0; ++b, code.low >>= 8)
            SetByte(words, b, x, static_cast<uint8_t>(code.low));
        for (size_t b = 16; code.high != 0; ++b, code.high >>= 8)
            SetByte(words, b, x, static_cast<uint8_t>(code.high));
    }

    // Copies them to `rowOf(i)` for those words i that are not all 0, and clears them.
    template <typename RowOf>
    void Put(const RowOf& rowOf) {
        for (size_t i = 0; i < kSumWordCount; ++i) {
            if ((m_used >> i & 1u) == 0) continue;
            const auto from = m_words.begin() + static_cast<ptrdiff_t>(i * m_width);
            std::copy_n(from, m_width, rowOf(i));
            std::fill_n(from, m_width, 0u);
        }
        m_used = 0;
    }

  private:
    void SetByte(const Words& words, size_t b, size_t x, uint8_t value) {
        const size_t word = words.first + b / 4;
        reinterpret_cast<uint8_t*>(m_words.data() + word * m_width)[b % 4 * m_width + x] = value;
        m_used |= 1u << word;
    }

    size_t m_width;
    std::vector<uint32_t> m_words;
    uint32_t m_used = 0;  // a bit for each word
    static_assert(kSumWordCount <= 32);
};

// A row of words is null where they are all 0.
using RowOfWords = std::array<const uint8_t*, kSumWordCount>;

Squares CodeOf(const Words& words, const RowOfWords& row, size_t width, size_t x) {
    Squares code;
    for (size_t k = 0; k < words.count; ++k) {
        const uint8_t* const bytes = row[words.first + k];
        if (bytes == nullptr) continue;
        uint32_t word = 0;
        for (size_t b = 0; b < 4; ++b) word |= uint32_t{bytes[b * width + x]} << (8 * b);
        if (k < passes::ExactSums::kPlanes)
            code.low |= Wide{word} << (32 * k);
        else
            code.high = word;
    }
    return code;
}

// Calls ofSum(channel, predicted) for the sums of a pixel, then ofSquares likewise; both return the actual
// sums. Returns the pixel's part of the digest.
template <typename OfSum, typename OfSquares>
uint64_t ForEachSum(size_t channels, size_t squareChannels, const SumPrediction& prediction, size_t pixel,
                    uint64_t seed, const OfSum& ofSum, const OfSquares& ofSquares) {
    const uint32_t count = prediction.counts[prediction.counts.size() == 1 ? 0 : pixel];
    Pixel exact;
    for (size_t c = 0; c < channels; ++c)
        exact.sums[c] = ofSum(c, PredictedSum(prediction.mean[4 * pixel + c], count));
    for (size_t c = 0; c < squareChannels; ++c)
        exact.squares[c] =
            ofSquares(c, PredictedSquares(exact.sums[c], prediction.variance[4 * pixel + c], count));
    return exact.Digest(seed + pixel);
}

}  // namespace

SumResiduals ResidualsOf(const passes::ExactSums& sums, size_t channels, uint32_t width,
                         const SumPrediction& prediction, uint64_t seed) {
    const size_t pixels = sums.PixelCount();
    RG_CHECK_EQ(prediction.mean.size(), 4 * pixels);
    const size_t squareChannels = sums.HasSquares() && !prediction.variance.empty() ? 3 : 0;
    SumResiduals residuals;
    std::mutex mutex;
    const auto wordsOf = [&](size_t i) -> uint32_t* {
        const std::lock_guard lock(mutex);
        if (residuals.words[i].empty()) residuals.words[i].resize(pixels);
        return residuals.words[i].data();
    };
    for (size_t c = 0; c < channels; ++c) wordsOf(WordsOfSum(c).first);
    for (size_t c = 0; c < squareChannels; ++c) wordsOf(WordsOfSquares(c).first);
    std::atomic<uint64_t> digest = 0;
    InParts(pixels, [&](size_t first, size_t end) {
        uint64_t digestOfPart = 0;
        CodesOfRow codes(width);
        for (size_t y = first / width; y < end / width; ++y) {
            for (size_t x = 0; x < width; ++x) {
                const size_t pixel = y * width + x;
                digestOfPart += ForEachSum(
                    channels, squareChannels, prediction, pixel, seed,
                    [&](size_t c, Wide predicted) {
                        const Wide sum = LowWords(sums.sums, 4 * pixel + c);
                        codes.Set(WordsOfSum(c), x, {ZigZag(sum - predicted)});
                        return sum;
                    },
                    [&](size_t c, const Squares& predicted) {
                        const Squares squares{LowWords(sums.squares, 4 * pixel + c),
                                              sums.squares[c][4 * pixel + 3]};
                        codes.Set(WordsOfSquares(c), x, ZigZag(squares - predicted));
                        return squares;
                    });
            }
            codes.Put([&](size_t i) { return wordsOf(i) + y * width; });
        }
        digest += digestOfPart;
    });
    residuals.digest = digest;
    return residuals;
}

PredictedSums SumsOf(const std::array<std::span<const uint32_t>, kSumWordCount>& residuals, size_t channels,
                     uint32_t width, const SumPrediction& prediction, uint64_t seed) {
    const size_t pixels = prediction.mean.size() / 4;
    const size_t squareChannels = prediction.variance.empty() ? 0 : 3;
    PredictedSums predicted{passes::MakeExactSums(pixels, squareChannels > 0)};
    passes::ExactSums& sums = predicted.sums;
    std::atomic<uint64_t> digest = 0;
    InParts(pixels, [&](size_t first, size_t end) {
        uint64_t digestOfPart = 0;
        for (size_t y = first / width; y < end / width; ++y) {
            RowOfWords row{};
            for (size_t i = 0; i < kSumWordCount; ++i)
                if (!residuals[i].empty())
                    row[i] = reinterpret_cast<const uint8_t*>(residuals[i].data() + y * width);
            for (size_t x = 0; x < width; ++x) {
                const size_t pixel = y * width + x;
                digestOfPart += ForEachSum(
                    channels, squareChannels, prediction, pixel, seed,
                    [&](size_t c, Wide ofMean) {
                        const Wide sum = ofMean + FromZigZag(CodeOf(WordsOfSum(c), row, width, x).low);
                        SetLowWords(sums.sums, 4 * pixel + c, sum);
                        return sum;
                    },
                    [&](size_t c, const Squares& ofVariance) {
                        const Squares squares =
                            ofVariance + FromZigZag(CodeOf(WordsOfSquares(c), row, width, x));
                        SetLowWords(sums.squares, 4 * pixel + c, squares.low);
                        sums.squares[c][4 * pixel + 3] = squares.high;
                        return squares;
                    });
            }
        }
        digest += digestOfPart;
    });
    predicted.digest = digest;
    return predicted;
}

}  // namespace raygraph::session

// Follows the KTX File Format Specification 2.0, appendices "BasisLZ Global Data" and "BasisLZ/ETC1S
// Bitstream Specification", and the Khronos Data Format Specification 1.4, chapter ETC1.

#include "renderer/image/basis_lz.h"

#include <algorithm>
#include <array>
#include <new>

#include "base/text.h"
#include "renderer/image/bc_blocks.h"
#include "renderer/image/decode.h"

namespace raygraph::image {
namespace {

constexpr size_t kGlobalHeaderBytes = 20, kImageBytes = 20;
constexpr uint32_t kIsPFrame = 2;

// ETC1's modifiers of brightness, by the table's number, for patterns 2 and 3; those of 1 and 0 are their
// negatives.
constexpr std::array<std::array<int, 2>, 8> kModifiers{
    {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}}};

// A block may have these four colors.
using Palette = std::array<std::array<uint8_t, 3>, 4>;
// A pattern has two bits a texel, the first texel's the lowest.
using Pattern = uint32_t;

struct Codebooks {
    std::vector<Palette> palettes;
    std::vector<Pattern> patterns;
};

Palette PaletteOf(const std::array<uint32_t, 3>& color, uint32_t table) {
    Palette palette;
    for (size_t i = 0; i < 4; ++i) {
        const int modifier = i < 2 ? -kModifiers[table][1 - i] : kModifiers[table][i - 2];
        for (size_t c = 0; c < 3; ++c) {
            const int base = static_cast<int>(color[c] << 3 | color[c] >> 2);
            palette[i][c] = static_cast<uint8_t>(std::clamp(base + modifier, 0, 255));
        }
    }
    return palette;
}

// Reads differences of colors of 5 bits, by one of three codes, which the previous color selects.
std::vector<Palette> ReadPalettes(BitReader bits, size_t count) {
    const HuffmanCode dark(bits), middle(bits), bright(bits), tables(bits);
    const size_t channels = bits.Take(1) != 0 ? 1 : 3;
    std::array<uint32_t, 3> color{16, 16, 16};
    uint32_t table = 0;
    std::vector<Palette> palettes;
    for (size_t i = 0; i < count; ++i) {
        table = (table + tables.Take(bits)) & 7;
        for (size_t c = 0; c < channels; ++c) {
            const HuffmanCode& code = color[c] < 10 ? dark : color[c] < 22 ? middle : bright;
            color[c] = (color[c] + code.Take(bits)) & 31;
        }
        if (channels == 1) color[1] = color[2] = color[0];
        palettes.push_back(PaletteOf(color, table));
    }
    return palettes;
}

std::vector<Pattern> ReadPatterns(BitReader bits, size_t count) {
    if (bits.Take(2) != 0) bits.Fail("are of a reserved kind");
    const auto takeRows = [&] {
        uint32_t rows = 0;
        for (unsigned row = 0; row < 4; ++row) rows |= bits.Take(8) << 8 * row;
        return rows;
    };
    std::vector<Pattern> patterns;
    if (bits.Take(1) != 0) {
        while (patterns.size() < count) patterns.push_back(takeRows());
        return patterns;
    }
    const HuffmanCode differences(bits);
    patterns.push_back(takeRows());
    while (patterns.size() < count) {
        Pattern pattern = patterns.back();
        for (unsigned row = 0; row < 4; ++row) {
            const uint32_t difference = differences.Take(bits);
            if (difference > 255) bits.Fail("have a row of more than 8 bits");
            pattern ^= difference << 8 * row;
        }
        patterns.push_back(pattern);
    }
    return patterns;
}

// Holds the codes of the slices.
struct SliceCodes {
    HuffmanCode predictions, paletteSteps, patterns, runs;
    uint32_t historySize;

    explicit SliceCodes(BitReader bits)
        : predictions(bits), paletteSteps(bits), patterns(bits), runs(bits), historySize(bits.Take(13)) {}
};

// Holds recently used patterns, roughly by frequency: one that is used moves to half its index.
class History {
  public:
    explicit History(uint32_t size) : m_patterns(size), m_next(size / 2) {}

    size_t Size() const { return m_patterns.size(); }
    uint32_t Use(uint32_t place) {
        const uint32_t pattern = m_patterns[place];
        std::swap(m_patterns[place / 2], m_patterns[place]);
        return pattern;
    }
    void Add(uint32_t pattern) {
        if (m_patterns.empty()) return;
        m_patterns[m_next++] = pattern;
        if (m_next == m_patterns.size()) m_next = static_cast<uint32_t>(m_patterns.size() / 2);
    }

  private:
    std::vector<uint32_t> m_patterns;
    uint32_t m_next;
};

// Reads the palettes' numbers of a slice's blocks, row by row. Four blocks, two by two, share a symbol that
// says how they follow from their neighbors.
class PaletteReader {
  public:
    PaletteReader(const SliceCodes& codes, size_t paletteCount, uint32_t blocksX)
        : m_codes(codes),
          m_paletteCount(paletteCount),
          m_above(blocksX),
          m_current(blocksX),
          m_lower((blocksX + 1) / 2) {}

    void StartRow() { std::swap(m_above, m_current); }

    uint32_t Next(BitReader& bits, uint32_t x, uint32_t y) {
        if (x % 2 == 0 && y % 2 == 0) {
            m_predictions = TakePredictions(bits);
            m_lower[x / 2] = static_cast<uint8_t>(m_predictions >> 4);
        } else if (x % 2 == 0) {
            m_predictions = m_lower[x / 2];
        }
        const uint32_t prediction = m_predictions & 3;
        m_predictions >>= 2;
        const bool needsLeft = prediction == 0 || prediction == 2,
                   needsAbove = prediction == 1 || prediction == 2;
        if ((needsLeft && x == 0) || (needsAbove && y == 0))
            bits.Fail("refers to a block outside the picture");
        switch (prediction) {
            case 0:
                break;
            case 1:
                m_last = m_above[x];
                break;
            case 2:
                m_last = m_above[x - 1];
                break;
            default:
                m_last += m_codes.paletteSteps.Take(bits);
                if (m_last >= m_paletteCount) m_last -= static_cast<uint32_t>(m_paletteCount);
                if (m_last >= m_paletteCount) bits.Fail("refers to a color that there is not");
                break;
        }
        m_current[x] = static_cast<uint16_t>(m_last);
        return m_last;
    }

  private:
    uint32_t TakePredictions(BitReader& bits) {
        constexpr uint32_t kRepeat = 256, kMinRepeat = 3;
        if (m_repeats > 0) {
            --m_repeats;
            return m_lastPredictions;
        }
        const uint32_t symbol = m_codes.predictions.Take(bits);
        if (symbol > kRepeat) bits.Fail("has a prediction that there is not");
        if (symbol == kRepeat) {
            m_repeats = uint64_t{bits.TakeChunks(4)} + kMinRepeat - 1;
        } else {
            m_lastPredictions = symbol;
        }
        return m_lastPredictions;
    }

    const SliceCodes& m_codes;
    size_t m_paletteCount;
    std::vector<uint16_t> m_above, m_current;
    std::vector<uint8_t> m_lower;  // the predictions of the lower two of four blocks
    uint32_t m_predictions = 0, m_lastPredictions = 0, m_last = 0;
    uint64_t m_repeats = 0;
};

// Reads the patterns' numbers of a slice's blocks.
class PatternReader {
  public:
    PatternReader(const SliceCodes& codes, size_t patternCount)
        : m_codes(codes), m_patternCount(patternCount), m_history(codes.historySize) {}

    uint32_t Next(BitReader& bits) {
        if (m_run > 0) {
            --m_run;
            return FromHistory(bits, 0);
        }
        const uint32_t symbol = m_codes.patterns.Take(bits);
        if (symbol < m_patternCount) {
            m_history.Add(symbol);
            return symbol;
        }
        // The symbols after the patterns are indices into the history, and the last one is the sign of a run
        const auto place = static_cast<uint32_t>(symbol - m_patternCount);
        if (place != m_history.Size()) return FromHistory(bits, place);
        constexpr uint32_t kLongRun = 63, kMinRun = 3;
        const uint32_t length = m_codes.runs.Take(bits);
        m_run = (length == kLongRun ? uint64_t{bits.TakeChunks(7)} : length) + kMinRun - 1;
        return FromHistory(bits, 0);
    }

  private:
    uint32_t FromHistory(BitReader& bits, uint32_t place) {
        if (place >= m_history.Size()) bits.Fail("refers to a pattern that there is not");
        return m_history.Use(place);
    }

    const SliceCodes& m_codes;
    size_t m_patternCount;
    History m_history;
    uint64_t m_run = 0;
};

// Decodes a slice into RGB, or its green into alpha. The specification has alpha in red, of slices that may
// be gray or not; those that encoders make are nearly gray, and transcoders, with which their authors check
// pictures, read green.
void DecodeSlice(BitReader bits, const SliceCodes& codes, const Codebooks& books, bool isAlpha,
                 Image8& image) {
    const uint32_t blocksX = (image.width + 3) / 4, blocksY = (image.height + 3) / 4;
    PaletteReader palettes(codes, books.palettes.size(), blocksX);
    PatternReader patterns(codes, books.patterns.size());
    for (uint32_t y = 0; y < blocksY; ++y) {
        palettes.StartRow();
        // Memory is touched only as far as the bits go, so a header that promises more than there is costs
        // nothing.
        const size_t bytesSoFar = size_t{4} * image.width * std::min(image.height, 4 * (y + 1));
        if (image.rgba.size() < bytesSoFar) image.rgba.resize(bytesSoFar, 255);
        for (uint32_t x = 0; x < blocksX; ++x) {
            const Palette& palette = books.palettes[palettes.Next(bits, x, y)];
            const Pattern pattern = books.patterns[patterns.Next(bits)];
            const uint32_t columns = std::min(4u, image.width - 4 * x),
                           rows = std::min(4u, image.height - 4 * y);
            for (uint32_t row = 0; row < rows; ++row) {
                uint8_t* texel =
                    image.rgba.data() + 4 * ((size_t{4} * y + row) * image.width + size_t{4} * x);
                for (uint32_t column = 0; column < columns; ++column, texel += 4) {
                    const auto& color = palette[pattern >> (8 * row + 2 * column) & 3];
                    if (isAlpha) {
                        texel[3] = color[1];
                    } else {
                        for (size_t c = 0; c < 3; ++c) texel[c] = color[c];
                    }
                }
            }
        }
    }
}

class BasisLzReader {
  public:
    BasisLzReader(const Ktx2Header& header, std::string_view name) : m_header(header), m_name(name) {}

    Image8 Decode() {
        const std::span<const std::byte> global = m_header.global;
        if (global.size() < kGlobalHeaderBytes) Fail("the global data is truncated");
        const auto paletteCount = static_cast<size_t>(Little(global, 0, 2));
        const auto patternCount = static_cast<size_t>(Little(global, 2, 2));
        if (paletteCount == 0 || patternCount == 0) Fail("the global data has no colors or no patterns");
        // The slices follow the descriptions of the levels' images
        size_t at = kGlobalHeaderBytes + kImageBytes * m_header.levelCount;
        if (global.size() < at) Fail("the global data is truncated");
        const auto part = [&](size_t lengthAt, const char* what) {
            const size_t length = Little32(global, lengthAt);
            if (length > global.size() - at) Fail("the global data is truncated");
            at += length;
            return BitReader(global.subspan(at - length, length), m_name, what);
        };
        Codebooks books;
        books.palettes = ReadPalettes(part(4, "the list of colors"), paletteCount);
        books.patterns = ReadPatterns(part(8, "the list of patterns"), patternCount);
        const SliceCodes codes(part(12, "the list of codes"));
        const std::span<const std::byte> description = global.subspan(kGlobalHeaderBytes, kImageBytes);
        if ((Little32(description, 0) & kIsPFrame) != 0) Fail("frames of a video are not supported");
        const BitReader color = Slice(description, 4, "the color slice");
        const BitReader alpha = Slice(description, 12, "the alpha slice");
        Image8 image{m_header.width, m_header.height, {}};
        image.rgba.reserve(size_t{4} * image.width * image.height);
        DecodeSlice(color, codes, books, false, image);
        if (m_header.basis.hasSecondSlice) DecodeSlice(alpha, codes, books, true, image);
        return image;
    }

  private:
    [[noreturn]] void Fail(const std::string& what) const { Reject(m_name, "BasisLZ: " + what); }

    BitReader Slice(std::span<const std::byte> description, size_t at, const char* what) const {
        const size_t offset = Little32(description, at), length = Little32(description, at + 4);
        const size_t size = m_header.level.size();
        if (length > size || offset > size - length)
            Fail(Text("{} of {} bytes at {} lies outside its level of {}", what, length, offset, size));
        return {m_header.level.subspan(offset, length), m_name, what};
    }

    const Ktx2Header& m_header;
    std::string_view m_name;
};

}  // namespace

Image8 DecodeBasisLz(const Ktx2Header& header, std::string_view name) {
    try {
        return BasisLzReader(header, name).Decode();
    } catch (const std::bad_alloc&) {
        RejectMemory(name, header.width, header.height);
    }
}

// --- BitReader and HuffmanCode ---

namespace {

constexpr unsigned kLongestWord = 16;
// The code for lengths of words has these symbols beside the lengths: runs of zeros and of the last length.
constexpr uint32_t kShortZeros = 17, kLongZeros = 18, kShortRepeat = 19, kLengthSymbols = 21;
// The lengths of these symbols are stored in this order.
constexpr std::array<uint8_t, kLengthSymbols> kOrder{17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                                     11, 4,  12, 3,  13, 2, 14, 1, 15, 16};

}  // namespace

void BitReader::Fail(const char* what) const {
    Reject(m_name, Text("BasisLZ: {} {}", m_part, what));
}

uint32_t BitReader::TakeChunks(unsigned chunkBits) {
    uint32_t value = 0;
    for (unsigned shift = 0; shift < 32; shift += chunkBits) {
        const uint32_t chunk = Take(chunkBits + 1);
        value |= (chunk & ((1u << chunkBits) - 1)) << shift;
        if (chunk >> chunkBits == 0) return value;
    }
    Fail("has a number of more than 32 bits");
}

HuffmanCode::HuffmanCode(BitReader& bits) {
    const uint32_t symbolCount = bits.Take(14);
    if (symbolCount == 0) return;  // the code is never used
    const uint32_t lengthCount = bits.Take(5);
    if (lengthCount == 0 || lengthCount > kLengthSymbols) bits.Fail("has a malformed code");
    std::array<uint8_t, kLengthSymbols> lengthsOfLengths = {};
    for (uint32_t i = 0; i < lengthCount; ++i)
        lengthsOfLengths[kOrder[i]] = static_cast<uint8_t>(bits.Take(3));
    const HuffmanCode lengthCode(lengthsOfLengths, bits);
    std::vector<uint8_t> lengths;
    lengths.reserve(symbolCount);
    while (lengths.size() < symbolCount) {
        const uint32_t symbol = lengthCode.Take(bits);
        if (symbol < kShortZeros) {
            lengths.push_back(static_cast<uint8_t>(symbol));
            continue;
        }
        const bool isRepeat = symbol >= kShortRepeat;
        if (isRepeat && (lengths.empty() || lengths.back() == 0)) bits.Fail("has a malformed code");
        const uint32_t count = symbol == kShortZeros    ? 3 + bits.Take(3)
                               : symbol == kLongZeros   ? 11 + bits.Take(7)
                               : symbol == kShortRepeat ? 3 + bits.Take(2)
                                                        : 7 + bits.Take(7);
        if (count > symbolCount - lengths.size()) bits.Fail("has a malformed code");
        lengths.insert(lengths.end(), count, isRepeat ? lengths.back() : uint8_t{0});
    }
    Build(lengths, bits);
}

// Words are counted up by their lengths (RFC 1951, section 3.2.2), and stored with their first bit lowest. A
// code may have unused words, as one of a single symbol has.
void HuffmanCode::Build(std::span<const uint8_t> lengths, BitReader& bits) {
    std::array<uint32_t, kLongestWord + 1> counts = {}, next = {};
    for (const uint8_t length : lengths) ++counts[length];
    counts[0] = 0;
    unsigned longest = 0;
    for (unsigned length = 1; length <= kLongestWord; ++length) {
        next[length] = (next[length - 1] + counts[length - 1]) << 1;
        if (counts[length] == 0) continue;
        longest = length;
        if (next[length] + counts[length] > 1u << length) bits.Fail("has a malformed code");
    }
    if (longest == 0) return;
    m_entries.resize(size_t{1} << longest);
    for (size_t symbol = 0; symbol < lengths.size(); ++symbol) {
        const unsigned length = lengths[symbol];
        if (length == 0) continue;
        const uint32_t word = next[length]++;
        uint32_t reversed = 0;
        for (unsigned i = 0; i < length; ++i) reversed |= (word >> i & 1) << (length - 1 - i);
        for (size_t at = reversed; at < m_entries.size(); at += size_t{1} << length)
            m_entries[at] = {static_cast<uint16_t>(symbol), static_cast<uint16_t>(length)};
    }
}

}  // namespace raygraph::image

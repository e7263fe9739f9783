#include "renderer/image/basis_bits.h"

#include <algorithm>
#include <array>

#include "base/text.h"
#include "renderer/image/decode.h"

namespace raygraph::image {
namespace {

constexpr unsigned kLongestWord = 16;
// The symbols of the code for lengths of words: lengths, and runs of zeros and of the last length.
constexpr uint32_t kShortZeros = 17, kLongZeros = 18, kShortRepeat = 19, kLengthSymbols = 21;
// The order in which their own lengths are stored.
constexpr std::array<uint8_t, kLengthSymbols> kOrder{17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                                     11, 4,  12, 3,  13, 2, 14, 1, 15, 16};

}  // namespace

void BasisBits::Fail(const char* what) const {
    Refuse(m_name, Text("BasisLZ: {} {}", m_part, what));
}

uint32_t BasisBits::TakeChunks(unsigned chunkBits) {
    uint32_t value = 0;
    for (unsigned shift = 0; shift < 32; shift += chunkBits) {
        const uint32_t chunk = Take(chunkBits + 1);
        value |= (chunk & ((1u << chunkBits) - 1)) << shift;
        if (chunk >> chunkBits == 0) return value;
    }
    Fail("has a number of more than 32 bits");
}

BasisCode::BasisCode(BasisBits& bits) {
    const uint32_t symbolCount = bits.Take(14);
    if (symbolCount == 0) return;  // never used
    const uint32_t lengthCount = bits.Take(5);
    if (lengthCount == 0 || lengthCount > kLengthSymbols) bits.Fail("has a malformed code");
    std::array<uint8_t, kLengthSymbols> lengthsOfLengths = {};
    for (uint32_t i = 0; i < lengthCount; ++i)
        lengthsOfLengths[kOrder[i]] = static_cast<uint8_t>(bits.Take(3));
    const BasisCode lengthCode(lengthsOfLengths, bits);
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
// code may have words to spare, as one of a single symbol has.
void BasisCode::Build(std::span<const uint8_t> lengths, BasisBits& bits) {
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

// ETC1S with BasisLZ, the small encoding of KHR_texture_basisu: blocks that share a palette of colors and
// one of patterns; and the reader of its bits, after the KTX File Format Specification 2.0, appendix
// "BasisLZ/ETC1S Bitstream Specification". Private to renderer/image. Threads: any; a BitReader: one at a
// time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/image/ktx2_header.h"

namespace raygraph::image {

// Returns the RGB of the first slice, and the alpha of the second one or 255, exact to the bit. Frames that
// refer to others are refused: a texture has none.
Image8 DecodeBasisLz(const Ktx2Header& header, std::string_view name);

// BitReader reads bits, from the lowest of the first byte upwards. Reading beyond the end is refused.
class BitReader {
  public:
    // `part` is the name of these bits in messages.
    BitReader(std::span<const std::byte> bytes, std::string_view name, const char* part)
        : m_bytes(bytes), m_name(name), m_part(part) {}

    // Returns the next 0 to 16 bits.
    uint32_t Take(unsigned count) {
        const uint32_t value = Peek() & ((1u << count) - 1);
        Skip(count);
        return value;
    }
    // Returns at least the next 16 bits, the first one lowest; zeros after the end.
    uint32_t Peek() {
        while (m_count < 16 && m_next < m_bytes.size()) {
            m_bits |= std::to_integer<uint32_t>(m_bytes[m_next++]) << m_count;
            m_count += 8;
        }
        return m_bits;
    }
    void Skip(unsigned count) {
        if (count > m_count) Fail("is truncated");
        m_bits >>= count;
        m_count -= count;
    }
    // Returns a number in chunks of so many bits, each with a bit above that says whether another one
    // follows.
    uint32_t TakeChunks(unsigned chunkBits);
    [[noreturn]] void Fail(const char* what) const;

  private:
    std::span<const std::byte> m_bytes;
    std::string_view m_name;
    const char* m_part;
    size_t m_next = 0;
    uint32_t m_bits = 0;
    unsigned m_count = 0;
};

// HuffmanCode is a canonical Huffman code of up to 16 bits a symbol, as in Deflate.
class HuffmanCode {
  public:
    // Reads the lengths of the code's words.
    explicit HuffmanCode(BitReader& bits);

    uint32_t Take(BitReader& bits) const {
        if (m_entries.empty()) bits.Fail("uses a code without symbols");
        const Entry entry = m_entries[bits.Peek() & (m_entries.size() - 1)];
        if (entry.length == 0) bits.Fail("has a word that its code lacks");
        bits.Skip(entry.length);
        return entry.symbol;
    }

  private:
    HuffmanCode(std::span<const uint8_t> lengths, BitReader& bits) { Build(lengths, bits); }
    void Build(std::span<const uint8_t> lengths, BitReader& bits);

    struct Entry {
        uint16_t symbol = 0;
        uint16_t length = 0;  // 0: there is no such word
    };
    std::vector<Entry> m_entries;  // indexed by as many bits as the longest word has
};

}  // namespace raygraph::image

// Writes blocks of compressed textures field by field.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "renderer/image/bc_blocks.h"

namespace raygraph::test {

// Writes fields from the lowest bit of the first byte upwards.
template <size_t byteCount>
class BlockWriter {
  public:
    BlockWriter& Put(uint64_t value, unsigned bitCount) {
        EXPECT_TRUE(bitCount == 64 || value >> bitCount == 0) << value << " in " << bitCount << " bits";
        for (unsigned i = 0; i < bitCount; ++i, ++m_bitCount) {
            if (m_bitCount == 8 * byteCount) {
                ADD_FAILURE() << "more than " << 8 * byteCount << " bits";
                return *this;
            }
            m_block[m_bitCount / 8] |= static_cast<std::byte>((value >> i & 1) << m_bitCount % 8);
        }
        return *this;
    }
    size_t BitCount() const { return m_bitCount; }
    std::span<const std::byte, byteCount> Block() const { return m_block; }

  private:
    std::array<std::byte, byteCount> m_block = {};
    size_t m_bitCount = 0;
};

using Color = std::array<int, 4>;

inline Color TexelOf(const image::BlockTexels& texels, size_t texel) {
    Color color;
    for (size_t c = 0; c < 4; ++c) color[c] = texels[4 * texel + c];
    return color;
}

// Extends `value` of `bits` bits to 8 bits by repeating its bits.
inline int Repeated(uint32_t value, unsigned bits) {
    int result = 0;
    for (unsigned i = 0; i < 8; ++i)
        result = 2 * result + static_cast<int>(value >> (bits - 1 - i % bits) & 1);
    return result;
}

}  // namespace raygraph::test

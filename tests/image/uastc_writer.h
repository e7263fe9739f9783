// Writes blocks of compressed textures field by field. Those of UASTC are decoded, too, by a second implementation of
// the Khronos Data Format Specification.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "renderer/image/bc_blocks.h"
#include "renderer/image/uastc_block.h"

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

struct UastcLayout {
    uint32_t code, codeBits;
    unsigned hintBits;
    unsigned parts, partBits;
    unsigned channels, planes;
    uint32_t base;  // 1: bits alone; 3, 5: with a trit or quint above them
    unsigned numberBits, weightBits;
};
// The layouts are by mode; the eighth is a single color. Hints: two of BC1 (modes 10 to 12: one), two flags
// and two tables of 3 bits of ETC1, 5 bits of ETC1's bias (not modes 10 to 12), and 8 bits of ETC2 (modes 9
// to 17).
inline constexpr std::array<UastcLayout, 19> kUastcLayouts{{
    {0b0001, 4, 2 + 8 + 5, 1, 0, 3, 1, 3, 6, 4},
    {0b110101, 6, 2 + 8 + 5, 1, 0, 3, 1, 1, 8, 2},
    {0b11101, 5, 2 + 8 + 5, 2, 5, 3, 1, 1, 4, 3},
    {0b00011, 5, 2 + 8 + 5, 3, 4, 3, 1, 3, 2, 2},
    {0b10011, 5, 2 + 8 + 5, 2, 5, 3, 1, 5, 3, 2},
    {0b01011, 5, 2 + 8 + 5, 1, 0, 3, 1, 1, 8, 3},
    {0b11011, 5, 2 + 8 + 5, 1, 0, 3, 2, 5, 5, 2},
    {0b00111, 5, 2 + 8 + 5, 2, 5, 3, 1, 5, 3, 2},
    {0b10111, 5, 0, 1, 0, 4, 1, 1, 8, 0},
    {0b01111, 5, 2 + 8 + 5 + 8, 2, 5, 4, 1, 1, 4, 2},
    {0b010, 3, 1 + 8 + 8, 1, 0, 4, 1, 3, 4, 4},
    {0b00, 2, 1 + 8 + 8, 1, 0, 4, 2, 3, 4, 2},
    {0b110, 3, 1 + 8 + 8, 1, 0, 4, 1, 3, 6, 3},
    {0b11111, 5, 2 + 8 + 5 + 8, 1, 0, 4, 2, 1, 8, 1},
    {0b01101, 5, 2 + 8 + 5 + 8, 1, 0, 4, 1, 1, 8, 2},
    {0b0000101, 7, 2 + 8 + 5 + 8, 1, 0, 2, 1, 1, 8, 4},
    {0b010101, 6, 2 + 8 + 5 + 8, 2, 5, 2, 1, 1, 8, 2},
    {0b100101, 6, 2 + 8 + 5 + 8, 1, 0, 2, 2, 1, 8, 2},
    {0b1001, 4, 2 + 8 + 5, 1, 0, 3, 1, 1, 5, 5},
}};

struct UastcBlock {
    size_t mode = 8;
    uint32_t part = 0, selector = 0, hints = 0;
    // Endpoints in the order of the file: part by part, channel by channel, low and high, with a trit or
    // quint above the bits. Mode 8 has the four channels.
    std::array<uint32_t, 18> numbers = {};
    std::array<std::array<uint32_t, 16>, 2> weights = {};  // by plane
};

inline unsigned UastcPartOf(const UastcBlock& block, size_t texel) {
    switch (kUastcLayouts[block.mode].parts) {
        case 2:
            return (block.mode == 7 ? image::uastc::kTwoPartsOfMode7[block.part]
                                    : image::uastc::kTwoParts[block.part]) >>
                       texel &
                   1;
        case 3:
            return image::uastc::kThreeParts[block.part] >> 2 * texel & 3;
        default:
            return 0;
    }
}
// Returns whether a texel is the first of its part, whose weight has one bit less.
inline bool IsUastcAnchor(const UastcBlock& block, size_t texel) {
    for (size_t i = 0; i < texel; ++i)
        if (UastcPartOf(block, i) == UastcPartOf(block, texel)) return false;
    return true;
}

// Packs the fields before the weights; `part` may be one that does not exist.
inline BlockWriter<16> PackEndpoints(const UastcBlock& block) {
    const UastcLayout& layout = kUastcLayouts[block.mode];
    BlockWriter<16> writer;
    writer.Put(layout.code, layout.codeBits);
    if (block.mode == 8) {
        for (size_t c = 0; c < 4; ++c) writer.Put(block.numbers[c], 8);
        return writer;
    }
    writer.Put(block.hints, layout.hintBits).Put(block.part, layout.partBits);
    if (layout.planes == 2 && layout.channels > 2) writer.Put(block.selector, 2);
    const size_t count = size_t{2} * layout.parts * layout.channels, inGroup = layout.base == 3 ? 5 : 3;
    for (size_t first = 0; layout.base > 1 && first < count; first += inGroup) {
        uint32_t group = 0, greatest = 0;
        for (size_t i = std::min(count, first + inGroup); i-- > first;) {
            group = group * layout.base + (block.numbers[i] >> layout.numberBits);
            greatest = greatest * layout.base + layout.base - 1;
        }
        unsigned bits = 0;
        while (greatest >> bits != 0) ++bits;
        writer.Put(group, bits);
    }
    for (size_t i = 0; i < count; ++i)
        writer.Put(block.numbers[i] & ((1u << layout.numberBits) - 1), layout.numberBits);
    return writer;
}

using UastcBytes = std::array<std::byte, 16>;

inline UastcBytes ToArray(const BlockWriter<16>& writer) {
    UastcBytes bytes;
    std::ranges::copy(writer.Block(), bytes.begin());
    return bytes;
}

inline UastcBytes PackAnyPart(const UastcBlock& block) {
    return ToArray(PackEndpoints(block));
}

inline UastcBytes Pack(const UastcBlock& block) {
    BlockWriter<16> writer = PackEndpoints(block);
    const UastcLayout& layout = kUastcLayouts[block.mode];
    for (size_t i = 0; i < 16 && block.mode != 8; ++i)
        for (size_t plane = 0; plane < layout.planes; ++plane)
            writer.Put(block.weights[plane][i], layout.weightBits - (IsUastcAnchor(block, i) ? 1 : 0));
    return ToArray(writer);
}

inline UastcBlock RandomUastcBlock(size_t mode, std::mt19937& random) {
    const auto below = [&](uint64_t count) { return static_cast<uint32_t>(random() % count); };
    const UastcLayout& layout = kUastcLayouts[mode];
    UastcBlock block{.mode = mode, .numbers = {}};
    block.hints = below(uint64_t{1} << layout.hintBits);
    if (layout.parts == 2)
        block.part =
            below(mode == 7 ? image::uastc::kTwoPartsOfMode7.size() : image::uastc::kTwoParts.size());
    if (layout.parts == 3) block.part = below(image::uastc::kThreeParts.size());
    block.selector = layout.planes == 2 && layout.channels > 2 ? below(4) : 3;
    for (uint32_t& number : block.numbers) number = below(layout.base << layout.numberBits);
    for (auto& plane : block.weights)
        for (size_t i = 0; i < 16 && mode != 8; ++i)
            plane[i] = below(uint64_t{1} << (layout.weightBits - (IsUastcAnchor(block, i) ? 1 : 0)));
    return block;
}

// Is ASTC's color unquantization by the specification's bit pattern: a letter is a bit of the number, from
// the second lowest (b) on.
inline int UastcNumber(const UastcLayout& layout, uint32_t number) {
    if (layout.base == 1) return Repeated(number, layout.numberBits);
    std::string pattern;
    uint32_t scale = 0;
    switch (layout.base << layout.numberBits) {
        case 12:
            pattern = "b000b0bb0", scale = 93;
            break;
        case 40:
            pattern = "cb0000cbc", scale = 26;
            break;
        case 48:
            pattern = "dcb000dcb", scale = 22;
            break;
        case 160:
            pattern = "edcb0000e", scale = 6;
            break;
        default:
            pattern = "fedcb000f", scale = 5;
            break;
    }
    uint32_t spread = 0;
    for (const char letter : pattern)
        spread = 2 * spread + (letter == '0' ? 0 : number >> (letter - 'a') & 1);
    const uint32_t flip = (number & 1) != 0 ? 0x1FF : 0;
    const uint32_t value = ((number >> layout.numberBits) * scale + spread) ^ flip;
    return static_cast<int>((flip & 0x80) | value >> 2);
}

// Returns 64ths: the bits repeated to 6 of them, and one more in the upper half.
inline int UastcWeight(uint32_t weight, unsigned bits) {
    const int value = Repeated(weight, bits) >> 2;
    return value > 32 ? value + 1 : value;
}

inline Color ExpectedTexel(const UastcBlock& block, size_t texel, bool isSrgb) {
    const UastcLayout& layout = kUastcLayouts[block.mode];
    Color color{0, 0, 0, 255};
    for (size_t c = 0; c < 4; ++c) {
        if (block.mode == 8) {
            color[c] = static_cast<int>(block.numbers[c]);
            continue;
        }
        // Three numbers are RGB, two luminance and alpha
        if (c == 3 && layout.channels == 3) continue;
        const size_t stored = layout.channels == 2 ? c / 3 : c;
        const size_t at = 2 * (UastcPartOf(block, texel) * layout.channels + stored);
        const int low = UastcNumber(layout, block.numbers[at]),
                  high = UastcNumber(layout, block.numbers[at + 1]);
        const size_t chosen = layout.channels == 2 ? 3 : block.selector;
        const size_t plane = layout.planes == 2 && c == chosen ? 1 : 0;
        const int weight = UastcWeight(block.weights[plane][texel], layout.weightBits);
        const auto wide = [&](int value) { return isSrgb ? 256 * value + 128 : 257 * value; };
        color[c] = (wide(low) * (64 - weight) + wide(high) * weight + 32) / 64 / 256;
    }
    return color;
}

}  // namespace raygraph::test

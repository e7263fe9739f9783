// UASTC LDR 4x4, the high-quality encoding of KHR_texture_basisu: a subset of ASTC in blocks of its own,
// after the Khronos Data Format Specification 1.4, chapter UASTC. Private to renderer/image. Threads: any.
#pragma once

#include <array>
#include <cstdint>

#include "renderer/image/bc_blocks.h"

namespace raygraph::image {

// Decodes a block, exact to the bit. `isSrgb` says that the texels are sRGB, which changes the rounding of
// halves, as on GPUs that decode ASTC. Returns false for a block that is not of the format.
[[nodiscard]] bool DecodeUastc(std::span<const std::byte, 16> block, bool isSrgb, BlockTexels& texels);

}  // namespace raygraph::image

namespace raygraph::image::uastc {

// --- The division of blocks into parts that have their own colors: the tables of the specification ---

// The division's number in the block is the index. An element has the part of each texel, one bit each, the
// first texel's the lowest. This is for modes 2, 4, 9 and 16; the next table is for mode 7.
inline constexpr std::array<uint16_t, 30> kTwoParts{
    0xCCCC, 0x8888, 0x1111, 0xECC8, 0x377F, 0xFEEC, 0x0137, 0x137F, 0xC800, 0x0013,
    0xFE80, 0x17FF, 0x0017, 0x00FF, 0xFFF0, 0x0FFF, 0xFF71, 0x8EFF, 0x08CE, 0x008C,
    0x7310, 0xCEFF, 0x7331, 0x088C, 0xCEEF, 0x6666, 0xF00F, 0x5555, 0x0F0F, 0x36C9,
};
inline constexpr std::array<uint16_t, 19> kTwoPartsOfMode7{
    0x00F0, 0x4444, 0x0133, 0xCC80, 0xF0FF, 0x2222, 0xFFC8, 0xCCCE, 0x3C03, 0x00EE,
    0x7700, 0x3003, 0x00CE, 0xFF80, 0x6FFF, 0x1333, 0x11FF, 0x136C, 0x00EF,
};
// An element has two bits for each texel.
inline constexpr std::array<uint32_t, 11> kThreeParts{
    0xA5A50000, 0xAA005555, 0xAA000055, 0x0000AA55, 0x25252525, 0x94949494,
    0x58585858, 0x56560202, 0x92929292, 0x55AA0055, 0xA05050A0,
};

}  // namespace raygraph::image::uastc

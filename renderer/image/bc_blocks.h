// BC1 to BC5 and BC7, the block compression of desktop GPUs, a block of 4 x 4 texels at a time, after the
// Khronos Data Format Specification 1.4, chapters S3TC, RGTC and BPTC. Private to renderer/image. Threads:
// any.
//
// Every block is a picture, so nothing here fails. BC1 to BC5 are fractions by the specification, and
// rounded to the nearest number of 8 bits; BC7 is exact, bit for bit.
#pragma once

#include "renderer/image/block_bits.h"

namespace raygraph::image {

// The fourth color of a block whose first one is not the greater number: transparent black, or opaque.
enum class Bc1Alpha : bool { None, PunchThrough };
void DecodeBc1(std::span<const std::byte, 8> block, Bc1Alpha alpha, BlockTexels& texels);
void DecodeBc2(std::span<const std::byte, 16> block, BlockTexels& texels);
void DecodeBc3(std::span<const std::byte, 16> block, BlockTexels& texels);
// Give (R, 0, 0, 1) and (R, G, 0, 1), as GPUs sample them.
void DecodeBc4(std::span<const std::byte, 8> block, BlockTexels& texels);
void DecodeBc5(std::span<const std::byte, 16> block, BlockTexels& texels);
// A block of the reserved mode is transparent black.
void DecodeBc7(std::span<const std::byte, 16> block, BlockTexels& texels);

}  // namespace raygraph::image

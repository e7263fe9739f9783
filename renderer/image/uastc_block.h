// UASTC LDR 4x4, the high-quality encoding of KHR_texture_basisu: a subset of ASTC in blocks of its own,
// after the Khronos Data Format Specification 1.4, chapter UASTC. Private to renderer/image. Threads: any.
#pragma once

#include "renderer/image/block_bits.h"

namespace raygraph::image {

// Decodes a block, exact to the bit. `isSrgb` says that the texels are sRGB, which changes the rounding of
// halves, as on GPUs that decode ASTC. Returns false for a block that is not of the format.
[[nodiscard]] bool DecodeUastc(std::span<const std::byte, 16> block, bool isSrgb, BlockTexels& texels);

}  // namespace raygraph::image

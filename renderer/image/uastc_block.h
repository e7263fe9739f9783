// UASTC LDR 4x4, what KHR_texture_basisu stores of high quality: a subset of ASTC in blocks of its own,
// after the Khronos Data Format Specification 1.4, chapter UASTC. Private to renderer/image. Threads: any.
#pragma once

#include "renderer/image/block_bits.h"

namespace raygraph::image {

// Exact, bit for bit. `isSrgb`: the texels are sRGB, which changes how halves are rounded as it does on GPUs
// that decode ASTC. False: the block is none of the format's.
[[nodiscard]] bool DecodeUastc(std::span<const std::byte, 16> block, bool isSrgb, BlockTexels& texels);

}  // namespace raygraph::image

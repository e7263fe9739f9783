// The texel formats of Raygraph, and the corresponding VkFormats. Threads: plain values and pure functions,
// for any thread.
#pragma once

#include <cstdint>

#include "base/api.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

enum class Format : uint8_t {
    Undefined,
    R8Unorm,
    Rg8Unorm,
    Rgba8Unorm,
    Rgba8Srgb,
    Bgra8Unorm,
    Bgra8Srgb,
    Rgba16Unorm,
    R16Float,
    Rgba16Float,
    R32Uint,
    Rg32Uint,
    Rgba32Uint,
    R32Float,
    Rg32Float,
    Rgba32Float,
    D32Float,
    // Blocks of 4 x 4 texels that can only be sampled, on devices with
    // OptionalFeatures::textureCompressionBc.
    Bc1Unorm,  // without alpha
    Bc1Srgb,
    Bc1AlphaUnorm,
    Bc1AlphaSrgb,
    Bc2Unorm,
    Bc2Srgb,
    Bc3Unorm,
    Bc3Srgb,
    Bc4Unorm,
    Bc5Unorm,
    Bc7Unorm,
    Bc7Srgb,
};
constexpr uint32_t kFormatCount = static_cast<uint32_t>(Format::Bc7Srgb) + 1;

RAYGRAPH_API VkFormat ToVk(Format format);
// Returns Undefined for a VkFormat that has no Format.
RAYGRAPH_API Format FormatFromVk(VkFormat format);
// Returns the bytes of one texel, or of one block; 0 for Undefined.
RAYGRAPH_API uint32_t TexelBytes(Format format);
// Returns the texels per side of the unit of TexelBytes: 4 for block formats, otherwise 1.
RAYGRAPH_API uint32_t BlockSide(Format format);
// Returns text such as "rgba32f" or "rgba8-srgb", for plan text, labels and errors.
RAYGRAPH_API const char* Name(Format format);
RAYGRAPH_API bool IsDepth(Format format);
RAYGRAPH_API bool IsUint(Format format);

struct Extent2D {
    uint32_t width = 0;
    uint32_t height = 0;

    bool operator==(const Extent2D&) const = default;
    bool IsEmpty() const { return width == 0 || height == 0; }
};

// Returns the columns and rows of blocks that cover the extent; a format without blocks has one texel per
// block.
RAYGRAPH_API Extent2D BlockCounts(Format format, Extent2D extent);
// Returns the bytes of an image of that extent, without padding.
RAYGRAPH_API uint64_t ImageBytes(Format format, Extent2D extent);

// Returns the size of a mip level: halved and rounded down `level` times (level < 32), at least 1.
RAYGRAPH_API Extent2D MipExtent(Extent2D extent, uint32_t level);
// Returns the number of levels down to 1x1; 0 for an extent of 0x0.
RAYGRAPH_API uint32_t FullMipCount(Extent2D extent);

}  // namespace raygraph::rhi

#include "rhi/format.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

namespace raygraph::rhi {
namespace {

struct FormatRow {
    Format format;
    VkFormat vk;
    uint32_t bytes;
    const char* name;
};

// The formats in the order of the enumeration.
constexpr std::array kFormats{
    FormatRow{Format::Undefined, VK_FORMAT_UNDEFINED, 0, "undefined"},
    FormatRow{Format::R8Unorm, VK_FORMAT_R8_UNORM, 1, "r8"},
    FormatRow{Format::Rg8Unorm, VK_FORMAT_R8G8_UNORM, 2, "rg8"},
    FormatRow{Format::Rgba8Unorm, VK_FORMAT_R8G8B8A8_UNORM, 4, "rgba8"},
    FormatRow{Format::Rgba8Srgb, VK_FORMAT_R8G8B8A8_SRGB, 4, "rgba8-srgb"},
    FormatRow{Format::Bgra8Unorm, VK_FORMAT_B8G8R8A8_UNORM, 4, "bgra8"},
    FormatRow{Format::Bgra8Srgb, VK_FORMAT_B8G8R8A8_SRGB, 4, "bgra8-srgb"},
    FormatRow{Format::Rgba16Unorm, VK_FORMAT_R16G16B16A16_UNORM, 8, "rgba16"},
    FormatRow{Format::R16Float, VK_FORMAT_R16_SFLOAT, 2, "r16f"},
    FormatRow{Format::Rgba16Float, VK_FORMAT_R16G16B16A16_SFLOAT, 8, "rgba16f"},
    FormatRow{Format::R32Uint, VK_FORMAT_R32_UINT, 4, "r32ui"},
    FormatRow{Format::Rg32Uint, VK_FORMAT_R32G32_UINT, 8, "rg32ui"},
    FormatRow{Format::Rgba32Uint, VK_FORMAT_R32G32B32A32_UINT, 16, "rgba32ui"},
    FormatRow{Format::R32Float, VK_FORMAT_R32_SFLOAT, 4, "r32f"},
    FormatRow{Format::Rg32Float, VK_FORMAT_R32G32_SFLOAT, 8, "rg32f"},
    FormatRow{Format::Rgba32Float, VK_FORMAT_R32G32B32A32_SFLOAT, 16, "rgba32f"},
    FormatRow{Format::D32Float, VK_FORMAT_D32_SFLOAT, 4, "d32f"},
    FormatRow{Format::Bc1Unorm, VK_FORMAT_BC1_RGB_UNORM_BLOCK, 8, "bc1"},
    FormatRow{Format::Bc1Srgb, VK_FORMAT_BC1_RGB_SRGB_BLOCK, 8, "bc1-srgb"},
    FormatRow{Format::Bc1AlphaUnorm, VK_FORMAT_BC1_RGBA_UNORM_BLOCK, 8, "bc1-alpha"},
    FormatRow{Format::Bc1AlphaSrgb, VK_FORMAT_BC1_RGBA_SRGB_BLOCK, 8, "bc1-alpha-srgb"},
    FormatRow{Format::Bc2Unorm, VK_FORMAT_BC2_UNORM_BLOCK, 16, "bc2"},
    FormatRow{Format::Bc2Srgb, VK_FORMAT_BC2_SRGB_BLOCK, 16, "bc2-srgb"},
    FormatRow{Format::Bc3Unorm, VK_FORMAT_BC3_UNORM_BLOCK, 16, "bc3"},
    FormatRow{Format::Bc3Srgb, VK_FORMAT_BC3_SRGB_BLOCK, 16, "bc3-srgb"},
    FormatRow{Format::Bc4Unorm, VK_FORMAT_BC4_UNORM_BLOCK, 8, "bc4"},
    FormatRow{Format::Bc5Unorm, VK_FORMAT_BC5_UNORM_BLOCK, 16, "bc5"},
    FormatRow{Format::Bc7Unorm, VK_FORMAT_BC7_UNORM_BLOCK, 16, "bc7"},
    FormatRow{Format::Bc7Srgb, VK_FORMAT_BC7_SRGB_BLOCK, 16, "bc7-srgb"},
};

constexpr bool IsInOrder() {
    for (size_t i = 0; i < kFormats.size(); ++i)
        if (static_cast<size_t>(kFormats[i].format) != i) return false;
    return kFormats.size() == kFormatCount;
}
static_assert(IsInOrder());

const FormatRow& Row(Format format) {
    return kFormats[static_cast<size_t>(format)];
}

}  // namespace

VkFormat ToVk(Format format) {
    return Row(format).vk;
}

Format FormatFromVk(VkFormat format) {
    const auto row =
        std::find_if(kFormats.begin(), kFormats.end(), [&](const FormatRow& r) { return r.vk == format; });
    return row == kFormats.end() ? Format::Undefined : row->format;
}

uint32_t TexelBytes(Format format) {
    return Row(format).bytes;
}

uint32_t BlockSide(Format format) {
    return format >= Format::Bc1Unorm ? 4 : 1;
}

const char* Name(Format format) {
    return Row(format).name;
}

bool IsDepth(Format format) {
    return format == Format::D32Float;
}

bool IsUint(Format format) {
    return format == Format::R32Uint || format == Format::Rg32Uint || format == Format::Rgba32Uint;
}

Extent2D BlockCounts(Format format, Extent2D extent) {
    const uint32_t side = BlockSide(format);
    return {(extent.width + side - 1) / side, (extent.height + side - 1) / side};
}

uint64_t ImageBytes(Format format, Extent2D extent) {
    const Extent2D blocks = BlockCounts(format, extent);
    return uint64_t{blocks.width} * blocks.height * TexelBytes(format);
}

Extent2D MipExtent(Extent2D extent, uint32_t level) {
    return {std::max(extent.width >> level, 1u), std::max(extent.height >> level, 1u)};
}

uint32_t FullMipCount(Extent2D extent) {
    return static_cast<uint32_t>(std::bit_width(std::max(extent.width, extent.height)));
}

}  // namespace raygraph::rhi

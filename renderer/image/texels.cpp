#include "renderer/image/texels.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "base/text.h"
#include "renderer/image/bc_blocks.h"
#include "renderer/image/decode.h"
#include "renderer/image/uastc_block.h"

namespace raygraph::image {
namespace {

uint32_t BlockBytes(TexelCoding coding) {
    const bool isSmall =
        coding == TexelCoding::Bc1Opaque || coding == TexelCoding::Bc1 || coding == TexelCoding::Bc4;
    return isSmall ? 8 : 16;
}

uint64_t BlockCount(uint32_t extent) {
    return (uint64_t{extent} + 3) / 4;
}

// Returns false if the block is not of the coding.
bool DecodeBlock(TexelCoding coding, std::span<const std::byte> bytes, BlockTexels& texels) {
    const auto half = [&] { return bytes.first<8>(); };
    const auto whole = [&] { return bytes.first<16>(); };
    switch (coding) {
        case TexelCoding::Bc1Opaque:
            DecodeBc1(half(), Bc1Alpha::None, texels);
            return true;
        case TexelCoding::Bc1:
            DecodeBc1(half(), Bc1Alpha::PunchThrough, texels);
            return true;
        case TexelCoding::Bc2:
            DecodeBc2(whole(), texels);
            return true;
        case TexelCoding::Bc3:
            DecodeBc3(whole(), texels);
            return true;
        case TexelCoding::Bc4:
            DecodeBc4(half(), texels);
            return true;
        case TexelCoding::Bc5:
            DecodeBc5(whole(), texels);
            return true;
        case TexelCoding::Bc7:
            DecodeBc7(whole(), texels);
            return true;
        case TexelCoding::Uastc:
            return DecodeUastc(whole(), false, texels);
        case TexelCoding::UastcSrgb:
            return DecodeUastc(whole(), true, texels);
        case TexelCoding::Plain:
            break;
    }
    return false;
}

void DecodePlain(const TexelLayout& layout, std::span<const std::byte> bytes, Image8& image) {
    for (size_t i = 0, at = 0; i < image.rgba.size(); i += 4, at += layout.texelBytes) {
        for (size_t c = 0; c < 4; ++c) {
            const Source source = layout.bytes[c];
            image.rgba[i + c] = source == Source::Zero ? 0
                                : source == Source::One
                                    ? 255
                                    : std::to_integer<uint8_t>(bytes[at + static_cast<size_t>(source)]);
        }
    }
}

void DecodeBlocks(TexelCoding coding, std::span<const std::byte> bytes, Image8& image,
                  std::string_view name) {
    const uint32_t blockBytes = BlockBytes(coding);
    BlockTexels texels;
    for (uint32_t y = 0; y < image.height; y += 4) {
        for (uint32_t x = 0; x < image.width; x += 4, bytes = bytes.subspan(blockBytes)) {
            if (!DecodeBlock(coding, bytes, texels))
                Reject(name, Text("the block at ({}, {}) is invalid", x, y));
            const size_t rowBytes = 4 * std::min<size_t>(4, image.width - x);
            for (uint32_t row = 0; row < std::min(4u, image.height - y); ++row)
                std::memcpy(image.rgba.data() + 4 * ((size_t{y} + row) * image.width + x),
                            texels.data() + size_t{16} * row, rowBytes);
        }
    }
}

}  // namespace

BlockCoding CodingOf(const TexelLayout& layout) {
    switch (layout.coding) {
        case TexelCoding::Bc1Opaque:
            return BlockCoding::Bc1Opaque;
        case TexelCoding::Bc1:
            return BlockCoding::Bc1;
        case TexelCoding::Bc2:
            return BlockCoding::Bc2;
        case TexelCoding::Bc3:
            return BlockCoding::Bc3;
        case TexelCoding::Bc4:
            return BlockCoding::Bc4;
        case TexelCoding::Bc5:
            return BlockCoding::Bc5;
        case TexelCoding::Bc7:
            return BlockCoding::Bc7;
        case TexelCoding::Plain:
        case TexelCoding::Uastc:
        case TexelCoding::UastcSrgb:
            break;
    }
    return BlockCoding::None;
}

uint64_t BlockBytes(BlockCoding coding, uint32_t width, uint32_t height) {
    const bool isSmall =
        coding == BlockCoding::Bc1Opaque || coding == BlockCoding::Bc1 || coding == BlockCoding::Bc4;
    return (isSmall ? 8 : 16) * BlockCount(width) * BlockCount(height);
}

uint64_t StoredBytes(const TexelLayout& layout, uint32_t width, uint32_t height) {
    if (layout.coding == TexelCoding::Plain) return uint64_t{layout.texelBytes} * width * height;
    return BlockBytes(layout.coding) * BlockCount(width) * BlockCount(height);
}

Image8 DecodeTexels(const TexelLayout& layout, std::span<const std::byte> bytes, uint32_t width,
                    uint32_t height, std::string_view name) {
    try {
        Image8 image{width, height, std::vector<uint8_t>(size_t{4} * width * height)};
        if (layout.coding == TexelCoding::Plain) {
            DecodePlain(layout, bytes, image);
        } else {
            DecodeBlocks(layout.coding, bytes, image, name);
        }
        return image;
    } catch (const std::bad_alloc&) {
        RejectMemory(name, width, height);
    }
}

void Apply(const Swizzle& swizzle, Image8& image) {
    if (swizzle == kIdentity) return;
    for (size_t i = 0; i < image.rgba.size(); i += 4) {
        const std::array<uint8_t, 6> values{
            image.rgba[i], image.rgba[i + 1], image.rgba[i + 2], image.rgba[i + 3], 0, 255};
        for (size_t c = 0; c < 4; ++c) image.rgba[i + c] = values[static_cast<size_t>(swizzle[c])];
    }
}

}  // namespace raygraph::image

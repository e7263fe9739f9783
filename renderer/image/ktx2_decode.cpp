// KTX2, Khronos' container of textures: the largest level of a 2D texture, plain, in blocks, or as Basis
// Universal (KHR_texture_basisu); of blocks that GPUs read, all levels.
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>
#include <optional>

#include "base/text.h"
#include "renderer/image/basis_lz.h"
#include "renderer/image/decode.h"
#include "renderer/image/ktx2_header.h"

namespace raygraph::image {
namespace {

struct NumberedLayout {
    uint32_t format;
    TexelLayout layout;
};

// Vulkan's numbers of formats. A format and its sRGB version have the same layout: the use of a texture
// decides whether its numbers are sRGB.
constexpr std::array kLayouts{
    NumberedLayout{9, {TexelCoding::Plain, 1, kOnlyRed}},
    NumberedLayout{15, {TexelCoding::Plain, 1, kOnlyRed}},
    NumberedLayout{16, {TexelCoding::Plain, 2, kRedGreen}},
    NumberedLayout{22, {TexelCoding::Plain, 2, kRedGreen}},
    NumberedLayout{23, {TexelCoding::Plain, 3, kOpaque}},
    NumberedLayout{29, {TexelCoding::Plain, 3, kOpaque}},
    NumberedLayout{30, {TexelCoding::Plain, 3, kBgrx}},
    NumberedLayout{36, {TexelCoding::Plain, 3, kBgrx}},
    NumberedLayout{37, {TexelCoding::Plain, 4, kIdentity}},
    NumberedLayout{43, {TexelCoding::Plain, 4, kIdentity}},
    NumberedLayout{44, {TexelCoding::Plain, 4, kBgra}},
    NumberedLayout{50, {TexelCoding::Plain, 4, kBgra}},
    NumberedLayout{131, {TexelCoding::Bc1Opaque}},
    NumberedLayout{132, {TexelCoding::Bc1Opaque}},
    NumberedLayout{133, {TexelCoding::Bc1}},
    NumberedLayout{134, {TexelCoding::Bc1}},
    NumberedLayout{135, {TexelCoding::Bc2}},
    NumberedLayout{136, {TexelCoding::Bc2}},
    NumberedLayout{137, {TexelCoding::Bc3}},
    NumberedLayout{138, {TexelCoding::Bc3}},
    NumberedLayout{139, {TexelCoding::Bc4}},
    NumberedLayout{141, {TexelCoding::Bc5}},
    NumberedLayout{145, {TexelCoding::Bc7}},
    NumberedLayout{146, {TexelCoding::Bc7}},
};

TexelLayout LayoutOf(const Ktx2Header& header, std::string_view name) {
    if (header.vkFormat == 0)
        return {.coding = header.basis.isSrgb ? TexelCoding::UastcSrgb : TexelCoding::Uastc};
    const auto found = std::ranges::find(kLayouts, header.vkFormat, &NumberedLayout::format);
    if (found == kLayouts.end())
        Refuse(name, Text("KTX2: the Vulkan format {} is not supported", header.vkFormat));
    return found->layout;
}

// Memory that is not touched before something is written to it.
struct Inflated {
    std::unique_ptr<std::byte[]> memory;
    size_t size = 0;
};

Inflated Inflate(const Ktx2Header& header, std::span<const std::byte> stored, uint64_t bytes,
                 std::string_view name) {
    // A block of Zstandard has 4 bytes or more, and becomes 128 KiB at most.
    constexpr uint64_t kMaxRatio = (uint64_t{128} << 10) / 4;
    if (bytes > stored.size() * kMaxRatio) {
        Refuse(name, Text("KTX2: {} bytes of Zstandard cannot hold {} x {} pixels", stored.size(),
                          header.width, header.height));
    }
    Inflated inflated;
    try {
        inflated = {std::unique_ptr<std::byte[]>(new std::byte[bytes]), bytes};
    } catch (const std::bad_alloc&) {
        RefuseMemory(name, header.width, header.height);
    }
    const size_t done = ZSTD_decompress(inflated.memory.get(), bytes, stored.data(), stored.size());
    if (ZSTD_isError(done) != 0) Refuse(name, Text("KTX2: Zstandard: {}", ZSTD_getErrorName(done)));
    if (done != bytes)
        Refuse(name, Text("KTX2: Zstandard: {} bytes came out, {} were expected", done, bytes));
    return inflated;
}

// Returns the blocks as the file has them, if no swizzle comes between them and the picture. `largest` is the
// inflated level 0.
BlockLevels Blocks(const Ktx2Header& header, const TexelLayout& layout, std::span<const std::byte> largest,
                   std::string_view name) {
    BlockLevels blocks{.coding = CodingOf(layout), .levels = {}};
    if (header.swizzle.value_or(kIdentity) != kIdentity) blocks.coding = BlockCoding::None;
    if (blocks.coding == BlockCoding::None) return blocks;
    blocks.levels.emplace_back(largest.begin(), largest.end());
    uint32_t width = header.width, height = header.height;
    for (const Ktx2Header::StoredLevel& level : header.smaller) {
        if (width == 1 && height == 1) break;
        width = std::max(width / 2, 1u);
        height = std::max(height / 2, 1u);
        const uint64_t wanted = StoredBytes(layout, width, height);
        const bool isInflated = header.supercompression == Supercompression::Zstd;
        if ((isInflated ? level.inflatedBytes : level.bytes.size()) != wanted) break;
        Inflated inflated;
        std::span<const std::byte> texels = level.bytes;
        if (isInflated) {
            inflated = Inflate(header, level.bytes, wanted, name);
            texels = {inflated.memory.get(), inflated.size};
        }
        blocks.levels.emplace_back(texels.begin(), texels.end());
    }
    return blocks;
}

Image8 DecodeStored(const Ktx2Header& header, std::string_view name) {
    const TexelLayout layout = LayoutOf(header, name);
    const uint64_t stored = StoredBytes(layout, header.width, header.height);
    const bool isInflated = header.supercompression == Supercompression::Zstd;
    const uint64_t there = isInflated ? header.inflatedBytes : header.level.size();
    if (there != stored) {
        Refuse(name, Text("KTX2: {} x {} pixels need {} bytes, and the largest level has {}", header.width,
                          header.height, stored, there));
    }
    Inflated inflated;
    std::span<const std::byte> texels = header.level;
    if (isInflated) {
        inflated = Inflate(header, header.level, stored, name);
        texels = {inflated.memory.get(), inflated.size};
    }
    Image8 image = DecodeTexels(layout, texels, header.width, header.height, name);
    image.blocks = Blocks(header, layout, texels.first(stored), name);
    return image;
}

}  // namespace

Image8 DecodeKtx2(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    const Ktx2Header header = ReadKtx2Header(bytes, name, limits);
    const bool isEtc1s = header.vkFormat == 0 && !header.basis.isUastc;
    if (isEtc1s != (header.supercompression == Supercompression::BasisLz))
        Refuse(name, "KTX2: ETC1S and BasisLZ go together, and this file has one of them");
    Image8 image = isEtc1s ? DecodeBasisLz(header, name) : DecodeStored(header, name);
    const Swizzle channels = header.vkFormat == 0 ? header.basis.channels : kIdentity;
    Apply(header.swizzle.value_or(channels), image);
    return image;
}

}  // namespace raygraph::image

// DDS, DirectX's container of textures, after Microsoft's "Programming Guide for DDS" and "DDS_HEADER": the
// largest level of a single 2D picture, and all levels of one in blocks.
#include <algorithm>
#include <optional>
#include <string>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/image/bc_blocks.h"
#include "renderer/image/decode.h"
#include "renderer/image/texels.h"

namespace raygraph::image {
namespace {

// These are offsets from the start of the file, whose first four bytes are "DDS ".
constexpr size_t kDdsBytes = 128, kHeaderBytesDx10 = 148;
constexpr size_t kHeaderSizeAt = 4, kDdsHeight = 12, kDdsWidth = 16, kLevelCountAt = 28, kFormatSizeAt = 76,
                 kFormatFlagsAt = 80;
constexpr size_t kFourCcAt = 84, kBitCountAt = 88, kMasksAt = 92, kCaps2At = 112;
constexpr size_t kDxgiFormatAt = 128, kDimensionAt = 132, kMiscFlagsAt = 136, kArraySizeAt = 140,
                 kMiscFlags2At = 144;

// DDS_PIXELFORMAT has these flags: alpha beside color, a name instead of masks, RGB, luminance.
constexpr uint32_t kHasAlpha = 0x1, kHasFourCc = 0x4, kIsRgb = 0x40, kIsLuminance = 0x20000;
// The fields dwCaps2 and those of DDS_HEADER_DXT10 have these values.
constexpr uint32_t kIsCube = 0x200, kIsVolume = 0x200000;
constexpr uint32_t kTexture2d = 3, kIsCubeDx10 = 0x4, kPremultipliedDx10 = 2;

constexpr uint32_t FourCc(const char (&text)[5]) {
    uint32_t code = 0;
    for (size_t i = 0; i < 4; ++i) code |= static_cast<uint32_t>(static_cast<uint8_t>(text[i])) << (8 * i);
    return code;
}

struct NamedLayout {
    uint32_t name;
    TexelLayout layout;
};

constexpr TexelLayout Coded(TexelCoding coding) {
    return {.coding = coding};
}

// A format and its sRGB version have the same layout: the use of a texture decides whether its numbers are
// sRGB.
constexpr std::array kFourCcs{
    NamedLayout{FourCc("DXT1"), Coded(TexelCoding::Bc1)},
    NamedLayout{FourCc("DXT3"), Coded(TexelCoding::Bc2)},
    NamedLayout{FourCc("DXT5"), Coded(TexelCoding::Bc3)},
    NamedLayout{FourCc("ATI1"), Coded(TexelCoding::Bc4)},
    NamedLayout{FourCc("BC4U"), Coded(TexelCoding::Bc4)},
    NamedLayout{FourCc("ATI2"), Coded(TexelCoding::Bc5)},
    NamedLayout{FourCc("BC5U"), Coded(TexelCoding::Bc5)},
};

constexpr std::array kDxgiFormats{
    NamedLayout{28, {TexelCoding::Plain, 4, kIdentity}},
    NamedLayout{29, {TexelCoding::Plain, 4, kIdentity}},
    NamedLayout{49, {TexelCoding::Plain, 2, kRedGreen}},
    NamedLayout{61, {TexelCoding::Plain, 1, kOnlyRed}},
    NamedLayout{87, {TexelCoding::Plain, 4, kBgra}},
    NamedLayout{91, {TexelCoding::Plain, 4, kBgra}},
    NamedLayout{88, {TexelCoding::Plain, 4, kBgrx}},
    NamedLayout{93, {TexelCoding::Plain, 4, kBgrx}},
    NamedLayout{71, Coded(TexelCoding::Bc1)},
    NamedLayout{72, Coded(TexelCoding::Bc1)},
    NamedLayout{74, Coded(TexelCoding::Bc2)},
    NamedLayout{75, Coded(TexelCoding::Bc2)},
    NamedLayout{77, Coded(TexelCoding::Bc3)},
    NamedLayout{78, Coded(TexelCoding::Bc3)},
    NamedLayout{80, Coded(TexelCoding::Bc4)},
    NamedLayout{83, Coded(TexelCoding::Bc5)},
    NamedLayout{98, Coded(TexelCoding::Bc7)},
    NamedLayout{99, Coded(TexelCoding::Bc7)},
};

std::optional<TexelLayout> Find(std::span<const NamedLayout> layouts, uint32_t name) {
    const auto found = std::ranges::find(layouts, name, &NamedLayout::name);
    return found == layouts.end() ? std::nullopt : std::optional(found->layout);
}

class DdsReader {
  public:
    DdsReader(std::span<const std::byte> bytes, std::string_view name) : m_bytes(bytes), m_name(name) {}

    Image8 Decode(const DecodeLimits& limits) {
        Require(kDdsBytes);
        if (At(kHeaderSizeAt) != kDdsBytes - 4 || At(kFormatSizeAt) != 32) Fail("the header is malformed");
        const uint32_t width = At(kDdsWidth), height = At(kDdsHeight);
        CheckSize(m_name, width, height, limits);
        if ((At(kCaps2At) & kIsCube) != 0) Fail("cube maps are not supported");
        if ((At(kCaps2At) & kIsVolume) != 0) Fail("volumes are not supported");
        const TexelLayout layout = Layout();
        const uint64_t stored = StoredBytes(layout, width, height);
        const std::span<const std::byte> texels = m_bytes.subspan(m_headerBytes);
        if (stored > texels.size()) {
            Fail(
                Text("{} x {} pixels need {} bytes, and there are {}", width, height, stored, texels.size()));
        }
        Image8 image = DecodeTexels(layout, texels, width, height, m_name);
        image.blocks = Blocks(layout, texels, width, height);
        return image;
    }

  private:
    // Returns one level after the other, as many as the file has.
    BlockLevels Blocks(const TexelLayout& layout, std::span<const std::byte> texels, uint32_t width,
                       uint32_t height) const {
        BlockLevels blocks{.coding = CodingOf(layout), .levels = {}};
        if (blocks.coding == BlockCoding::None) return blocks;
        for (uint32_t level = 0; level < std::max(At(kLevelCountAt), 1u); ++level) {
            const uint64_t bytes = StoredBytes(layout, width, height);
            if (bytes > texels.size()) break;
            const std::span<const std::byte> stored = texels.first(bytes);
            blocks.levels.emplace_back(stored.begin(), stored.end());
            texels = texels.subspan(bytes);
            if (width == 1 && height == 1) break;
            width = std::max(width / 2, 1u);
            height = std::max(height / 2, 1u);
        }
        return blocks;
    }

    [[noreturn]] void Fail(const std::string& what) const { Reject(m_name, "DDS: " + what); }
    void Require(size_t bytes) const {
        if (m_bytes.size() < bytes) Fail("the file is truncated");
    }
    uint32_t At(size_t offset) const { return Little32(m_bytes, offset); }

    TexelLayout Layout() {
        if ((At(kFormatFlagsAt) & kHasFourCc) == 0) return LayoutOfMasks();
        const uint32_t code = At(kFourCcAt);
        if (code == FourCc("DX10")) return LayoutDx10();
        if (code == FourCc("DXT2") || code == FourCc("DXT4")) Fail("premultiplied alpha is not supported");
        if (const auto layout = Find(kFourCcs, code)) return *layout;
        std::string text;
        for (size_t i = 0; i < 4; ++i) text += static_cast<char>(code >> (8 * i) & 0xFF);
        Fail(Text("the format {} is not supported", Quoted(text)));
    }

    TexelLayout LayoutDx10() {
        Require(m_headerBytes = kHeaderBytesDx10);
        if (At(kDimensionAt) != kTexture2d) Fail("only 2D textures are supported");
        if ((At(kMiscFlagsAt) & kIsCubeDx10) != 0) Fail("cube maps are not supported");
        if (At(kArraySizeAt) != 1)
            Fail(Text("arrays are not supported, and the array's size is {}", At(kArraySizeAt)));
        if ((At(kMiscFlags2At) & 7) == kPremultipliedDx10) Fail("premultiplied alpha is not supported");
        if (const auto layout = Find(kDxgiFormats, At(kDxgiFormatAt))) return *layout;
        Fail(Text("the DXGI format {} is not supported", At(kDxgiFormatAt)));
    }

    // Accepts channels of whole bytes in any order.
    TexelLayout LayoutOfMasks() const {
        const uint32_t flags = At(kFormatFlagsAt), bits = At(kBitCountAt);
        if ((flags & (kIsRgb | kIsLuminance)) == 0) Fail("texels without color are not supported");
        if (bits % 8 != 0 || bits < 8 || bits > 32) Fail(Text("{} bits a texel are not supported", bits));
        TexelLayout layout{.texelBytes = static_cast<uint8_t>(bits / 8)};
        for (size_t c = 0; c < 3; ++c)
            layout.bytes[c] = MaskedByte((flags & kIsLuminance) != 0 ? 0 : c, bits, Source::Zero);
        layout.bytes[3] = (flags & kHasAlpha) != 0 ? MaskedByte(3, bits, Source::One) : Source::One;
        return layout;
    }

    Source MaskedByte(size_t channel, uint32_t bits, Source without) const {
        const uint32_t mask = At(kMasksAt + 4 * channel);
        if (mask == 0) return without;
        for (uint32_t byte = 0; byte < bits / 8; ++byte)
            if (mask == 0xFFu << 8 * byte) return static_cast<Source>(byte);
        Fail(Text("the mask {:#010x} is none of 8 bits, other texels are not supported", mask));
    }

    std::span<const std::byte> m_bytes;
    std::string_view m_name;
    size_t m_headerBytes = kDdsBytes;
};

}  // namespace

Image8 DecodeDds(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits) {
    return DdsReader(bytes, name).Decode(limits);
}

}  // namespace raygraph::image

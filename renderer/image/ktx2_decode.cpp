// KTX2, Khronos' container of textures: the largest level of a 2D texture, plain, in blocks, or as Basis
// Universal (KHR_texture_basisu); of blocks that GPUs read, all levels.

#include "renderer/image/ktx2_header.h"

#include <zstd.h>
#include <algorithm>
#include <memory>
#include <new>
#include <optional>
#include <string>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/image/basis_lz.h"
#include "renderer/image/bc_blocks.h"
#include "renderer/image/decode.h"

namespace raygraph::image {
namespace {

struct NumberedLayout {
    uint32_t format;
    TexelLayout layout;
};

// Vulkan numbers formats so. A format and its sRGB version have the same layout: the use of a texture decides
// whether its numbers are sRGB.
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
        Reject(name, Text("KTX2: the Vulkan format {} is not supported", header.vkFormat));
    return found->layout;
}

// Holds memory that is not touched before it is written to.
struct Inflated {
    std::unique_ptr<std::byte[]> memory;
    size_t size = 0;
};

Inflated Inflate(const Ktx2Header& header, std::span<const std::byte> stored, uint64_t bytes,
                 std::string_view name) {
    // A block of Zstandard has 4 bytes or more, and becomes 128 KiB at most.
    constexpr uint64_t kMaxRatio = (uint64_t{128} << 10) / 4;
    if (bytes > stored.size() * kMaxRatio) {
        Reject(name, Text("KTX2: {} bytes of Zstandard cannot hold {} x {} pixels", stored.size(),
                          header.width, header.height));
    }
    Inflated inflated;
    try {
        inflated = {std::unique_ptr<std::byte[]>(new std::byte[bytes]), bytes};
    } catch (const std::bad_alloc&) {
        RejectMemory(name, header.width, header.height);
    }
    const size_t done = ZSTD_decompress(inflated.memory.get(), bytes, stored.data(), stored.size());
    if (ZSTD_isError(done) != 0) Reject(name, Text("KTX2: Zstandard: {}", ZSTD_getErrorName(done)));
    if (done != bytes)
        Reject(name, Text("KTX2: Zstandard: {} bytes came out, {} were expected", done, bytes));
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
    const uint64_t storedSize = isInflated ? header.inflatedBytes : header.level.size();
    if (storedSize != stored) {
        Reject(name, Text("KTX2: {} x {} pixels need {} bytes, and the largest level has {}", header.width,
                          header.height, stored, storedSize));
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
        Reject(name, "KTX2: ETC1S and BasisLZ go together, and this file has one of them");
    Image8 image = isEtc1s ? DecodeBasisLz(header, name) : DecodeStored(header, name);
    const Swizzle channels = header.vkFormat == 0 ? header.basis.channels : kIdentity;
    Apply(header.swizzle.value_or(channels), image);
    return image;
}

// --- The header ---

namespace {

constexpr size_t kHeaderBytes = 80, kLevelBytes = 24;
constexpr size_t kVkFormatAt = 12, kWidthAt = 20, kHeightAt = 24, kDepthAt = 28, kLayersAt = 32,
                 kFacesAt = 36;
constexpr size_t kLevelsAt = 40, kSupercompressionAt = 44, kDescriptorAt = 48, kKeysAt = 56, kGlobalAt = 64;
constexpr uint32_t kMaxLevelCount = 31;

// The basic block of a data format descriptor (Khronos Data Format Specification) has these offsets from the
// start of the descriptor, color models, and channels of samples.
constexpr size_t kModelAt = 12, kTransferAt = 14, kFlagsAt = 15, kSamplesAt = 28, kSampleBytes = 16,
                 kChannelAt = 3;
constexpr uint32_t kModelEtc1s = 163, kModelUastc = 166, kTransferSrgb = 2, kPremultiplied = 1;
constexpr uint32_t kRgb = 0, kRgba = 3, kRed = 3, kGreen = 4, kAlpha = 15;
constexpr uint32_t kRrr = 4, kRrrg = 5, kRg = 6;

constexpr Swizzle kRedAlpha{Source::Red, Source::Alpha, Source::Zero, Source::One};

class HeaderReader {
  public:
    HeaderReader(std::span<const std::byte> bytes, std::string_view name) : m_bytes(bytes), m_name(name) {}

    Ktx2Header Read(const DecodeLimits& limits) {
        if (m_bytes.size() < kHeaderBytes) Fail("the file is truncated");
        m_header.width = At(kWidthAt);
        m_header.height = At(kHeightAt);
        CheckSize(m_name, m_header.width, m_header.height, limits);
        if (At(kDepthAt) != 0) Fail("volumes are not supported");
        if (At(kLayersAt) > 1) Fail(Text("arrays are not supported, and there are {} layers", At(kLayersAt)));
        if (At(kFacesAt) != 1)
            Fail(Text("only 2D textures are supported, and there are {} faces", At(kFacesAt)));
        m_header.vkFormat = At(kVkFormatAt);
        m_header.levelCount = std::max(1u, At(kLevelsAt));
        if (m_header.levelCount > kMaxLevelCount) Fail(Text("{} levels are too many", m_header.levelCount));
        if (At(kSupercompressionAt) > 2)
            Fail(Text("supercompression scheme {} is not supported", At(kSupercompressionAt)));
        m_header.supercompression = static_cast<Supercompression>(At(kSupercompressionAt));
        ReadLevel();
        ReadDescriptor(Slice(At(kDescriptorAt), At(kDescriptorAt + 4), "the data format descriptor"));
        ReadKeys(Slice(At(kKeysAt), At(kKeysAt + 4), "the key/value data"));
        m_header.global =
            Slice(Little(m_bytes, kGlobalAt, 8), Little(m_bytes, kGlobalAt + 8, 8), "the global data");
        return m_header;
    }

  private:
    [[noreturn]] void Fail(const std::string& what) const { Reject(m_name, "KTX2: " + what); }
    uint32_t At(size_t offset) const { return Little32(m_bytes, offset); }

    std::span<const std::byte> Slice(uint64_t offset, uint64_t length, const char* what) const {
        if (length > m_bytes.size() || offset > m_bytes.size() - length) {
            Fail(Text("{} of {} bytes at {} lies outside the file of {}", what, length, offset,
                      m_bytes.size()));
        }
        return m_bytes.subspan(offset, length);
    }

    void ReadLevel() {
        Slice(kHeaderBytes, uint64_t{m_header.levelCount} * kLevelBytes, "the index of levels");
        m_header.level = Slice(Little(m_bytes, kHeaderBytes, 8), Little(m_bytes, kHeaderBytes + 8, 8),
                               "the largest level");
        m_header.inflatedBytes = Little(m_bytes, kHeaderBytes + 16, 8);
        for (uint32_t level = 1; level < m_header.levelCount; ++level) {
            const size_t at = kHeaderBytes + level * kLevelBytes;
            const uint64_t offset = Little(m_bytes, at, 8), length = Little(m_bytes, at + 8, 8);
            if (length > m_bytes.size() || offset > m_bytes.size() - length) break;
            m_header.smaller.push_back({m_bytes.subspan(offset, length), Little(m_bytes, at + 16, 8)});
        }
    }

    void ReadDescriptor(std::span<const std::byte> descriptor) {
        if (descriptor.size() < kSamplesAt) Fail("the data format descriptor is too short");
        const auto byteAt = [&](size_t at) { return std::to_integer<uint32_t>(descriptor[at]); };
        if ((byteAt(kFlagsAt) & kPremultiplied) != 0) Fail("premultiplied alpha is not supported");
        if (m_header.vkFormat != 0) return;
        BasisFormat& basis = m_header.basis;
        basis.isSrgb = byteAt(kTransferAt) == kTransferSrgb;
        const uint32_t model = byteAt(kModelAt);
        if (model != kModelEtc1s && model != kModelUastc)
            Fail(Text("has no Vulkan format, and its color model {} is not supported", model));
        basis.isUastc = model == kModelUastc;
        const size_t sampleCount = (descriptor.size() - kSamplesAt) / kSampleBytes;
        const auto channelOf = [&](size_t sample) {
            return byteAt(kSamplesAt + kSampleBytes * sample + kChannelAt) & 15;
        };
        basis.hasSecondSlice = !basis.isUastc && sampleCount == 2;
        if (sampleCount == 1 && basis.isUastc) {
            SetChannels(
                {{kRgb, kOpaque}, {kRgba, kIdentity}, {kRrr, kOnlyRed}, {kRrrg, kRedAlpha}, {kRg, kRedGreen}},
                channelOf(0));
        } else if (sampleCount == 1) {
            SetChannels({{kRgb, kOpaque}, {kRed, kOnlyRed}}, channelOf(0));
        } else if (basis.hasSecondSlice && channelOf(0) == kRgb && channelOf(1) == kAlpha) {
            basis.channels = kIdentity;
        } else if (basis.hasSecondSlice && channelOf(0) == kRed && channelOf(1) == kGreen) {
            basis.channels = kRedAlpha;
        } else {
            Fail("the channels of its data format descriptor are not supported");
        }
    }

    void SetChannels(std::initializer_list<std::pair<uint32_t, Swizzle>> known, uint32_t channel) {
        for (const auto& [number, swizzle] : known)
            if (number == channel) {
                m_header.basis.channels = swizzle;
                return;
            }
        Fail(Text("the channel {} of its data format descriptor is not supported", channel));
    }

    // Reads entries of a length, a key, a zero and a value, padded to four bytes.
    void ReadKeys(std::span<const std::byte> keys) {
        while (keys.size() >= 4) {
            const uint64_t length = Little32(keys, 0);
            if (length > keys.size() - 4) Fail("the key/value data is malformed");
            const std::string_view entry(reinterpret_cast<const char*>(keys.data() + 4), length);
            const size_t end = entry.find('\0');
            if (end == entry.npos) Fail("the key/value data is malformed");
            std::string_view value = entry.substr(end + 1);
            while (value.ends_with('\0')) value.remove_suffix(1);
            Read(entry.substr(0, end), value);
            keys = keys.subspan(std::min<uint64_t>(keys.size(), 4 + (length + 3) / 4 * 4));
        }
    }

    void Read(std::string_view key, std::string_view value) {
        if (key == "KTXorientation" && value != "rd")
            Fail(Text("the orientation {} is not supported, only \"rd\"", Quoted(value, 10)));
        if (key != "KTXswizzle") return;
        constexpr std::string_view kLetters = "rgba01";
        if (value.size() != 4 || value.find_first_not_of(kLetters) != value.npos)
            Fail(Text("the swizzle {} is none", Quoted(value, 10)));
        Swizzle& swizzle = m_header.swizzle.emplace();
        for (size_t c = 0; c < 4; ++c) swizzle[c] = static_cast<Source>(kLetters.find(value[c]));
    }

    std::span<const std::byte> m_bytes;
    std::string_view m_name;
    Ktx2Header m_header;
};

}  // namespace

Ktx2Header ReadKtx2Header(std::span<const std::byte> bytes, std::string_view name,
                          const DecodeLimits& limits) {
    return HeaderReader(bytes, name).Read(limits);
}

}  // namespace raygraph::image

// The texels of container files (DDS, KTX2), plain or in blocks. Private to renderer/image. Threads: any.
#pragma once

#include <array>
#include <string_view>

#include "renderer/image/image.h"

namespace raygraph::image {

enum class TexelCoding : uint8_t {
    Plain,
    Bc1Opaque,
    Bc1,
    Bc2,
    Bc3,
    Bc4,
    Bc5,
    Bc7,
    Uastc,
    UastcSrgb,
};

// Selects the source of a channel.
enum class Source : uint8_t { Red, Green, Blue, Alpha, Zero, One };
using Swizzle = std::array<Source, 4>;
inline constexpr Swizzle kIdentity{Source::Red, Source::Green, Source::Blue, Source::Alpha};
inline constexpr Swizzle kOpaque{Source::Red, Source::Green, Source::Blue, Source::One};
inline constexpr Swizzle kBgra{Source::Blue, Source::Green, Source::Red, Source::Alpha};
inline constexpr Swizzle kBgrx{Source::Blue, Source::Green, Source::Red, Source::One};
inline constexpr Swizzle kOnlyRed{Source::Red, Source::Zero, Source::Zero, Source::One};
inline constexpr Swizzle kRedGreen{Source::Red, Source::Green, Source::Zero, Source::One};

struct TexelLayout {
    TexelCoding coding = TexelCoding::Plain;
    // Describe plain texels only: how many bytes one has, 1 to 4, and which of them R, G, B and A are. Red
    // stands for the first byte.
    uint8_t texelBytes = 0;
    Swizzle bytes = kIdentity;
};

// Returns the bytes of a picture without padding between its rows.
uint64_t StoredBytes(const TexelLayout& layout, uint32_t width, uint32_t height);

// Returns None for texels that are not GPU blocks.
BlockCoding CodingOf(const TexelLayout& layout);

// `bytes` has at least StoredBytes().
Image8 DecodeTexels(const TexelLayout& layout, std::span<const std::byte> bytes, uint32_t width,
                    uint32_t height, std::string_view name);

void Apply(const Swizzle& swizzle, Image8& image);

}  // namespace raygraph::image

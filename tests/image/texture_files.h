// Small files of textures as GPUs store them, made in memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace raygraph::test {

// Microsoft's numbers of pixel formats.
inline constexpr uint32_t kDxgiRgba8 = 28, kDxgiRgba8Srgb = 29, kDxgiRg8 = 49, kDxgiR8 = 61,
                          kDxgiBc1Srgb = 72, kDxgiBc2 = 74, kDxgiBc3 = 77, kDxgiBc4 = 80, kDxgiBc5 = 83,
                          kDxgiBgra8 = 87, kDxgiBgrx8 = 88, kDxgiBc7 = 98;

struct DdsDesc {
    uint32_t width = 4, height = 4;
    std::string_view fourCc = {};  // Empty: masks, or a DXGI format.
    uint32_t dxgiFormat = 0;       // Not 0: with the header of DirectX 10.
    uint32_t bitCount = 32;
    std::array<uint32_t, 4> masks{0xFF, 0xFF00, 0xFF0000, 0xFF000000};
    uint32_t formatFlags = 0x41;  // RGB and alpha.
    uint32_t caps2 = 0;
    uint32_t dimension = 3, miscFlags = 0, arraySize = 1, alphaMode = 0;
};
std::vector<std::byte> MakeDds(const DdsDesc& desc, std::span<const uint8_t> texels);

// A DDS of one texel, plain RGBA, repeated.
std::vector<std::byte> MakePlainDds(uint32_t width, uint32_t height, const std::array<uint8_t, 4>& color);

// Appends a number, the lowest byte first.
void PutNumber(std::vector<std::byte>& bytes, uint64_t value, size_t count = 4);
void PutBytes(std::vector<std::byte>& bytes, std::span<const uint8_t> more);

}  // namespace raygraph::test

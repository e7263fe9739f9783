// Makes small files of GPU textures in memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace raygraph::test {

// These are Microsoft's numbers of pixel formats.
inline constexpr uint32_t kDxgiRgba8 = 28, kDxgiRgba8Srgb = 29, kDxgiRg8 = 49, kDxgiR8 = 61,
                          kDxgiBc1Srgb = 72, kDxgiBc2 = 74, kDxgiBc3 = 77, kDxgiBc4 = 80, kDxgiBc5 = 83,
                          kDxgiBgra8 = 87, kDxgiBgrx8 = 88, kDxgiBc7 = 98;

struct DdsDesc {
    uint32_t width = 4, height = 4;
    std::string_view fourCc = {};  // empty: masks, or a DXGI format
    uint32_t dxgiFormat = 0;       // not 0: the file has the DirectX 10 header
    uint32_t bitCount = 32;
    std::array<uint32_t, 4> masks{0xFF, 0xFF00, 0xFF0000, 0xFF000000};
    uint32_t formatFlags = 0x41;  // RGB and alpha
    uint32_t caps2 = 0;
    uint32_t dimension = 3, miscFlags = 0, arraySize = 1, alphaMode = 0;
    uint32_t levels = 0;  // in the header
};
std::vector<std::byte> MakeDds(const DdsDesc& desc, std::span<const uint8_t> texels);

// Makes a DDS of plain RGBA that repeats one texel.
std::vector<std::byte> MakePlainDds(uint32_t width, uint32_t height, const std::array<uint8_t, 4>& color);

// These are Khronos's color models of formats that Vulkan lacks, and Vulkan's numbers of some others.
inline constexpr uint32_t kEtc1s = 163, kUastc = 166;
inline constexpr uint32_t kVkR8 = 9, kVkRg8 = 16, kVkRgb8 = 23, kVkBgr8 = 30, kVkRgba8 = 37,
                          kVkRgba8Srgb = 43, kVkBgra8 = 44, kVkBc1Rgb = 131, kVkBc1Rgba = 133, kVkBc2 = 135,
                          kVkBc3 = 137, kVkBc4 = 139, kVkBc5 = 141, kVkBc7 = 145, kVkBc7Srgb = 146;

struct Ktx2Desc {
    uint32_t vkFormat = 0;
    uint32_t width = 4, height = 4, depth = 0, layers = 0, faces = 1, levels = 1;
    uint32_t supercompression = 0;  // 1: BasisLZ, 2: Zstandard
    uint32_t model = 1;             // 1: RGBSDA
    bool isSrgb = false;
    uint32_t flags = 0;                   // 1: premultiplied alpha
    std::vector<uint32_t> channels = {};  // channel of each sample
    std::vector<std::pair<std::string, std::string>> keys = {};
    std::vector<std::byte> global = {};
    std::optional<uint64_t> inflatedBytes = {};  // none: the level's size
    // Bytes of the other levels, with their sizes without Zstandard. Missing ones repeat the first.
    std::vector<std::pair<std::vector<uint8_t>, uint64_t>> smaller = {};
};
// The level is stored as given.
std::vector<std::byte> MakeKtx2(const Ktx2Desc& desc, std::span<const std::byte> level);
std::vector<std::byte> MakeKtx2(const Ktx2Desc& desc, std::span<const uint8_t> level);

// Appends a number, the lowest byte first.
void PutNumber(std::vector<std::byte>& bytes, uint64_t value, size_t count = 4);
void PutBytes(std::vector<std::byte>& bytes, std::span<const uint8_t> more);

// Pictures in BasisLZ, with choices that its specification leaves to an encoder.

struct BasisColor {
    std::array<uint32_t, 3> rgb{};  // 5 bits each
    uint32_t table = 0;             // table of ETC1's modifiers
};

// Tells for each block, row by row, its color and its pattern.
struct BasisSlice {
    std::vector<uint32_t> colors, patterns;
};

struct BasisPicture {
    uint32_t width = 4, height = 4;
    std::vector<BasisColor> colors;
    std::vector<uint32_t> patterns;  // two bits per texel, the first texel's lowest
    BasisSlice color, alpha;         // alpha: empty if there is none
    // The fields below are the encoder's choices.
    bool isGray = false;  // Colors have one channel; then r = g = b.
    bool arePatternsRaw = false;
    bool areCodesSkewed = false;  // Words of one bit up to 16, where symbols are few.
    uint32_t historySize = 8;
    uint32_t seed = 1;  // seed of all other choices; 0: the shortest
    uint32_t imageFlags = 0;
    std::vector<uint32_t> channels = {};  // empty: RGB, and alpha if there is one
    uint32_t levels = 1;
};

// Holds the parts of the file.
struct BasisFile {
    Ktx2Desc desc;
    std::vector<std::byte> level;
};
BasisFile CompressBasis(const BasisPicture& picture);
std::vector<std::byte> MakeBasisLz(const BasisPicture& picture);

// Returns the RGBA texels of a picture.
std::vector<uint8_t> TexelsOf(const BasisPicture& picture);

// Makes random colors, patterns and blocks; neighbors are often equal.
BasisPicture RandomBasisPicture(uint32_t width, uint32_t height, bool hasAlpha, uint32_t seed);

}  // namespace raygraph::test

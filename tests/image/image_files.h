// Makes small picture files in memory with the reference libraries, for renderer/image to read.
#pragma once

#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfPixelType.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/image/image.h"

namespace raygraph::test {

using Bytes = std::vector<std::byte>;

Bytes ToBytes(std::string_view text);

// Makes a picture in which every texel and channel differs from its neighbors; alpha is from 1 to 255.
image::Image8 Pattern(uint32_t width, uint32_t height);

struct PngDesc {
    uint32_t width = 1, height = 1;
    int colorType = 6, bitDepth = 8;  // of libpng: 0 gray, 2 RGB, 3 palette, 4 gray + alpha, 6 RGBA
    bool isInterlaced = false;
    std::vector<uint8_t> palette = {};            // RGB triples
    std::vector<uint8_t> transparency = {};       // alpha of the palette's entries
    std::vector<uint16_t> transparentColor = {};  // gray, or R, G, B, of transparent texels
    std::optional<double> gamma = {};
};
// `rows` are packed as in PNG, without filter bytes.
Bytes MakePng(const PngDesc& desc, std::span<const uint8_t> rows);

enum class JpegKind {
    Gray,
    Rgb,
    ProgressiveRgb,
    RgbInThreeScans,
    RestartedRgb,
    ArithmeticRgb,
    PlainCmyk,
    AdobeCmyk
};
// `texels` have 1, 3 or 4 bytes; the quality is 100, without chroma subsampling.
Bytes MakeJpeg(JpegKind kind, uint32_t width, uint32_t height, std::span<const uint8_t> texels);

Bytes MakeLosslessWebp(const image::Image8& image);
Bytes MakeLossyWebp(const image::Image8& image, float quality);

// Makes a Radiance file of the header, then `body`.
Bytes MakeHdr(uint32_t width, uint32_t height, std::span<const uint8_t> body,
              std::string_view headerLines = "");

struct ExrDesc {
    int minX = 0, minY = 0;
    uint32_t width = 1, height = 1;
    std::vector<std::string> channels = {"R", "G", "B"};
    Imf::PixelType type = Imf::FLOAT;
    Imf::Compression compression = Imf::ZIP_COMPRESSION;
    uint32_t tileSize = 0;  // 0: scan lines
    int sampling = 1;       // subsampling of the last channel
    // First and last pixel of the display window; none: it is the data window, from (0, 0) on.
    std::optional<std::array<int, 4>> picture = {};
    std::optional<std::array<float, 8>> chromaticities = {};  // x and y of red, green, blue and white
    std::optional<int> envmap = {};                           // an Imf::Envmap
};
// Channel c has the values planes[c], rows from the top; those of a subsampled last channel are subsampled.
Bytes MakeExr(const ExrDesc& desc, std::span<const std::vector<float>> planes);

// Makes two parts of one channel each.
Bytes MakeMultiPartExr();

// Returns the offset of `text` in `bytes`; fails the test if it is not there.
size_t Find(const Bytes& bytes, std::string_view text);

// Runs a decoder that must refuse, and returns its Error's message, which must be BadInput, one line, and
// start with `name`.
std::string Refusal(std::string_view name, const std::function<void()>& decode);

}  // namespace raygraph::test

// Makes pictures in BasisLZ, with choices that its specification leaves to an encoder.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/image/texture_files.h"

namespace raygraph::test {

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

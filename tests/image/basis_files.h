// Pictures in BasisLZ, compressed as its specification lets an encoder choose.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/image/texture_files.h"

namespace raygraph::test {

struct BasisColor {
    std::array<uint32_t, 3> rgb{};  // Of 5 bits.
    uint32_t table = 0;             // Of ETC1's modifiers.
};

// By block, row by row: which color, which pattern.
struct BasisSlice {
    std::vector<uint32_t> colors, patterns;
};

struct BasisPicture {
    uint32_t width = 4, height = 4;
    std::vector<BasisColor> colors;
    std::vector<uint32_t> patterns;  // Two bits a texel, the first texel's the lowest.
    BasisSlice color, alpha;         // Alpha: no blocks if there is none.
    // The encoder's choices.
    bool isGray = false;  // Colors have one channel; then r = g = b.
    bool arePatternsRaw = false;
    bool areCodesSkewed = false;  // Words of one bit up to 16, where symbols are few.
    uint32_t historySize = 8;
    uint32_t seed = 1;  // Of what else may be chosen; 0: whatever is shortest.
    uint32_t imageFlags = 0;
    std::vector<uint32_t> channels = {};  // Else RGB, and alpha if there is one.
    uint32_t levels = 1;
};

// The file in its parts.
struct BasisFile {
    Ktx2Desc desc;
    std::vector<std::byte> level;
};
BasisFile CompressBasis(const BasisPicture& picture);
std::vector<std::byte> MakeBasisLz(const BasisPicture& picture);

// The texels of a picture: RGBA.
std::vector<uint8_t> TexelsOf(const BasisPicture& picture);

// Random colors, patterns and blocks; neighbors are often alike.
BasisPicture RandomBasisPicture(uint32_t width, uint32_t height, bool hasAlpha, uint32_t seed);

}  // namespace raygraph::test

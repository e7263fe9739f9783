#include <bit>
#include <utility>

#include "renderer/image/bc7_tables.h"
#include "renderer/image/bc_blocks.h"

namespace raygraph::image {
namespace {

// The layout of a block of one mode: counts, and numbers of bits.
struct Mode {
    uint8_t parts, partBits, rotationBits, selectionBits;
    uint8_t colorBits, alphaBits;  // A channel of an endpoint; no alpha bits: opaque.
    bool hasOwnBit, hasSharedBit;  // A lowest bit common to an endpoint's channels; to both ends of a part.
    uint8_t indexBits, secondIndexBits;
};
constexpr std::array<Mode, 8> kModes{{
    {3, 4, 0, 0, 4, 0, true, false, 3, 0},
    {2, 6, 0, 0, 6, 0, false, true, 3, 0},
    {3, 6, 0, 0, 5, 0, false, false, 2, 0},
    {2, 6, 0, 0, 7, 0, true, false, 2, 0},
    {1, 0, 2, 1, 5, 6, false, false, 2, 3},
    {1, 0, 2, 0, 7, 8, false, false, 2, 2},
    {1, 0, 0, 0, 7, 7, true, false, 4, 0},
    {2, 6, 0, 0, 5, 5, true, false, 2, 0},
}};

// Indexed by the number of bits of an index: 64ths of the second endpoint.
constexpr std::array<std::array<uint8_t, 16>, 5> kWeights{{
    {},
    {},
    {0, 21, 43, 64},
    {0, 9, 18, 27, 37, 46, 55, 64},
    {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64},
}};

struct Parts {
    std::array<uint8_t, 16> ofTexel = {};
    uint32_t anchors = 1;  // A bit for each texel that is one.
};

Parts PartsOf(uint32_t count, uint32_t number) {
    Parts parts;
    for (unsigned i = 0; i < 16; ++i) {
        if (count == 2) parts.ofTexel[i] = bc7::kTwoParts[number] >> i & 1;
        if (count == 3) parts.ofTexel[i] = bc7::kThreeParts[number] >> 2 * i & 3;
    }
    if (count == 2) parts.anchors |= 1u << bc7::kSecondAnchorOfTwo[number];
    if (count == 3)
        parts.anchors |= 1u << bc7::kSecondAnchorOfThree[number] | 1u << bc7::kThirdAnchorOfThree[number];
    return parts;
}

// Six of them: two ends of up to three parts.
using Endpoints = std::array<std::array<uint8_t, 4>, 6>;

// `value` of 5 to 8 bits, its upper bits repeated below.
constexpr uint8_t Widened(uint32_t value, uint32_t bits) {
    return static_cast<uint8_t>(value << (8 - bits) | value >> (2 * bits - 8));
}

Endpoints ReadEndpoints(const Mode& mode, BlockBits& bits) {
    const size_t count = size_t{2} * mode.parts;
    std::array<std::array<uint32_t, 6>, 4> values = {};
    for (size_t c = 0; c < 4; ++c)
        for (size_t e = 0; e < count; ++e) values[c][e] = bits.Take(c < 3 ? mode.colorBits : mode.alphaBits);
    const bool hasLowestBit = mode.hasOwnBit || mode.hasSharedBit;
    std::array<uint32_t, 6> lowest = {};
    for (size_t e = 0; e < count && hasLowestBit; ++e)
        lowest[e] = mode.hasSharedBit && e % 2 == 1 ? lowest[e - 1] : bits.Take(1);
    Endpoints endpoints = {};
    for (size_t e = 0; e < count; ++e) {
        for (size_t c = 0; c < 4; ++c) {
            uint32_t width = c < 3 ? mode.colorBits : mode.alphaBits;
            if (width == 0) {
                endpoints[e][c] = 255;
                continue;
            }
            uint32_t value = values[c][e];
            if (hasLowestBit) {
                value = value << 1 | lowest[e];
                ++width;
            }
            endpoints[e][c] = Widened(value, width);
        }
    }
    return endpoints;
}

std::array<uint8_t, 16> ReadWeights(uint32_t indexBits, uint32_t anchors, BlockBits& bits) {
    std::array<uint8_t, 16> weights;
    for (size_t i = 0; i < 16; ++i)
        weights[i] = kWeights[indexBits][bits.Take(indexBits - (anchors >> i & 1))];
    return weights;
}

}  // namespace

void DecodeBc7(std::span<const std::byte, 16> block, BlockTexels& texels) {
    const auto modeNumber = static_cast<unsigned>(std::countr_zero(std::to_integer<uint8_t>(block[0])));
    texels = {};
    if (modeNumber >= kModes.size()) return;
    const Mode& mode = kModes[modeNumber];
    BlockBits bits(block);
    bits.Take(modeNumber + 1);
    const Parts parts = PartsOf(mode.parts, bits.Take(mode.partBits));
    const uint32_t rotation = bits.Take(mode.rotationBits);
    const bool areSwapped = bits.Take(mode.selectionBits) != 0;
    const Endpoints endpoints = ReadEndpoints(mode, bits);
    std::array<uint8_t, 16> colorWeights = ReadWeights(mode.indexBits, parts.anchors, bits);
    std::array<uint8_t, 16> alphaWeights = colorWeights;
    if (mode.secondIndexBits != 0) alphaWeights = ReadWeights(mode.secondIndexBits, 1, bits);
    if (areSwapped) std::swap(colorWeights, alphaWeights);
    for (size_t i = 0; i < 16; ++i) {
        const size_t part = parts.ofTexel[i];
        for (size_t c = 0; c < 4; ++c) {
            const uint32_t weight = c < 3 ? colorWeights[i] : alphaWeights[i];
            const uint32_t sum = (64 - weight) * endpoints[2 * part][c] + weight * endpoints[2 * part + 1][c];
            texels[4 * i + c] = static_cast<uint8_t>((sum + 32) >> 6);
        }
        if (rotation != 0) std::swap(texels[4 * i + 3], texels[4 * i + rotation - 1]);
    }
}

}  // namespace raygraph::image

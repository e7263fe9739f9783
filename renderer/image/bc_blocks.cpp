#include "renderer/image/bc_blocks.h"

#include <bit>
#include <utility>

namespace raygraph::image {
namespace {

// Returns a / b, neither of them negative, rounded to the nearest whole number.
constexpr uint8_t Rounded(uint32_t a, uint32_t b) {
    return static_cast<uint8_t>((2 * a + b) / (2 * b));
}

struct Rgb565 {
    uint32_t red, green, blue;

    explicit Rgb565(uint32_t bits) : red(bits >> 11), green(bits >> 5 & 63), blue(bits & 31) {}
};

using Color = std::array<uint8_t, 4>;

// Returns (wa a + wb b) / (wa + wb), opaque.
Color Mix(const Rgb565& a, uint32_t wa, const Rgb565& b, uint32_t wb) {
    const uint32_t sum = wa + wb;
    return {Rounded(255 * (wa * a.red + wb * b.red), 31 * sum),
            Rounded(255 * (wa * a.green + wb * b.green), 63 * sum),
            Rounded(255 * (wa * a.blue + wb * b.blue), 31 * sum), 255};
}

// Decodes two colors and two bits a texel. With `hasFourColors`, the order of the two does not matter.
void DecodeColors(std::span<const std::byte> block, bool hasFourColors, Color fourth, BlockTexels& texels) {
    const auto first = static_cast<uint32_t>(Little(block, 0, 2));
    const auto second = static_cast<uint32_t>(Little(block, 2, 2));
    const Rgb565 a(first), b(second);
    std::array<Color, 4> colors{Mix(a, 1, b, 0), Mix(a, 0, b, 1), Mix(a, 1, b, 1), fourth};
    if (hasFourColors || first > second) {
        colors[2] = Mix(a, 2, b, 1);
        colors[3] = Mix(a, 1, b, 2);
    }
    uint32_t codes = Little32(block, 4);
    for (size_t i = 0; i < texels.size(); i += 4, codes >>= 2) {
        const Color& color = colors[codes & 3];
        for (size_t c = 0; c < 4; ++c) texels[i + c] = color[c];
    }
}

// Decodes two values and three bits a texel, into one channel: BC3's alpha, BC4, and either half of BC5.
void DecodeChannel(std::span<const std::byte> block, size_t channel, BlockTexels& texels) {
    const auto a = std::to_integer<uint32_t>(block[0]), b = std::to_integer<uint32_t>(block[1]);
    std::array<uint8_t, 8> values{static_cast<uint8_t>(a), static_cast<uint8_t>(b), 0, 0, 0, 0, 0, 255};
    const uint32_t steps = a > b ? 7 : 5;
    for (uint32_t i = 1; i < steps; ++i) values[i + 1] = Rounded((steps - i) * a + i * b, steps);
    uint64_t codes = Little(block, 2, 6);
    for (size_t i = channel; i < texels.size(); i += 4, codes >>= 3) texels[i] = values[codes & 7];
}

constexpr Color kTransparent{0, 0, 0, 0}, kBlack{0, 0, 0, 255};

void Fill(BlockTexels& texels, const Color& color) {
    for (size_t i = 0; i < texels.size(); ++i) texels[i] = color[i % 4];
}

}  // namespace

void DecodeBc1(std::span<const std::byte, 8> block, Bc1Alpha alpha, BlockTexels& texels) {
    DecodeColors(block, false, alpha == Bc1Alpha::None ? kBlack : kTransparent, texels);
}

void DecodeBc2(std::span<const std::byte, 16> block, BlockTexels& texels) {
    DecodeColors(block.subspan(8), true, kBlack, texels);
    uint64_t alphas = Little(block, 0, 8);
    for (size_t i = 3; i < texels.size(); i += 4, alphas >>= 4)
        texels[i] = static_cast<uint8_t>(17 * (alphas & 15));
}

void DecodeBc3(std::span<const std::byte, 16> block, BlockTexels& texels) {
    DecodeColors(block.subspan(8), true, kBlack, texels);
    DecodeChannel(block, 3, texels);
}

void DecodeBc4(std::span<const std::byte, 8> block, BlockTexels& texels) {
    Fill(texels, kBlack);
    DecodeChannel(block, 0, texels);
}

void DecodeBc5(std::span<const std::byte, 16> block, BlockTexels& texels) {
    Fill(texels, kBlack);
    DecodeChannel(block, 0, texels);
    DecodeChannel(block.subspan(8), 1, texels);
}

// --- BC7 ---

namespace {

// Describes a block of one mode: counts, and numbers of bits.
struct Mode {
    uint8_t parts, partBits, rotationBits, selectionBits;
    uint8_t colorBits, alphaBits;  // per channel of an endpoint; without alpha bits a block is opaque
    // the lowest bit: one for an endpoint's channels, or for both ends of a part
    bool hasOwnBit, hasSharedBit;
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

// Indexed by the number of bits of an index. The weights are 64ths of the second endpoint.
constexpr std::array<std::array<uint8_t, 16>, 5> kWeights{{
    {},
    {},
    {0, 21, 43, 64},
    {0, 9, 18, 27, 37, 46, 55, 64},
    {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64},
}};

struct Parts {
    std::array<uint8_t, 16> ofTexel = {};
    uint32_t anchors = 1;  // has a bit for each anchor texel
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

// There are six endpoints: two ends of up to three parts.
using Endpoints = std::array<std::array<uint8_t, 4>, 6>;

// Widens `value` of 5 to 8 bits to 8 bits by repeating its upper bits below.
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

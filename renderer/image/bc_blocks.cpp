#include "renderer/image/bc_blocks.h"

namespace raygraph::image {
namespace {

// a / b, not negative, to the nearest whole number.
constexpr uint8_t Rounded(uint32_t a, uint32_t b) {
    return static_cast<uint8_t>((2 * a + b) / (2 * b));
}

struct Rgb565 {
    uint32_t red, green, blue;

    explicit Rgb565(uint32_t bits) : red(bits >> 11), green(bits >> 5 & 63), blue(bits & 31) {}
};

using Color = std::array<uint8_t, 4>;

// (wa a + wb b) / (wa + wb), opaque.
Color Mix(const Rgb565& a, uint32_t wa, const Rgb565& b, uint32_t wb) {
    const uint32_t sum = wa + wb;
    return {Rounded(255 * (wa * a.red + wb * b.red), 31 * sum),
            Rounded(255 * (wa * a.green + wb * b.green), 63 * sum),
            Rounded(255 * (wa * a.blue + wb * b.blue), 31 * sum), 255};
}

// Two colors and two bits a texel. `hasFourColors`: whatever the order of the two.
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

// Two values and three bits a texel, into one channel: BC3's alpha, BC4, and either half of BC5.
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

}  // namespace raygraph::image

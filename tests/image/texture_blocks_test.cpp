// Blocks of compressed textures.

#include <algorithm>
#include <cmath>
#include <random>

#include "renderer/image/bc_blocks.h"
#include "renderer/image/uastc_block.h"
#include "tests/image/uastc_writer.h"

// Tests BC1 to BC5 and BC7 against values derived from the Khronos Data Format Specification.
namespace raygraph::test::bc_blocks_test {
namespace {

using image::Bc1Alpha;
using image::BlockTexels;
using image::DecodeBc2, image::DecodeBc3, image::DecodeBc4, image::DecodeBc5, image::DecodeBc7;

constexpr uint32_t Pack565(uint32_t r, uint32_t g, uint32_t b) {
    return r << 11 | g << 5 | b;
}

// Makes a block in which texel i has code i mod 4.
BlockTexels Bc1(uint32_t first, uint32_t second, Bc1Alpha alpha) {
    BlockWriter<8> block;
    block.Put(first, 16).Put(second, 16);
    for (uint32_t i = 0; i < 16; ++i) block.Put(i % 4, 2);
    BlockTexels texels;
    DecodeBc1(block.Block(), alpha, texels);
    for (size_t i = 4; i < 16; ++i) EXPECT_EQ(TexelOf(texels, i), TexelOf(texels, i % 4)) << i;
    return texels;
}

// The two colors are those in the specification's figure of BC1: 31sts and 63rds, and thirds between them.
constexpr uint32_t kGreater = Pack565(29, 60, 1), kLess = Pack565(20, 2, 30);

TEST(Bc1, GreaterColorFirstMakesFourColors) {
    for (const Bc1Alpha alpha : {Bc1Alpha::None, Bc1Alpha::PunchThrough}) {
        const BlockTexels texels = Bc1(kGreater, kLess, alpha);
        EXPECT_EQ(TexelOf(texels, 0), (Color{239, 243, 8, 255}));
        EXPECT_EQ(TexelOf(texels, 1), (Color{165, 8, 247, 255}));
        EXPECT_EQ(TexelOf(texels, 2), (Color{214, 165, 88, 255}));
        EXPECT_EQ(TexelOf(texels, 3), (Color{189, 86, 167, 255}));
    }
}

TEST(Bc1, OtherOrderMakesTheMeanAndAHole) {
    const BlockTexels texels = Bc1(kLess, kGreater, Bc1Alpha::PunchThrough);
    EXPECT_EQ(TexelOf(texels, 0), (Color{165, 8, 247, 255}));
    EXPECT_EQ(TexelOf(texels, 1), (Color{239, 243, 8, 255}));
    EXPECT_EQ(TexelOf(texels, 2), (Color{202, 125, 128, 255}));
    EXPECT_EQ(TexelOf(texels, 3), (Color{0, 0, 0, 0}));
    EXPECT_EQ(TexelOf(Bc1(kLess, kGreater, Bc1Alpha::None), 3), (Color{0, 0, 0, 255}));
    EXPECT_EQ(TexelOf(Bc1(kLess, kLess, Bc1Alpha::PunchThrough), 3), (Color{0, 0, 0, 0}));
}

TEST(Bc1, EndsAreTheNearestOfEightBits) {
    for (uint32_t i = 0; i < 32; ++i) {
        const BlockTexels texels = Bc1(Pack565(i, 2 * i, 31 - i), 0, Bc1Alpha::None);
        EXPECT_EQ(texels[0], std::lround(i * 255 / 31.0)) << i;
        EXPECT_EQ(texels[1], std::lround(2 * i * 255 / 63.0)) << i;
        EXPECT_EQ(texels[2], std::lround((31 - i) * 255 / 31.0)) << i;
    }
}

TEST(Bc2, HasAlphaOfFourBitsAndAlwaysFourColors) {
    BlockWriter<16> block;
    for (uint32_t i = 0; i < 16; ++i) block.Put(i, 4);
    block.Put(kLess, 16).Put(kGreater, 16).Put(0xE4E4E4E4, 32);
    BlockTexels texels;
    DecodeBc2(block.Block(), texels);
    for (int i = 0; i < 16; ++i) EXPECT_EQ(TexelOf(texels, static_cast<size_t>(i))[3], 17 * i);
    EXPECT_EQ(TexelOf(texels, 2), (Color{189, 86, 167, 34}));
    EXPECT_EQ(TexelOf(texels, 7), (Color{214, 165, 88, 119}));
}

// Makes a block in which texel i has code i mod 8.
template <size_t byteCount>
void PutChannel(BlockWriter<byteCount>& block, uint32_t first, uint32_t second) {
    block.Put(first, 8).Put(second, 8);
    for (uint32_t i = 0; i < 16; ++i) block.Put(i % 8, 3);
}
// These are sevenths between 255 and 0, and fifths with the extremes.
constexpr std::array<int, 8> kSevenths{255, 0, 219, 182, 146, 109, 73, 36};
constexpr std::array<int, 8> kFifths{0, 255, 51, 102, 153, 204, 0, 255};

TEST(Bc3, HasBc4sAlphaAndAlwaysFourColors) {
    BlockWriter<16> block;
    PutChannel(block, 255, 0);
    block.Put(kLess, 16).Put(kGreater, 16).Put(0xFFFFFFFF, 32);
    BlockTexels texels;
    DecodeBc3(block.Block(), texels);
    for (size_t i = 0; i < 16; ++i)
        EXPECT_EQ(TexelOf(texels, i), (Color{214, 165, 88, kSevenths[i % 8]})) << i;
}

TEST(Bc4, OrderOfTheValuesSaysSeventhsOrFifths) {
    for (const bool isGreaterFirst : {true, false}) {
        BlockWriter<8> block;
        PutChannel(block, isGreaterFirst ? 255 : 0, isGreaterFirst ? 0 : 255);
        BlockTexels texels;
        DecodeBc4(block.Block(), texels);
        for (size_t i = 0; i < 16; ++i) {
            const int red = (isGreaterFirst ? kSevenths : kFifths)[i % 8];
            EXPECT_EQ(TexelOf(texels, i), (Color{red, 0, 0, 255})) << i;
        }
    }
    BlockWriter<8> equal;
    PutChannel(equal, 9, 9);
    BlockTexels texels;
    DecodeBc4(equal.Block(), texels);
    EXPECT_EQ(TexelOf(texels, 5)[0], 9);
    EXPECT_EQ(TexelOf(texels, 6)[0], 0);
    EXPECT_EQ(TexelOf(texels, 7)[0], 255);
}

TEST(Bc5, IsTwoOfBc4) {
    BlockWriter<16> block;
    PutChannel(block, 0, 255);
    PutChannel(block, 255, 0);
    BlockTexels texels;
    DecodeBc5(block.Block(), texels);
    for (size_t i = 0; i < 16; ++i)
        EXPECT_EQ(TexelOf(texels, i), (Color{kFifths[i % 8], kSevenths[i % 8], 0, 255})) << i;
}

// Is a row of the specification's table of bit layouts, for one mode.
struct Bc7Layout {
    unsigned parts, partBits, rotationBits, selectionBits, colorBits, alphaBits, ownBits, sharedBits,
        indexBits, secondIndexBits;
};
constexpr std::array<Bc7Layout, 8> kLayouts{{
    {3, 4, 0, 0, 4, 0, 6, 0, 3, 0},
    {2, 6, 0, 0, 6, 0, 0, 2, 3, 0},
    {3, 6, 0, 0, 5, 0, 0, 0, 2, 0},
    {2, 6, 0, 0, 7, 0, 4, 0, 2, 0},
    {1, 0, 2, 1, 5, 6, 0, 0, 2, 3},
    {1, 0, 2, 0, 7, 8, 0, 0, 2, 2},
    {1, 0, 0, 0, 7, 7, 2, 0, 4, 0},
    {2, 6, 0, 0, 5, 5, 4, 0, 2, 0},
}};

// Returns the subset of a texel, and whether its index is an anchor.
unsigned PartOf(const Bc7Layout& layout, unsigned number, unsigned texel) {
    if (layout.parts == 1) return 0;
    return layout.parts == 2 ? image::bc7::kTwoParts[number] >> texel & 1
                             : image::bc7::kThreeParts[number] >> 2 * texel & 3;
}
bool IsAnchor(const Bc7Layout& layout, unsigned number, unsigned texel) {
    return texel == 0 || (layout.parts == 2 && texel == image::bc7::kSecondAnchorOfTwo[number]) ||
           (layout.parts == 3 && (texel == image::bc7::kSecondAnchorOfThree[number] ||
                                  texel == image::bc7::kThirdAnchorOfThree[number]));
}

// Returns the weight by the specification's formula, not by its table.
int Weight(int index, unsigned bits) {
    if (bits == 2) return index * 21 + (index >> 1);
    if (bits == 3) return index * 9 + (index >> 2);
    return (index << 2) + (index >> 2) + (index >> 1 & 1);
}

class Bc7Block {
  public:
    Bc7Block(unsigned modeNumber, std::mt19937& random) : m_layout(kLayouts[modeNumber]) {
        const auto any = [&](unsigned bits) {
            return bits == 0 ? 0u : static_cast<unsigned>(random() >> (32 - bits));
        };
        m_writer.Put(1u << modeNumber, modeNumber + 1);
        m_part = Put(any(m_layout.partBits), m_layout.partBits);
        m_rotation = Put(any(m_layout.rotationBits), m_layout.rotationBits);
        m_selection = Put(any(m_layout.selectionBits), m_layout.selectionBits);
        for (size_t c = 0; c < 4; ++c) {
            const unsigned bits = c < 3 ? m_layout.colorBits : m_layout.alphaBits;
            for (size_t e = 0; e < 2 * m_layout.parts; ++e) m_numbers[c][e] = Put(any(bits), bits);
        }
        for (size_t e = 0; e < m_layout.ownBits; ++e) m_lowest[e] = Put(any(1), 1);
        for (size_t p = 0; p < m_layout.sharedBits; ++p)
            m_lowest[2 * p] = m_lowest[2 * p + 1] = Put(any(1), 1);
        for (unsigned i = 0; i < 16; ++i) {
            const unsigned bits = m_layout.indexBits - (IsAnchor(m_layout, m_part, i) ? 1 : 0);
            m_indices[i] = static_cast<int>(Put(any(bits), bits));
        }
        for (unsigned i = 0; i < 16 && m_layout.secondIndexBits > 0; ++i) {
            const unsigned bits = m_layout.secondIndexBits - (i == 0 ? 1 : 0);
            m_secondIndices[i] = static_cast<int>(Put(any(bits), bits));
        }
        EXPECT_EQ(m_writer.BitCount(), 128u) << modeNumber;
    }

    std::span<const std::byte, 16> Bits() const { return m_writer.Block(); }

    Color Expected(unsigned texel) const {
        const size_t part = PartOf(m_layout, m_part, texel);
        int colorWeight = Weight(m_indices[texel], m_layout.indexBits), alphaWeight = colorWeight;
        if (m_layout.secondIndexBits > 0) {
            alphaWeight = Weight(m_secondIndices[texel], m_layout.secondIndexBits);
            if (m_selection == 1) std::swap(colorWeight, alphaWeight);
        }
        Color color;
        for (size_t c = 0; c < 4; ++c) {
            const int weight = c < 3 ? colorWeight : alphaWeight;
            color[c] = ((64 - weight) * End(c, 2 * part) + weight * End(c, 2 * part + 1) + 32) / 64;
        }
        if (m_rotation > 0) std::swap(color[3], color[m_rotation - 1]);
        return color;
    }

  private:
    unsigned Put(unsigned value, unsigned bits) {
        m_writer.Put(value, bits);
        return value;
    }
    int End(size_t channel, size_t end) const {
        unsigned bits = channel < 3 ? m_layout.colorBits : m_layout.alphaBits;
        if (bits == 0) return 255;
        if (m_layout.ownBits + m_layout.sharedBits == 0) return Repeated(m_numbers[channel][end], bits);
        return Repeated(2 * m_numbers[channel][end] + m_lowest[end], bits + 1);
    }

    const Bc7Layout& m_layout;
    BlockWriter<16> m_writer;
    unsigned m_part = 0, m_rotation = 0, m_selection = 0;
    std::array<std::array<unsigned, 6>, 4> m_numbers = {};
    std::array<unsigned, 6> m_lowest = {};
    std::array<int, 16> m_indices = {}, m_secondIndices = {};
};

class Bc7Mode : public ::testing::TestWithParam<unsigned> {};

TEST_P(Bc7Mode, DecodesWhatItsFieldsSay) {
    std::mt19937 random(GetParam());
    for (int round = 0; round < 500; ++round) {
        const Bc7Block block(GetParam(), random);
        BlockTexels texels;
        DecodeBc7(block.Bits(), texels);
        for (unsigned i = 0; i < 16; ++i)
            ASSERT_EQ(TexelOf(texels, i), block.Expected(i)) << "round " << round << ", texel " << i;
    }
}

INSTANTIATE_TEST_SUITE_P(All, Bc7Mode, ::testing::Range(0u, 8u));

// A block of mode 6 by hand: red from 0 to 255, green constant, blue falling, alpha 255; indices 0 to 15.
TEST(Bc7, BlockOfModeSixByHand) {
    BlockWriter<16> block;
    block.Put(0x40, 7).Put(0, 7).Put(127, 7).Put(64, 7).Put(64, 7).Put(127, 7).Put(0, 7).Put(127, 7).Put(127,
                                                                                                         7);
    block.Put(0, 1).Put(1, 1).Put(0, 3);
    for (uint64_t i = 1; i < 16; ++i) block.Put(i, 4);
    BlockTexels texels;
    DecodeBc7(block.Block(), texels);
    EXPECT_EQ(TexelOf(texels, 0), (Color{0, 128, 254, 254}));
    EXPECT_EQ(TexelOf(texels, 15), (Color{255, 129, 1, 255}));
    // 26 of 64: 103.6, 128.4, 151.2, 254.4
    EXPECT_EQ(TexelOf(texels, 6), (Color{104, 128, 151, 254}));
}

TEST(Bc7, ReservedModeIsTransparentBlack) {
    BlockWriter<16> block;
    block.Put(0, 8).Put(~uint64_t{0}, 64).Put((uint64_t{1} << 56) - 1, 56);
    BlockTexels texels;
    texels.fill(7);
    DecodeBc7(block.Block(), texels);
    for (size_t i = 0; i < 16; ++i) EXPECT_EQ(TexelOf(texels, i), (Color{0, 0, 0, 0}));
}

// The specification gives an example: in mode 2, partition 6, texel 9 is in the second subset, and the
// anchors are 0, 15 and 3.
TEST(Bc7, TablesAgreeWithTheSpecificationsExample) {
    EXPECT_EQ(PartOf(kLayouts[2], 6, 9), 1u);
    for (unsigned i = 0; i < 16; ++i)
        EXPECT_EQ(IsAnchor(kLayouts[2], 6, i), i == 0 || i == 3 || i == 15) << i;
}

TEST(Bc7, AnchorsLieInTheirParts) {
    for (unsigned number = 0; number < 64; ++number) {
        EXPECT_EQ(PartOf(kLayouts[1], number, 0), 0u);
        EXPECT_EQ(PartOf(kLayouts[2], number, 0), 0u);
        EXPECT_EQ(PartOf(kLayouts[1], number, image::bc7::kSecondAnchorOfTwo[number]), 1u) << number;
        EXPECT_EQ(PartOf(kLayouts[2], number, image::bc7::kSecondAnchorOfThree[number]), 1u) << number;
        EXPECT_EQ(PartOf(kLayouts[2], number, image::bc7::kThirdAnchorOfThree[number]), 2u) << number;
    }
}

}  // namespace
}  // namespace raygraph::test::bc_blocks_test

// Tests UASTC against values derived from the Khronos Data Format Specification.
namespace raygraph::test::uastc_block_test {
namespace {

using image::BlockTexels;
using image::DecodeUastc;

class UastcMode : public ::testing::TestWithParam<size_t> {};

TEST_P(UastcMode, DecodesWhatItsFieldsSay) {
    std::mt19937 random(static_cast<uint32_t>(GetParam()));
    for (int round = 0; round < 500; ++round) {
        const UastcBlock block = RandomUastcBlock(GetParam(), random);
        const auto bytes = Pack(block);
        for (const bool isSrgb : {false, true}) {
            BlockTexels texels;
            ASSERT_TRUE(DecodeUastc(bytes, isSrgb, texels));
            for (size_t i = 0; i < 16; ++i)
                ASSERT_EQ(TexelOf(texels, i), ExpectedTexel(block, i, isSrgb))
                    << "round " << round << ", texel " << i;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(All, UastcMode, ::testing::Range(size_t{0}, size_t{19}));

// Returns the numbers of an endpoint in the order of the bits that store them.
std::vector<int> Numbers(size_t mode) {
    std::vector<int> values;
    const UastcLayout& layout = kUastcLayouts[mode];
    for (uint32_t number = 0; number < layout.base << layout.numberBits; ++number) {
        UastcBlock block{.mode = mode, .numbers = {}};
        block.numbers.fill(number);
        BlockTexels texels;
        EXPECT_TRUE(DecodeUastc(Pack(block), false, texels));
        values.push_back(texels[0]);
    }
    return values;
}

TEST(Uastc, NumbersWithTritsAreThoseOfTheSpecification) {
    EXPECT_EQ(Numbers(3), (std::vector<int>{0, 255, 69, 186, 23, 232, 92, 163, 46, 209, 116, 139}));
}

TEST(Uastc, NumbersWithQuintsAreThoseOfTheSpecification) {
    EXPECT_EQ(Numbers(7), (std::vector<int>{0,   255, 32,  223, 65, 190, 97, 158, 6,   249, 39,  216, 71, 184,
                                            104, 151, 13,  242, 45, 210, 78, 177, 110, 145, 19,  236, 52, 203,
                                            84,  171, 117, 138, 26, 229, 58, 197, 91,  164, 123, 132}));
}

// The numbers alternate between counting up from 0 and down from 255, in equal steps but for rounding.
TEST(Uastc, NumbersAreEvenlySpaced) {
    for (const size_t mode : {0, 3, 4, 6, 7, 10, 11, 12}) {
        const std::vector<int> values = Numbers(mode);
        const UastcLayout& layout = kUastcLayouts[mode];
        const auto count = static_cast<double>(values.size());
        for (uint32_t number = 0; number < values.size(); ++number) {
            const uint32_t bits = number & ((1u << layout.numberBits) - 1);
            double rank = bits / 2 * layout.base + (number >> layout.numberBits);
            if (bits % 2 == 1) rank = count - 1 - rank;
            EXPECT_NEAR(values[number], 255 * rank / (count - 1), 1.5) << mode << " " << number;
            EXPECT_EQ(values[number] + values[number ^ 1], 255) << mode << " " << number;
        }
    }
}

TEST(Uastc, ReservedModeAndDivisionsAreRefused) {
    BlockTexels texels;
    BlockWriter<16> reserved;
    EXPECT_FALSE(DecodeUastc(reserved.Put(0x45, 7).Block(), false, texels));
    for (const auto& [mode, count] :
         {std::pair{size_t{2}, 30u}, {3, 11}, {4, 30}, {7, 19}, {9, 30}, {16, 30}}) {
        UastcBlock block{.mode = mode};
        for (uint32_t part = 0; part < 1u << kUastcLayouts[mode].partBits; ++part) {
            block.part = part;
            EXPECT_EQ(DecodeUastc(PackAnyPart(block), false, texels), part < count) << mode << " " << part;
        }
    }
}

// --- The divisions into parts: ASTC computes them from a number. ---

uint32_t Scrambled(uint32_t p) {
    p ^= p >> 15;
    p -= p << 17;
    p += p << 7;
    p += p << 4;
    p ^= p >> 5;
    p += p << 16;
    p ^= p >> 7;
    p ^= p >> 3;
    p ^= p << 6;
    p ^= p >> 17;
    return p;
}

// Is the partition function of ASTC (Khronos Data Format Specification, chapter ASTC) for 2 or 3 parts of a
// block of fewer than 31 texels.
uint32_t AstcPart(uint32_t number, uint32_t parts, uint32_t texel) {
    const uint32_t x = texel % 4 * 2, y = texel / 4 * 2;
    const uint32_t seed = number + (parts - 1) * 1024, scrambled = Scrambled(seed);
    std::array<uint32_t, 6> factors;
    for (uint32_t i = 0; i < 6; ++i) {
        const uint32_t bits = scrambled >> 4 * i & 15;
        factors[i] = bits * bits;
    }
    const uint32_t ofParts = parts == 3 ? 6 : 5, ofSeed = (seed & 2) != 0 ? 4 : 5;
    const uint32_t even = (seed & 1) != 0 ? ofSeed : ofParts, odd = (seed & 1) != 0 ? ofParts : ofSeed;
    std::array<uint32_t, 3> sums;
    for (uint32_t i = 0; i < 3; ++i)
        sums[i] =
            ((factors[2 * i] >> even) * x + (factors[2 * i + 1] >> odd) * y + (scrambled >> (14 - 4 * i))) &
            63;
    if (parts == 2) sums[2] = 0;
    return static_cast<uint32_t>(std::ranges::max_element(sums) - sums.begin());
}

// These are the numbers of UASTC's divisions in ASTC.
TEST(Uastc, DivisionsAreThoseOfAstc) {
    constexpr std::array<uint32_t, 30> kTwo{28,  20,  16,  29,  91,  9,   107, 72,  149, 204,
                                            50,  114, 496, 17,  78,  39,  252, 828, 43,  156,
                                            116, 210, 476, 273, 684, 359, 246, 195, 694, 524};
    constexpr std::array<uint32_t, 19> kTwoOfMode7{36,  48,  61,  137, 161, 183, 226, 281, 302, 307,
                                                   479, 495, 593, 594, 605, 799, 812, 988, 993};
    constexpr std::array<uint32_t, 11> kThree{260, 74, 32, 156, 183, 15, 745, 0, 335, 902, 254};
    for (uint32_t texel = 0; texel < 16; ++texel) {
        for (size_t i = 0; i < kTwo.size(); ++i)
            EXPECT_EQ(image::uastc::kTwoParts[i] >> texel & 1, AstcPart(kTwo[i], 2, texel)) << i;
        for (size_t i = 0; i < kTwoOfMode7.size(); ++i)
            EXPECT_EQ(image::uastc::kTwoPartsOfMode7[i] >> texel & 1, AstcPart(kTwoOfMode7[i], 2, texel))
                << i;
        for (size_t i = 0; i < kThree.size(); ++i)
            EXPECT_EQ(image::uastc::kThreeParts[i] >> 2 * texel & 3, AstcPart(kThree[i], 3, texel)) << i;
    }
}

// UASTC has only divisions of BC7, whose parts may be in another order.
TEST(Uastc, DivisionsAreThoseOfBc7) {
    constexpr std::array<uint8_t, 30> kOfBc7{0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14,
                                             15, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 29, 32, 33, 52};
    for (size_t i = 0; i < kOfBc7.size(); ++i) {
        const uint16_t ours = image::uastc::kTwoParts[i], theirs = image::bc7::kTwoParts[kOfBc7[i]];
        EXPECT_TRUE(ours == theirs || ours == static_cast<uint16_t>(~theirs)) << i;
    }
}

}  // namespace
}  // namespace raygraph::test::uastc_block_test

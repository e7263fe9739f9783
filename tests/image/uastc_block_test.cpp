// Tests UASTC against values derived from the Khronos Data Format Specification.
#include "renderer/image/uastc_block.h"

#include <algorithm>
#include <random>

#include "renderer/image/bc_blocks.h"
#include "tests/image/uastc_writer.h"

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

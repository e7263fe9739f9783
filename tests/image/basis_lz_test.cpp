// Tests that ETC1S with BasisLZ decodes what the tests' own encoder has written.
#include <gtest/gtest.h>

#include "tests/image/basis_files.h"
#include "tests/image/image_files.h"

namespace raygraph::test::basis_lz_test {
namespace {

using image::DecodeImage8;
using Texels = std::vector<uint8_t>;

Texels Decode(const BasisPicture& picture) {
    return DecodeImage8(MakeBasisLz(picture), "a.ktx2").rgba;
}

TEST(BasisLz, OneBlockByHand) {
    // 20 and 10 of 31 are 165 and 82, with modifiers of 9 and 29; 31 and 0 reach the ends of the range
    BasisPicture picture{.colors = {{{20, 10, 31}, 2}}, .patterns = {0xE4E4E4E4}, .color = {{0}, {0}}};
    const Texels row{136, 53, 226, 255, 156, 73, 246, 255, 174, 91, 255, 255, 194, 111, 255, 255};
    Texels expected;
    for (int y = 0; y < 4; ++y) expected.insert(expected.end(), row.begin(), row.end());
    EXPECT_EQ(Decode(picture), expected);
    EXPECT_EQ(TexelsOf(picture), expected);
}

TEST(BasisLz, EveryChoiceOfAnEncoderComesBack) {
    constexpr std::array<std::pair<uint32_t, uint32_t>, 7> kSizes{
        {{1, 1}, {4, 4}, {5, 3}, {8, 20}, {33, 17}, {64, 64}, {260, 5}}};
    for (uint32_t seed = 0; seed < 400; ++seed) {
        const auto [width, height] = kSizes[seed % kSizes.size()];
        const BasisPicture picture = RandomBasisPicture(width, height, seed % 3 == 0, seed);
        ASSERT_EQ(Decode(picture), TexelsOf(picture)) << seed;
    }
}

// The blocks are all equal, so that runs exceed what one symbol can count.
TEST(BasisLz, LongRunsComeBack) {
    BasisPicture picture{
        .width = 1000, .height = 700, .colors = {{{1, 2, 3}, 4}}, .patterns = {0x1B1B1B1B, 7}, .seed = 0};
    picture.color.colors.assign(250 * 175, 0);
    picture.color.patterns.assign(250 * 175, 0);
    picture.color.patterns.back() = 1;
    const std::vector<std::byte> bytes = MakeBasisLz(picture);
    EXPECT_LT(bytes.size(), 1000u);
    EXPECT_EQ(DecodeImage8(bytes, "a.ktx2").rgba, TexelsOf(picture));
}

TEST(BasisLz, LevelsBelowTheFirstAreNotRead) {
    BasisPicture picture = RandomBasisPicture(16, 16, true, 3);
    picture.levels = 5;
    EXPECT_EQ(Decode(picture), TexelsOf(picture));
}

TEST(BasisLz, SlicesOfOneChannelAreRedAndGreen) {
    BasisPicture one = RandomBasisPicture(8, 8, false, 4), two = RandomBasisPicture(8, 8, true, 5);
    one.channels = {3};
    two.channels = {3, 4};
    const Texels red = Decode(one), redGreen = Decode(two), ofOne = TexelsOf(one), ofTwo = TexelsOf(two);
    for (size_t i = 0; i < red.size(); i += 4) {
        EXPECT_EQ(
            (Texels{red.begin() + static_cast<ptrdiff_t>(i), red.begin() + static_cast<ptrdiff_t>(i + 4)}),
            (Texels{ofOne[i], 0, 0, 255}));
        EXPECT_EQ((Texels{redGreen.begin() + static_cast<ptrdiff_t>(i),
                          redGreen.begin() + static_cast<ptrdiff_t>(i + 4)}),
                  (Texels{ofTwo[i], ofTwo[i + 3], 0, 255}));
    }
}

// Writers store for a file of two channels the swizzle of the decoded slices.
TEST(BasisLz, SwizzleIsOfTheSlicesNotOfTheirChannels) {
    BasisPicture two = RandomBasisPicture(8, 8, true, 5);
    two.channels = {3, 4};
    BasisFile file = CompressBasis(two);
    file.desc.keys = {{"KTXswizzle", "ra01"}};
    EXPECT_EQ(DecodeImage8(MakeKtx2(file.desc, file.level), "a.ktx2").rgba, Decode(two));
}

std::string BasisRefusal(const BasisFile& file) {
    return Refusal("a.ktx2", [&] { DecodeImage8(MakeKtx2(file.desc, file.level), "a.ktx2"); });
}

TEST(BasisLz, MalformedFilesAreRefusedByTheirPart) {
    const BasisPicture picture = RandomBasisPicture(64, 64, false, 8);
    const BasisFile good = CompressBasis(picture);
    BasisFile file = good;
    file.level.resize(file.level.size() / 2);
    PutNumber(file.desc.global, 0);  // nothing is read beyond the parts
    const size_t lengthAt = 20 + 8;
    EXPECT_EQ(BasisRefusal(file), "a.ktx2: BasisLZ: the color slice of " + std::to_string(good.level.size()) +
                                      " bytes at 0 lies outside its level of " +
                                      std::to_string(file.level.size()));
    file = good;
    file.desc.global[lengthAt] = std::byte{4};
    for (size_t i = 1; i < 4; ++i) file.desc.global[lengthAt + i] = std::byte{0};
    EXPECT_EQ(BasisRefusal(file), "a.ktx2: BasisLZ: the color slice is truncated");
    file = good;
    file.desc.global.resize(30);
    EXPECT_EQ(BasisRefusal(file), "a.ktx2: BasisLZ: the global data is truncated");
    file = good;
    file.desc.global[0] = file.desc.global[1] = std::byte{0};
    EXPECT_EQ(BasisRefusal(file), "a.ktx2: BasisLZ: the global data has no colors or no patterns");
    file = good;
    file.desc.global[1] = std::byte{200};
    EXPECT_EQ(BasisRefusal(file), "a.ktx2: BasisLZ: the list of colors is truncated");
    file = good;
    file.desc.global[20] = std::byte{2};
    EXPECT_EQ(BasisRefusal(file), "a.ktx2: BasisLZ: frames of a video are not supported");
}

// The first block's predictors are left (0), above (1) and both (2), none of which exists.
TEST(BasisLz, ReferencesOutsideThePictureAreRefused) {
    BasisPicture picture{.width = 8, .height = 8, .colors = {{{1, 2, 3}, 4}, {}}, .patterns = {7}};
    picture.color.colors = {0, 1, 0, 1};
    picture.color.patterns = {0, 0, 0, 0};
    BasisFile file = CompressBasis(picture);
    // The first symbol, of 8 bits or 9, is the four predictions; all zeros is the symbol 0
    file.level[0] = std::byte{0};
    EXPECT_EQ(BasisRefusal(file), "a.ktx2: BasisLZ: the color slice refers to a block outside the picture");
}

}  // namespace
}  // namespace raygraph::test::basis_lz_test

// Files of GPU textures.
#include <gtest/gtest.h>

#include <zstd.h>
#include <cmath>
#include <random>

#include "tests/image/image_files.h"
#include "tests/image/texture_files.h"
#include "tests/image/uastc_writer.h"

namespace raygraph::test::dds_test {
namespace {

using image::DecodeImage8;
using image::Image8;
using Texels = std::vector<uint8_t>;

Image8 Decode(const DdsDesc& desc, const Texels& texels) {
    return DecodeImage8(MakeDds(desc, texels), "a.dds");
}

std::string DdsRefusal(const DdsDesc& desc, const Texels& texels = Texels(64)) {
    return Refusal("a.dds", [&] { Decode(desc, texels); });
}

TEST(Dds, PlainTexelsAreReadByTheirMasks) {
    const Image8 rgba = Decode({.width = 2, .height = 1}, {1, 2, 3, 4, 5, 6, 7, 8});
    EXPECT_EQ(rgba.width, 2u);
    EXPECT_EQ(rgba.height, 1u);
    EXPECT_EQ(rgba.rgba, (Texels{1, 2, 3, 4, 5, 6, 7, 8}));
    const DdsDesc bgra{.width = 1, .height = 1, .masks = {0xFF0000, 0xFF00, 0xFF, 0xFF000000}};
    EXPECT_EQ(Decode(bgra, {1, 2, 3, 4}).rgba, (Texels{3, 2, 1, 4}));
    DdsDesc bgrx = bgra;
    bgrx.formatFlags = 0x40;
    EXPECT_EQ(Decode(bgrx, {1, 2, 3, 4}).rgba, (Texels{3, 2, 1, 255}))
        << "without the flag there is no alpha";
    const DdsDesc bgr{
        .width = 1, .height = 2, .bitCount = 24, .masks = {0xFF0000, 0xFF00, 0xFF, 0}, .formatFlags = 0x40};
    EXPECT_EQ(Decode(bgr, {1, 2, 3, 4, 5, 6}).rgba, (Texels{3, 2, 1, 255, 6, 5, 4, 255}));
    const DdsDesc gray{
        .width = 2, .height = 1, .bitCount = 8, .masks = {0xFF, 0, 0, 0}, .formatFlags = 0x20000};
    EXPECT_EQ(Decode(gray, {7, 9}).rgba, (Texels{7, 7, 7, 255, 9, 9, 9, 255}));
    const DdsDesc grayAlpha{
        .width = 1, .height = 1, .bitCount = 16, .masks = {0xFF, 0, 0, 0xFF00}, .formatFlags = 0x20001};
    EXPECT_EQ(Decode(grayAlpha, {7, 9}).rgba, (Texels{7, 7, 7, 9}));
}

TEST(Dds, PlainTexelsAreReadByTheirDxgiFormat) {
    const auto one = [](uint32_t format) {
        return Decode({.width = 1, .height = 1, .dxgiFormat = format}, {1, 2, 3, 4}).rgba;
    };
    EXPECT_EQ(one(kDxgiRgba8), (Texels{1, 2, 3, 4}));
    EXPECT_EQ(one(kDxgiRgba8Srgb), (Texels{1, 2, 3, 4}));
    EXPECT_EQ(one(kDxgiBgra8), (Texels{3, 2, 1, 4}));
    EXPECT_EQ(one(kDxgiBgrx8), (Texels{3, 2, 1, 255}));
    EXPECT_EQ(one(kDxgiRg8), (Texels{1, 2, 0, 255}));
    EXPECT_EQ(one(kDxgiR8), (Texels{1, 0, 0, 255}));
}

// The block has the colors or values 255 and 0, and its first 8 bytes encode alpha in the same way.
const Texels kColors{0xFF, 0xFF, 0, 0, 0xE4, 0xE4, 0xE4, 0xE4};
const Texels kValues{255, 0, 0x88, 0xC6, 0xFA, 0x88, 0xC6, 0xFA};

Texels Joined(const Texels& a, const Texels& b) {
    Texels both = a;
    both.insert(both.end(), b.begin(), b.end());
    return both;
}
Texels FirstTexels(const Image8& image, size_t count) {
    return Texels(image.rgba.begin(), image.rgba.begin() + static_cast<ptrdiff_t>(4 * count));
}

// 8x8 texels take four blocks, and each smaller level takes one.
TEST(Dds, BlocksAreKeptWithTheLevelsThatAreThere) {
    Texels all;
    for (uint8_t i = 0; i < 7 * 8; ++i) all.push_back(i);
    const auto levels = [](const Image8& image) {
        Texels sizes;
        for (const auto& level : image.blocks.levels) sizes.push_back(static_cast<uint8_t>(level.size()));
        return sizes;
    };
    const DdsDesc desc{.width = 8, .height = 8, .fourCc = "DXT1", .levels = 4};
    const Image8 image = Decode(desc, all);
    EXPECT_EQ(image.blocks.coding, image::BlockCoding::Bc1);
    EXPECT_EQ(levels(image), (Texels{32, 8, 8, 8}));
    EXPECT_EQ(image.blocks.levels[0][31], std::byte{31});
    EXPECT_EQ(image.blocks.levels[3][0], std::byte{48});
    // These headers promise more than the file has, or than is possible; have no level; or have no blocks
    EXPECT_EQ(levels(Decode(desc, Texels(all.begin(), all.end() - 1))), (Texels{32, 8, 8}));
    DdsDesc many = desc, one = desc;
    many.levels = 4000000000u;
    one.levels = 0;
    all.resize(100);
    EXPECT_EQ(levels(Decode(many, all)), (Texels{32, 8, 8, 8}));
    EXPECT_EQ(levels(Decode(one, all)), (Texels{32}));
    EXPECT_TRUE(Decode({.width = 2, .height = 1, .levels = 2}, Texels(64)).blocks.IsEmpty());
}

TEST(Dds, BlocksAreReadByTheirName) {
    for (const DdsDesc& desc : {DdsDesc{.fourCc = "DXT1"}, DdsDesc{.dxgiFormat = kDxgiBc1Srgb}})
        EXPECT_EQ(FirstTexels(Decode(desc, kColors), 3),
                  (Texels{255, 255, 255, 255, 0, 0, 0, 255, 170, 170, 170, 255}));
    const Texels hole{0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
    EXPECT_EQ(FirstTexels(Decode({.fourCc = "DXT1"}, hole), 1), (Texels{0, 0, 0, 0}));
    for (const DdsDesc& desc : {DdsDesc{.fourCc = "DXT3"}, DdsDesc{.dxgiFormat = kDxgiBc2}})
        EXPECT_EQ(FirstTexels(Decode(desc, Joined({0xF1, 0, 0, 0, 0, 0, 0, 0}, kColors)), 2),
                  (Texels{255, 255, 255, 17, 0, 0, 0, 255}));
    for (const DdsDesc& desc : {DdsDesc{.fourCc = "DXT5"}, DdsDesc{.dxgiFormat = kDxgiBc3}})
        EXPECT_EQ(FirstTexels(Decode(desc, Joined(kValues, kColors)), 3),
                  (Texels{255, 255, 255, 255, 0, 0, 0, 0, 170, 170, 170, 219}));
    for (const DdsDesc& desc :
         {DdsDesc{.fourCc = "ATI1"}, DdsDesc{.fourCc = "BC4U"}, DdsDesc{.dxgiFormat = kDxgiBc4}})
        EXPECT_EQ(FirstTexels(Decode(desc, kValues), 3),
                  (Texels{255, 0, 0, 255, 0, 0, 0, 255, 219, 0, 0, 255}));
    const Texels same{9, 9, 0, 0, 0, 0, 0, 0};
    for (const DdsDesc& desc :
         {DdsDesc{.fourCc = "ATI2"}, DdsDesc{.fourCc = "BC5U"}, DdsDesc{.dxgiFormat = kDxgiBc5}})
        EXPECT_EQ(FirstTexels(Decode(desc, Joined(kValues, same)), 2),
                  (Texels{255, 9, 0, 255, 0, 9, 0, 255}));
    // Mode 5, with both ends of red at their maximum
    const Texels bc7{0x20, 0xFF, 0x3F, 0, 0, 0x40, 0x81, 0x91, 0x91, 1, 0, 0, 0, 0, 0, 0};
    EXPECT_EQ(FirstTexels(Decode({.dxgiFormat = kDxgiBc7}, bc7), 1)[0], 255);
}

TEST(Dds, PartOfABlockBeyondTheEdgeIsCutOff) {
    Texels blocks;
    for (const uint8_t low : Texels{1, 2, 3, 4}) blocks = Joined(blocks, {low, 0, 0, 0, 0, 0, 0, 0});
    const Image8 image = Decode({.width = 6, .height = 5, .fourCc = "DXT1"}, blocks);
    ASSERT_EQ(image.rgba.size(), 4u * 6 * 5);
    for (uint32_t y = 0; y < 5; ++y)
        for (uint32_t x = 0; x < 6; ++x)
            EXPECT_EQ(image.rgba[4 * (6 * y + x) + 2], std::lround(255 * (1 + x / 4 + 2 * (y / 4)) / 31.0))
                << x << ", " << y;
}

TEST(Dds, LevelsBelowTheFirstAreNotRead) {
    EXPECT_EQ(Decode({.width = 1, .height = 1}, {1, 2, 3, 4, 99, 99, 99, 99}).rgba, (Texels{1, 2, 3, 4}));
}

TEST(Dds, OtherTexturesAreRefusedByName) {
    EXPECT_EQ(DdsRefusal({.caps2 = 0xFE00}), "a.dds: DDS: cube maps are not supported");
    EXPECT_EQ(DdsRefusal({.caps2 = 0x200000}), "a.dds: DDS: volumes are not supported");
    EXPECT_EQ(DdsRefusal({.fourCc = "DXT2"}), "a.dds: DDS: premultiplied alpha is not supported");
    EXPECT_EQ(DdsRefusal({.fourCc = "BC5S"}), "a.dds: DDS: the format \"BC5S\" is not supported");
    EXPECT_EQ(DdsRefusal({.fourCc = "\x1b[3m"}), "a.dds: DDS: the format \"?[3m\" is not supported");
    EXPECT_EQ(DdsRefusal({.dxgiFormat = 95}), "a.dds: DDS: the DXGI format 95 is not supported");
    EXPECT_EQ(DdsRefusal({.dxgiFormat = kDxgiBc7, .dimension = 4}),
              "a.dds: DDS: only 2D textures are supported");
    EXPECT_EQ(DdsRefusal({.dxgiFormat = kDxgiBc7, .miscFlags = 4}),
              "a.dds: DDS: cube maps are not supported");
    EXPECT_EQ(DdsRefusal({.dxgiFormat = kDxgiBc7, .arraySize = 3}),
              "a.dds: DDS: arrays are not supported, and the array's size is 3");
    EXPECT_EQ(DdsRefusal({.dxgiFormat = kDxgiBc7, .alphaMode = 2}),
              "a.dds: DDS: premultiplied alpha is not supported");
    EXPECT_EQ(DdsRefusal({.formatFlags = 2}), "a.dds: DDS: texels without color are not supported");
    EXPECT_EQ(DdsRefusal({.bitCount = 64}), "a.dds: DDS: 64 bits a texel are not supported");
    EXPECT_EQ(DdsRefusal({.bitCount = 16, .masks = {0xF800, 0x7E0, 0x1F, 0}, .formatFlags = 0x40}),
              "a.dds: DDS: the mask 0x0000f800 is none of 8 bits, other texels are not supported");
}

TEST(Dds, SizesThatTheBytesDoNotHoldAreRefused) {
    EXPECT_EQ(DdsRefusal({.width = 4, .height = 5}),
              "a.dds: DDS: 4 x 5 pixels need 80 bytes, and there are 64");
    EXPECT_EQ(DdsRefusal({.width = 16384, .height = 16384, .fourCc = "DXT1"}),
              "a.dds: DDS: 16384 x 16384 pixels need 134217728 bytes, and there are 64");
    EXPECT_EQ(DdsRefusal({.width = 0}), "a.dds: 0 x 4 pixels: the picture is empty");
    Bytes bytes = MakePlainDds(1, 1, {});
    bytes[4] = std::byte{125};
    EXPECT_EQ(Refusal("a.dds", [&] { DecodeImage8(bytes, "a.dds"); }), "a.dds: DDS: the header is malformed");
}

}  // namespace
}  // namespace raygraph::test::dds_test

namespace raygraph::test::ktx2_test {
namespace {

using image::DecodeImage8;
using Texels = std::vector<uint8_t>;

Texels Decode(const Ktx2Desc& desc, const Texels& level) {
    return DecodeImage8(MakeKtx2(desc, level), "a.ktx2").rgba;
}
std::string Ktx2Refusal(const Ktx2Desc& desc, const Texels& level = Texels(64)) {
    return Refusal("a.ktx2", [&] { Decode(desc, level); });
}

Texels Compressed(const Texels& bytes) {
    Texels out(ZSTD_compressBound(bytes.size()));
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
    return out;
}

TEST(Ktx2, PlainTexelsAreReadByTheirFormat) {
    const auto two = [](uint32_t format, const Texels& level) {
        return Decode({.vkFormat = format, .width = 2, .height = 1}, level);
    };
    EXPECT_EQ(two(kVkR8, {1, 2}), (Texels{1, 0, 0, 255, 2, 0, 0, 255}));
    EXPECT_EQ(two(kVkRg8, {1, 2, 3, 4}), (Texels{1, 2, 0, 255, 3, 4, 0, 255}));
    EXPECT_EQ(two(kVkRgb8, {1, 2, 3, 4, 5, 6}), (Texels{1, 2, 3, 255, 4, 5, 6, 255}));
    EXPECT_EQ(two(kVkBgr8, {1, 2, 3, 4, 5, 6}), (Texels{3, 2, 1, 255, 6, 5, 4, 255}));
    for (const uint32_t format : {kVkRgba8, kVkRgba8Srgb})
        EXPECT_EQ(two(format, {1, 2, 3, 4, 5, 6, 7, 8}), (Texels{1, 2, 3, 4, 5, 6, 7, 8}));
    EXPECT_EQ(two(kVkBgra8, {1, 2, 3, 4, 5, 6, 7, 8}), (Texels{3, 2, 1, 4, 7, 6, 5, 8}));
}

// The expected first texel of one block is given for each format.
TEST(Ktx2, BlocksAreReadByTheirFormat) {
    const Texels hole{0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}, red{200, 100, 0, 0, 0, 0, 0, 0};
    const auto first = [](uint32_t format, Texels level, const Texels& second) {
        level.insert(level.end(), second.begin(), second.end());
        const Texels texels = Decode({.vkFormat = format}, level);
        return Texels(texels.begin(), texels.begin() + 4);
    };
    EXPECT_EQ(first(kVkBc1Rgb, hole, {}), (Texels{0, 0, 0, 255}));
    EXPECT_EQ(first(kVkBc1Rgba, hole, {}), (Texels{0, 0, 0, 0}));
    EXPECT_EQ(first(kVkBc2, red, hole), (Texels{170, 170, 170, 136}));
    EXPECT_EQ(first(kVkBc3, red, hole), (Texels{170, 170, 170, 200}));
    EXPECT_EQ(first(kVkBc4, red, {}), (Texels{200, 0, 0, 255}));
    EXPECT_EQ(first(kVkBc5, red, {70, 0, 0, 0, 0, 0, 0, 0}), (Texels{200, 70, 0, 255}));
    const Texels mode5{0x20, 0xFF, 0x3F, 0, 0, 0, 0, 0};
    for (const uint32_t format : {kVkBc7, kVkBc7Srgb})
        EXPECT_EQ(first(format, mode5, Texels(8)), (Texels{255, 0, 0, 0}));
}

// 4x8 texels take two blocks, and each smaller level takes one; with and without Zstandard.
TEST(Ktx2, BlocksAreKeptWithTheLevelsThatAreThere) {
    const Texels first(32, 7), second(16, 8), third(16, 9), fourth(16, 10);
    for (const bool isPacked : {false, true}) {
        const auto stored = [&](const Texels& level) { return isPacked ? Compressed(level) : level; };
        Ktx2Desc desc{.vkFormat = kVkBc7, .width = 4, .height = 8, .levels = 4};
        desc.supercompression = isPacked ? 2 : 0;
        desc.inflatedBytes = 32;
        desc.smaller = {{stored(second), 16}, {stored(third), 16}, {stored(fourth), 16}};
        const auto blocks = [&] { return DecodeImage8(MakeKtx2(desc, stored(first)), "a.ktx2").blocks; };
        const image::BlockLevels all = blocks();
        EXPECT_EQ(all.coding, image::BlockCoding::Bc7);
        ASSERT_EQ(all.levels.size(), 4u);
        EXPECT_EQ(all.levels[0], std::vector<std::byte>(32, std::byte{7}));
        EXPECT_EQ(all.levels[3], std::vector<std::byte>(16, std::byte{10}));
        // A level of the wrong size, and those after it, are left out
        desc.smaller[1] = {stored(first), 32};
        EXPECT_EQ(blocks().levels.size(), 2u);
        // Swizzled blocks would not hold their texels any more
        desc.keys = {{"KTXswizzle", "bgra"}};
        EXPECT_TRUE(blocks().IsEmpty());
    }
    EXPECT_TRUE(DecodeImage8(MakeKtx2({.vkFormat = kVkRgba8}, Texels(64)), "a.ktx2").blocks.IsEmpty());
}

TEST(Ktx2, ZstandardIsInflated) {
    const image::Image8 pattern = Pattern(13, 7);
    const Texels packed = Compressed(pattern.rgba);
    Ktx2Desc desc{.vkFormat = kVkRgba8, .width = 13, .height = 7, .supercompression = 2};
    desc.inflatedBytes = pattern.rgba.size();
    EXPECT_EQ(Decode(desc, packed), pattern.rgba);
    Texels broken = packed;
    broken[4] ^= 0x40;
    EXPECT_NE(Ktx2Refusal(desc, broken).find("a.ktx2: KTX2: Zstandard: "), std::string::npos);
    EXPECT_EQ(Ktx2Refusal(desc, Compressed(Texels(99))),
              "a.ktx2: KTX2: Zstandard: 99 bytes came out, 364 were expected");
    const Ktx2Desc huge{.vkFormat = kVkRgba8,
                        .width = 8192,
                        .height = 8192,
                        .supercompression = 2,
                        .inflatedBytes = uint64_t{1} << 28};
    EXPECT_EQ(Ktx2Refusal(huge, Texels(64)),
              "a.ktx2: KTX2: 64 bytes of Zstandard cannot hold 8192 x 8192 pixels");
    desc.inflatedBytes = 300;
    EXPECT_EQ(Ktx2Refusal(desc, packed),
              "a.ktx2: KTX2: 13 x 7 pixels need 364 bytes, and the largest level has 300");
}

TEST(Ktx2, SwizzleOfTheFileIsApplied) {
    const auto swizzled = [](const char* swizzle) {
        return Decode({.vkFormat = kVkRg8,
                       .width = 1,
                       .height = 1,
                       .keys = {{"KTXwriter", "x"}, {"KTXswizzle", swizzle}}},
                      {7, 9});
    };
    EXPECT_EQ(swizzled("rrrg"), (Texels{7, 7, 7, 9}));
    EXPECT_EQ(swizzled("01ga"), (Texels{0, 255, 9, 255}));
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRg8, .keys = {{"KTXswizzle", "rgbx"}}}),
              "a.ktx2: KTX2: the swizzle \"rgbx\" is none");
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRg8, .keys = {{"KTXorientation", "ru"}}}),
              "a.ktx2: KTX2: the orientation \"ru\" is not supported, only \"rd\"");
    EXPECT_EQ(Decode({.vkFormat = kVkR8, .width = 1, .height = 1, .keys = {{"KTXorientation", "rd"}}}, {5}),
              (Texels{5, 0, 0, 255}));
}

// Tests a picture of random blocks, with and without Zstandard.
TEST(Ktx2, UastcIsReadByItsChannels) {
    std::mt19937 random(1);
    std::vector<UastcBlock> blocks;
    Texels level;
    for (size_t i = 0; i < 12; ++i) {
        blocks.push_back(RandomUastcBlock(i + 3, random));
        for (const std::byte byte : Pack(blocks.back())) level.push_back(std::to_integer<uint8_t>(byte));
    }
    constexpr uint32_t kWidth = 15, kHeight = 10;
    const auto expect = [&](const Ktx2Desc& desc, const Texels& stored,
                            const std::function<Color(Color)>& see) {
        const Texels texels = Decode(desc, stored);
        ASSERT_EQ(texels.size(), 4u * kWidth * kHeight);
        for (uint32_t y = 0; y < kHeight; ++y)
            for (uint32_t x = 0; x < kWidth; ++x) {
                const Color expected =
                    see(ExpectedTexel(blocks[4 * (y / 4) + x / 4], 4 * (y % 4) + x % 4, desc.isSrgb));
                const size_t at = 4 * (kWidth * y + x);
                ASSERT_EQ((Color{texels[at], texels[at + 1], texels[at + 2], texels[at + 3]}), expected)
                    << x << ", " << y;
            }
    };
    Ktx2Desc desc{.width = kWidth, .height = kHeight, .model = kUastc, .channels = {3}};
    const auto same = [](const Color& c) { return c; };
    for (const bool isSrgb : {false, true}) {
        desc.isSrgb = isSrgb;
        expect(desc, level, same);
    }
    Ktx2Desc packed = desc;
    packed.supercompression = 2;
    packed.inflatedBytes = level.size();
    expect(packed, Compressed(level), same);
    const auto with = [&](uint32_t channel) {
        desc.channels = {channel};
        return desc;
    };
    expect(with(0), level, [](const Color& c) { return Color{c[0], c[1], c[2], 255}; });
    expect(with(4), level, [](const Color& c) { return Color{c[0], 0, 0, 255}; });
    expect(with(5), level, [](const Color& c) { return Color{c[0], c[3], 0, 255}; });
    expect(with(6), level, [](const Color& c) { return Color{c[0], c[1], 0, 255}; });
    desc.channels = {0};
    Texels broken = level;
    broken[16 * 5] = 0x45;  // the reserved mode
    EXPECT_EQ(Ktx2Refusal(desc, broken), "a.ktx2: the block at (4, 4) is invalid");
}

TEST(Ktx2, OtherTexturesAreRefusedByName) {
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRgba8, .depth = 2}), "a.ktx2: KTX2: volumes are not supported");
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRgba8, .layers = 2}),
              "a.ktx2: KTX2: arrays are not supported, and there are 2 layers");
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRgba8, .faces = 6}),
              "a.ktx2: KTX2: only 2D textures are supported, and there are 6 faces");
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRgba8, .levels = 32}), "a.ktx2: KTX2: 32 levels are too many");
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRgba8, .supercompression = 3}),
              "a.ktx2: KTX2: supercompression scheme 3 is not supported");
    EXPECT_EQ(Ktx2Refusal({.vkFormat = 143}), "a.ktx2: KTX2: the Vulkan format 143 is not supported");
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRgba8, .flags = 1}),
              "a.ktx2: KTX2: premultiplied alpha is not supported");
    EXPECT_EQ(Ktx2Refusal({.model = 160, .channels = {0}}),
              "a.ktx2: KTX2: has no Vulkan format, and its color model 160 is not supported");
    EXPECT_EQ(Ktx2Refusal({.model = kUastc, .channels = {9}}),
              "a.ktx2: KTX2: the channel 9 of its data format descriptor is not supported");
    EXPECT_EQ(Ktx2Refusal({.model = kEtc1s, .channels = {0, 3}}),
              "a.ktx2: KTX2: the channels of its data format descriptor are not supported");
    const std::string together = "a.ktx2: KTX2: ETC1S and BasisLZ go together, and this file has one of them";
    EXPECT_EQ(Ktx2Refusal({.model = kEtc1s, .channels = {0}}), together);
    EXPECT_EQ(Ktx2Refusal({.supercompression = 1, .model = kUastc, .channels = {0}}), together);
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRgba8, .supercompression = 1}), together);
}

TEST(Ktx2, PartsOutsideTheFileAreRefused) {
    const Bytes good = MakeKtx2({.vkFormat = kVkRgba8, .keys = {{"KTXwriter", "x"}}}, Texels(64));
    const auto refusal = [&](size_t at, uint8_t value) {
        Bytes bytes = good;
        bytes[at] = std::byte{value};
        return Refusal("a", [&] { DecodeImage8(bytes, "a"); });
    };
    const std::string size = std::to_string(good.size());
    EXPECT_EQ(refusal(48 + 3, 1).substr(0, 47), "a: KTX2: the data format descriptor of 28 bytes");
    EXPECT_EQ(refusal(52, 20), "a: KTX2: the data format descriptor is too short");
    EXPECT_EQ(refusal(60 + 3, 0xFF).substr(0, 32), "a: KTX2: the key/value data of 4");
    EXPECT_EQ(refusal(64 + 7, 0xFF),
              "a: KTX2: the global data of 0 bytes at 18374686479671623680 lies outside the file of " + size);
    EXPECT_EQ(refusal(80 + 15, 0xFF).substr(0, 42), "a: KTX2: the largest level of 183746864796");
    EXPECT_EQ(refusal(80 + 24 + 28, 200), "a: KTX2: the key/value data is malformed");
    EXPECT_EQ(Ktx2Refusal({.vkFormat = kVkRgba8, .width = 5}),
              "a.ktx2: KTX2: 5 x 4 pixels need 80 bytes, and the largest level has 64");
}

}  // namespace
}  // namespace raygraph::test::ktx2_test

// Tests that ETC1S with BasisLZ decodes what the tests' own encoder has written.
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

#include <gtest/gtest.h>

#include <cmath>

#include "tests/image/image_files.h"
#include "tests/image/texture_files.h"

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

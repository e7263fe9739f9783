#include <gtest/gtest.h>
#include <zstd.h>

#include <random>

#include "tests/image/image_files.h"
#include "tests/image/texture_files.h"
#include "tests/image/uastc_writer.h"

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

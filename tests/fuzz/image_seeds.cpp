// Makes seeds of pictures: a small one of every kind that is read.
#include <zstd.h>

#include <algorithm>
#include <iterator>
#include <random>

#include "tests/fuzz/seeds.h"
#include "tests/image/image_files.h"
#include "tests/image/texture_files.h"
#include "tests/image/uastc_writer.h"

namespace raygraph::fuzz {

namespace {

constexpr uint32_t kWidth = 7, kHeight = 5;

std::vector<uint8_t> WithoutAlpha(const image::Image8& image) {
    std::vector<uint8_t> rgb;
    for (size_t i = 0; i < image.rgba.size(); ++i)
        if (i % 4 != 3) rgb.push_back(image.rgba[i]);
    return rgb;
}

// Makes two by two blocks, of four modes.
std::vector<uint8_t> UastcLevel(size_t firstMode) {
    std::mt19937 random(1);
    std::vector<uint8_t> level;
    for (size_t mode = firstMode; mode < firstMode + 4; ++mode)
        for (const std::byte byte : test::Pack(test::RandomUastcBlock(mode % 19, random)))
            level.push_back(std::to_integer<uint8_t>(byte));
    return level;
}

Bytes Zstandard(test::Ktx2Desc desc, std::span<const uint8_t> level) {
    std::vector<uint8_t> packed(ZSTD_compressBound(level.size()));
    packed.resize(ZSTD_compress(packed.data(), packed.size(), level.data(), level.size(), 3));
    desc.supercompression = 2;
    desc.inflatedBytes = level.size();
    return test::MakeKtx2(desc, packed);
}

std::vector<Seed> Ktx2Seeds() {
    const std::vector<uint8_t> texels(size_t{4} * kWidth * kHeight, 99);
    const test::Ktx2Desc plain{.vkFormat = test::kVkRgba8, .width = kWidth, .height = kHeight};
    test::Ktx2Desc swizzled = plain;
    swizzled.keys = {{"KTXorientation", "rd"}, {"KTXswizzle", "rrr1"}};
    test::Ktx2Desc bc1 = plain, uastc = plain;
    bc1.vkFormat = test::kVkBc1Rgb;
    uastc.vkFormat = 0;
    uastc.model = test::kUastc;
    uastc.channels = {3};
    std::vector<Seed> seeds = {
        {"plain.ktx2", test::MakeKtx2(plain, texels)},
        {"swizzled.ktx2", test::MakeKtx2(swizzled, texels)},
        {"bc1.ktx2", test::MakeKtx2(bc1, std::span(texels).first(32))},
        {"zstd.ktx2", Zstandard(plain, texels)},
        {"uastc_zstd.ktx2", Zstandard(uastc, UastcLevel(0))},
    };
    for (size_t mode = 0; mode < 19; mode += 4)
        seeds.push_back({"uastc" + std::to_string(mode) + ".ktx2", test::MakeKtx2(uastc, UastcLevel(mode))});
    for (const uint32_t seed : {1, 2, 3, 4, 5, 6})
        seeds.push_back({"etc1s" + std::to_string(seed) + ".ktx2",
                         test::MakeBasisLz(test::RandomBasisPicture(12 + seed, 9, seed % 2 == 0, seed))});
    return seeds;
}

}  // namespace

std::vector<Seed> ImageSeeds() {
    const image::Image8 pattern = test::Pattern(kWidth, kHeight);
    const std::vector<uint8_t> rgb = WithoutAlpha(pattern);
    const std::vector<uint8_t> bits{0, 1, 2, 3, 4};
    const std::vector<uint8_t> wide(size_t{8} * kWidth * kHeight, 77);
    std::vector<Seed> seeds = {
        {"rgba.png", test::MakePng({.width = kWidth, .height = kHeight}, pattern.rgba)},
        {"interlaced.png",
         test::MakePng({.width = kWidth, .height = kHeight, .isInterlaced = true}, pattern.rgba)},
        {"deep.png", test::MakePng({.width = kWidth, .height = kHeight, .bitDepth = 16}, wide)},
        {"palette.png", test::MakePng({.width = 5,
                                       .colorType = 3,
                                       .palette = {1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 1, 1, 9, 9, 9},
                                       .transparency = {9}},
                                      bits)},
        {"gray.png", test::MakePng({.width = 5, .colorType = 0, .transparentColor = {2}}, bits)},
        {"bits.png", test::MakePng({.width = 8, .colorType = 0, .bitDepth = 1}, std::vector<uint8_t>{0x5A})},
        {"baseline.jpg", test::MakeJpeg(test::JpegKind::Rgb, kWidth, kHeight, rgb)},
        {"gray.jpg", test::MakeJpeg(test::JpegKind::Gray, kWidth, kHeight,
                                    std::span(pattern.rgba).first(kWidth * kHeight))},
        {"progressive.jpg", test::MakeJpeg(test::JpegKind::ProgressiveRgb, kWidth, kHeight, rgb)},
        {"scans.jpg", test::MakeJpeg(test::JpegKind::RgbInThreeScans, kWidth, kHeight, rgb)},
        {"restarted.jpg", test::MakeJpeg(test::JpegKind::RestartedRgb, kWidth, kHeight, rgb)},
        {"arithmetic.jpg", test::MakeJpeg(test::JpegKind::ArithmeticRgb, kWidth, kHeight, rgb)},
        {"plain_cmyk.jpg", test::MakeJpeg(test::JpegKind::PlainCmyk, kWidth, kHeight, pattern.rgba)},
        {"adobe_cmyk.jpg", test::MakeJpeg(test::JpegKind::AdobeCmyk, kWidth, kHeight, pattern.rgba)},
        {"lossless.webp", test::MakeLosslessWebp(pattern)},
        {"lossy.webp", test::MakeLossyWebp(pattern, 80.0f)},
        {"plain.dds", test::MakeDds({.width = kWidth, .height = kHeight}, pattern.rgba)},
        {"gray.dds",
         test::MakeDds({.width = 5, .height = 1, .bitCount = 8, .masks = {0xFF}, .formatFlags = 0x20000},
                       bits)},
        {"bc1.dds", test::MakeDds({.width = kWidth, .height = kHeight, .fourCc = "DXT1"},
                                  std::span(pattern.rgba).first(32))},
        {"bc3.dds", test::MakeDds({.width = kWidth, .height = kHeight, .fourCc = "DXT5"},
                                  std::span(pattern.rgba).first(64))},
        {"bc5.dds", test::MakeDds({.width = kWidth, .height = kHeight, .fourCc = "ATI2"},
                                  std::span(pattern.rgba).first(64))},
        {"bc7.dds", test::MakeDds({.width = kWidth, .height = kHeight, .dxgiFormat = test::kDxgiBc7},
                                  std::span(pattern.rgba).first(64))},
    };
    std::ranges::move(Ktx2Seeds(), std::back_inserter(seeds));
    // These are the PNG and JPEG files without their end markers
    for (size_t i = 0, count = seeds.size(); i < count; ++i) {
        const bool isPng = seeds[i].name.ends_with(".png");
        if (!isPng && !seeds[i].name.ends_with(".jpg")) continue;
        Seed cutOff{"cut_off_" + seeds[i].name, seeds[i].bytes};
        cutOff.bytes.resize(cutOff.bytes.size() - (isPng ? 12 : 2));
        seeds.push_back(std::move(cutOff));
    }
    return seeds;
}

std::vector<Seed> EnvironmentSeeds() {
    const image::Image8 pattern = test::Pattern(kWidth, kHeight);
    std::vector<uint8_t> runs;
    for (uint32_t y = 0; y < kHeight; ++y) {
        runs.insert(runs.end(), {2, 2, 0, 12});
        for (int c = 0; c < 4; ++c) runs.insert(runs.end(), {128 + 8, 100, 4, 1, 2, 3, 4});
    }
    const std::vector<uint8_t> oldRuns{1, 2, 3, 129, 1, 1, 1, kWidth * kHeight - 1};
    std::vector<Seed> seeds = {
        {"flat.hdr", test::MakeHdr(kWidth, kHeight, pattern.rgba, "EXPOSURE=2\nGAMMA=1\n")},
        {"runs.hdr", test::MakeHdr(12, kHeight, runs)},
        {"old_runs.hdr", test::MakeHdr(kWidth, kHeight, oldRuns)},
    };
    std::vector<std::vector<float>> planes(3);
    for (size_t i = 0; i < kWidth * kHeight; ++i)
        for (auto& plane : planes) plane.push_back(static_cast<float>(i * 31 % 17));
    for (int method = 0; method < Imf::NUM_COMPRESSION_METHODS; ++method)
        for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT})
            seeds.push_back({"lines" + std::to_string(method) + (type == Imf::HALF ? "h" : "f") + ".exr",
                             test::MakeExr({.width = kWidth,
                                            .height = kHeight,
                                            .type = type,
                                            .compression = static_cast<Imf::Compression>(method)},
                                           planes)});
    seeds.push_back(
        {"tiles.exr", test::MakeExr({.width = kWidth, .height = kHeight, .tileSize = 4}, planes)});
    seeds.push_back({"uint.exr", test::MakeExr({.minX = -2,
                                                .minY = 3,
                                                .width = kWidth,
                                                .height = kHeight,
                                                .channels = {"Y", "A"},
                                                .type = Imf::UINT},
                                               std::span(planes).first(2))});
    // Data windows that lie within the picture, reach beyond all of its sides, and lie outside of it
    for (const std::array<int, 4>& picture : {std::array{-3, -2, 20, 9}, {2, 1, 3, 3}, {50, 50, 60, 60}})
        seeds.push_back({"part" + std::to_string(picture[2]) + ".exr",
                         test::MakeExr({.width = kWidth, .height = kHeight, .picture = picture}, planes)});
    seeds.push_back({"aces.exr", test::MakeExr({.width = kWidth,
                                                .height = kHeight,
                                                .chromaticities = {{0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f,
                                                                    -0.077f, 0.32168f, 0.33767f}},
                                                .envmap = 0},
                                               planes)});
    return seeds;
}

}  // namespace raygraph::fuzz

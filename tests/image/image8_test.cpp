// Pictures of eight bits, and how pictures are compared.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>

#include "base/error.h"
#include "base/files.h"
#include "tests/image/image_files.h"
#include "tests/support/error_of.h"
#include "tests/support/image_compare.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::test::image8_test {
namespace {

using image::DecodeImage8;
using image::Image8;

// Returns the largest difference of any channel of two pictures of equal size.
int GreatestDifference(const Image8& a, const Image8& b) {
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.rgba.size(), b.rgba.size());
    int greatest = 0;
    for (size_t i = 0; i < std::min(a.rgba.size(), b.rgba.size()); ++i) {
        greatest = std::max(greatest, std::abs(int{a.rgba[i]} - int{b.rgba[i]}));
    }
    return greatest;
}

// Makes a picture that JPEG compresses with little loss, with `channels` bytes per texel.
std::vector<uint8_t> SmoothTexels(uint32_t width, uint32_t height, uint32_t channels) {
    std::vector<uint8_t> texels;
    for (uint32_t y = 0; y < height; ++y) {
        for (uint32_t x = 0; x < width; ++x) {
            for (uint32_t c = 0; c < channels; ++c) {
                texels.push_back(static_cast<uint8_t>(40 + 3 * x * (c + 1) + 2 * y * (4 - c)));
            }
        }
    }
    return texels;
}

TEST(WritePng, ComesBackExactly) {
    const TemporaryFolder folder;
    for (const auto& [width, height] : {std::pair{1u, 1u}, {3u, 5u}, {64u, 33u}}) {
        Image8 image = Pattern(width, height);
        for (const bool isOpaque : {false, true}) {
            // The color under full transparency counts, too.
            for (size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = isOpaque ? 255 : 0;
            WritePng(folder / "image.png", image);
            const std::vector<std::byte> file = ReadFile(folder / "image.png");
            constexpr size_t kColorType = 25;
            EXPECT_EQ(file.at(kColorType), isOpaque ? std::byte{2} : std::byte{6});
            const Image8 back = DecodeImage8(file, "image.png");
            EXPECT_EQ(back.width, width);
            EXPECT_EQ(back.height, height);
            EXPECT_EQ(back.rgba, image.rgba);
        }
        image.rgba.back() = 254;
        WritePng(folder / "image.png", image);
        EXPECT_EQ(DecodeImage8(ReadFile(folder / "image.png"), "image.png").rgba, image.rgba);
    }
}

TEST(WritePng, FileIsMarkedSrgb) {
    const TemporaryFolder folder;
    WritePng(folder / "image.png", Pattern(4, 4));
    Find(ReadFile(folder / "image.png"), "sRGB");
}

TEST(WritePng, SizeMustMatchTheTexels) {
    const TemporaryFolder folder;
    for (const Image8& wrong : {Image8{}, Image8{2, 2, std::vector<uint8_t>(15)}, Image8{0, 2, {}}}) {
        EXPECT_THROW(WritePng(folder / "image.png", wrong), Error);
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "image.png"));
}

TEST(DecodePng, GrayIsWidenedToRgbWithFullAlpha) {
    const uint8_t rows[] = {0, 127, 255};
    const Image8 image = DecodeImage8(MakePng({.width = 3, .colorType = 0}, rows), "gray.png");
    EXPECT_EQ(image.rgba, (std::vector<uint8_t>{0, 0, 0, 255, 127, 127, 127, 255, 255, 255, 255, 255}));
}

TEST(DecodePng, OneBitGrayReachesBlackAndWhite) {
    const uint8_t rows[] = {0b10100000};
    const Image8 image = DecodeImage8(MakePng({.width = 3, .colorType = 0, .bitDepth = 1}, rows), "bits.png");
    EXPECT_EQ(image.rgba, (std::vector<uint8_t>{255, 255, 255, 255, 0, 0, 0, 255, 255, 255, 255, 255}));
}

TEST(DecodePng, GrayWithAlphaKeepsAlpha) {
    const uint8_t rows[] = {10, 200, 30, 0};
    const Image8 image = DecodeImage8(MakePng({.width = 2, .colorType = 4}, rows), "grayAlpha.png");
    EXPECT_EQ(image.rgba, (std::vector<uint8_t>{10, 10, 10, 200, 30, 30, 30, 0}));
}

TEST(DecodePng, PaletteWithTransparencyIsExpanded) {
    const PngDesc desc{
        .width = 3, .colorType = 3, .palette = {255, 0, 0, 0, 255, 0, 1, 2, 3}, .transparency = {7, 255}};
    const uint8_t rows[] = {1, 0, 2};
    const Image8 image = DecodeImage8(MakePng(desc, rows), "palette.png");
    EXPECT_EQ(image.rgba, (std::vector<uint8_t>{0, 255, 0, 255, 255, 0, 0, 7, 1, 2, 3, 255}));
}

TEST(DecodePng, TransparentColorBecomesAlpha) {
    const PngDesc desc{.width = 2, .colorType = 2, .transparentColor = {1, 2, 3}};
    const uint8_t rows[] = {1, 2, 3, 1, 2, 4};
    const Image8 image = DecodeImage8(MakePng(desc, rows), "key.png");
    EXPECT_EQ(image.rgba, (std::vector<uint8_t>{1, 2, 3, 0, 1, 2, 4, 255}));
}

TEST(DecodePng, SixteenBitsAreRoundedToNearest) {
    std::vector<uint8_t> rows;
    std::vector<uint8_t> expected;
    for (uint32_t value = 0; value < 65536; value += 17) {
        rows.push_back(static_cast<uint8_t>(value >> 8));
        rows.push_back(static_cast<uint8_t>(value));
        const auto rounded = static_cast<uint8_t>(std::lround(value / 257.0));
        expected.insert(expected.end(), {rounded, rounded, rounded, 255});
    }
    const auto width = static_cast<uint32_t>(rows.size() / 2);
    const Image8 image =
        DecodeImage8(MakePng({.width = width, .colorType = 0, .bitDepth = 16}, rows), "deep.png");
    EXPECT_EQ(image.rgba, expected);
}

TEST(DecodePng, InterlacedEqualsPlain) {
    const Image8 pattern = Pattern(19, 13);
    const PngDesc desc{.width = 19, .height = 13, .isInterlaced = true};
    EXPECT_EQ(DecodeImage8(MakePng(desc, pattern.rgba), "interlaced.png").rgba, pattern.rgba);
}

TEST(DecodePng, GammaChunkIsIgnored) {
    const Image8 pattern = Pattern(8, 8);
    const PngDesc desc{.width = 8, .height = 8, .gamma = 1.0};
    EXPECT_EQ(DecodeImage8(MakePng(desc, pattern.rgba), "gamma.png").rgba, pattern.rgba);
}

TEST(DecodeJpeg, RgbIsCloseToTheSource) {
    const auto texels = SmoothTexels(17, 11, 3);
    const Image8 image = DecodeImage8(MakeJpeg(JpegKind::Rgb, 17, 11, texels), "rgb.jpg");
    Image8 expected{17, 11, {}};
    for (size_t i = 0; i < texels.size(); i += 3) {
        expected.rgba.insert(expected.rgba.end(), {texels[i], texels[i + 1], texels[i + 2], 255});
    }
    EXPECT_LE(GreatestDifference(image, expected), 3);
}

TEST(DecodeJpeg, ProgressiveEqualsBaseline) {
    const auto texels = SmoothTexels(33, 20, 3);
    const Image8 baseline = DecodeImage8(MakeJpeg(JpegKind::Rgb, 33, 20, texels), "rgb.jpg");
    const Image8 progressive =
        DecodeImage8(MakeJpeg(JpegKind::ProgressiveRgb, 33, 20, texels), "progressive.jpg");
    EXPECT_EQ(progressive.rgba, baseline.rgba);
}

TEST(DecodeJpeg, GrayIsWidened) {
    const auto texels = SmoothTexels(9, 9, 1);
    const Image8 image = DecodeImage8(MakeJpeg(JpegKind::Gray, 9, 9, texels), "gray.jpg");
    Image8 expected{9, 9, {}};
    for (const uint8_t value : texels) expected.rgba.insert(expected.rgba.end(), {value, value, value, 255});
    EXPECT_LE(GreatestDifference(image, expected), 2);
}

TEST(DecodeJpeg, CmykIsConvertedInBothPolarities) {
    // Ink amounts: cyan 100, magenta 20, yellow 0, black 40 of 255.
    const double ink[] = {100, 20, 0, 40};
    std::vector<uint8_t> plain, adobe;
    for (int i = 0; i < 64; ++i) {
        for (const double amount : ink) {
            plain.push_back(static_cast<uint8_t>(amount));
            adobe.push_back(static_cast<uint8_t>(255 - amount));
        }
    }
    Image8 expected{8, 8, {}};
    for (int i = 0; i < 64; ++i) {
        for (int c = 0; c < 3; ++c) {
            expected.rgba.push_back(static_cast<uint8_t>(std::lround((255 - ink[c]) * (255 - ink[3]) / 255)));
        }
        expected.rgba.push_back(255);
    }
    const Image8 fromPlain = DecodeImage8(MakeJpeg(JpegKind::PlainCmyk, 8, 8, plain), "plain.jpg");
    const Image8 fromAdobe = DecodeImage8(MakeJpeg(JpegKind::AdobeCmyk, 8, 8, adobe), "adobe.jpg");
    EXPECT_LE(GreatestDifference(fromPlain, expected), 2);
    EXPECT_LE(GreatestDifference(fromAdobe, expected), 2);
}

TEST(DecodeWebp, LosslessComesBackExactly) {
    const Image8 pattern = Pattern(23, 9);
    EXPECT_EQ(DecodeImage8(MakeLosslessWebp(pattern), "lossless.webp").rgba, pattern.rgba);
}

TEST(DecodeWebp, LossyIsClose) {
    Image8 gray{32, 32, {}};
    for (int i = 0; i < 32 * 32; ++i) {
        const auto value = static_cast<uint8_t>(60 + i / 8);
        gray.rgba.insert(gray.rgba.end(), {value, value, value, static_cast<uint8_t>(255 - i / 16)});
    }
    EXPECT_LE(GreatestDifference(DecodeImage8(MakeLossyWebp(gray, 95.0f), "lossy.webp"), gray), 6);
}

TEST(DecodeWebp, AnimationIsRefused) {
    // An extended header of a 1 x 1 animation.
    const char header[] = "RIFF\x16\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\0\0\0\0\0\0";
    const Bytes bytes = ToBytes({header, sizeof header - 1});
    EXPECT_EQ(Refusal("a.webp", [&] { DecodeImage8(bytes, "a.webp"); }),
              "a.webp: WebP: animations are not supported");
}

TEST(DecodeImage8, OtherFilesAreRefusedByTheirContent) {
    const auto refusal = [](const Bytes& bytes) { return Refusal("x", [&] { DecodeImage8(bytes, "x"); }); };
    EXPECT_EQ(refusal({}), "x: the file is empty");
    EXPECT_EQ(refusal(ToBytes("GIF89a.....")),
              "x: is of an unknown format, not PNG, JPEG, WebP, DDS or KTX2");
    EXPECT_EQ(refusal(ToBytes("#?RADIANCE\n")), "x: is a Radiance HDR, not PNG, JPEG, WebP, DDS or KTX2");
    EXPECT_EQ(refusal(ToBytes("\x76\x2f\x31\x01")), "x: is an OpenEXR, not PNG, JPEG, WebP, DDS or KTX2");
}

TEST(DecodeImage8, NameWithControlCharactersStaysOnOneLine) {
    EXPECT_EQ(testing::ErrorTextOf([] { DecodeImage8({}, "two\nlines"); }, ErrorKind::BadInput),
              "two?lines: the file is empty");
}

}  // namespace
}  // namespace raygraph::test::image8_test

// Tests the statistics by which other tests judge pictures: correct pictures pass as often as stated, and
// wrong ones are detected.
namespace raygraph::test::image_compare_test {
namespace {

// Draws pixels around a reference with a known variance, which is that of a mean over samples.
struct NoisyPicture {
    uint32_t width, height;
    std::vector<float> reference, variance, mean;

    PlaneView View(const std::vector<float>& plane) const { return {width, height, plane}; }
    ZTestResult Test(double significance) const {
        return ZTest({View(mean), View(variance)}, {View(reference), {}}, {.significance = significance});
    }
};

// `bias` scales the pixels' expectation, `noise` their standard deviation, but not the variance that they
// state.
NoisyPicture Draw(std::mt19937& random, uint32_t width, uint32_t height, double relativeError,
                  double bias = 1.0, double noise = 1.0) {
    std::normal_distribution<double> normal;
    NoisyPicture picture{width, height, {}, {}, {}};
    for (uint32_t i = 0; i < width * height; ++i) {
        const double expected = 0.2 + (i % 17) / 8.0, error = relativeError * expected;
        picture.reference.push_back(static_cast<float>(expected));
        picture.variance.push_back(static_cast<float>(error * error));
        picture.mean.push_back(static_cast<float>(bias * expected + noise * error * normal(random)));
    }
    return picture;
}

TEST(ZTest, RightPictureIsCalledWrongAsOftenAsStated) {
    constexpr int kPictures = 2000;
    constexpr double kSignificance = 0.05;
    std::mt19937 random(1);
    int wrongCount = 0;
    for (int i = 0; i < kPictures; ++i)
        wrongCount += Draw(random, 16, 16, 0.1).Test(kSignificance).HasFailures();
    // The count is binomial: five standard deviations either way are allowed.
    const double deviation = std::sqrt(kPictures * kSignificance * (1 - kSignificance));
    EXPECT_NEAR(wrongCount, kPictures * kSignificance, 5 * deviation);
}

TEST(ZTest, NominalFractionOfARightPictureIsTheSignificance) {
    std::mt19937 random(2);
    const ZTestResult result = Draw(random, 200, 200, 0.1).Test(0.05);
    EXPECT_NEAR(result.nominalFraction, 0.05, 5 * std::sqrt(0.05 * 0.95 / 40000));
    EXPECT_LT(std::abs(result.overallZ), 5.0);
}

TEST(ZTest, BiasOfOnePercentIsFoundByTheSumWhereNoPixelShowsIt) {
    std::mt19937 random(3);
    const ZTestResult result = Draw(random, 200, 200, 0.1, 1.01).Test(0.01);
    EXPECT_FALSE(result.HasFailures());
    EXPECT_GT(result.overallZ, 8.0);
    EXPECT_LT(Draw(random, 200, 200, 0.1, 0.99).Test(0.01).overallZ, -8.0);
}

TEST(ZTest, BiasOfOnePercentFailsAlmostEveryPixelOfAQuietPicture) {
    std::mt19937 random(4);
    EXPECT_GT(Draw(random, 100, 100, 0.001, 1.01).Test(0.01).failedFraction, 0.99);
}

TEST(ZTest, OneWrongPixelIsFoundAndNamed) {
    std::mt19937 random(5);
    NoisyPicture picture = Draw(random, 100, 100, 0.1);
    ASSERT_FALSE(picture.Test(0.01).HasFailures());
    picture.mean[4321] += 8.0f * std::sqrt(picture.variance[4321]);
    const ZTestResult result = picture.Test(0.01);
    EXPECT_EQ(result.failedCount, 1u);
    EXPECT_EQ(result.failedFraction, 1e-4);
    EXPECT_EQ(result.greatestPixel, 4321u);
}

TEST(ZTest, UnderstatedVarianceRaisesTheNominalFraction) {
    std::mt19937 random(6);
    EXPECT_GT(Draw(random, 100, 100, 0.1, 1.0, 1.5).Test(0.05).nominalFraction, 0.15);
}

TEST(ZTest, VarianceOfTheReferenceCounts) {
    const std::vector<float> reference = {1.0f}, mean = {1.5f}, variance = {0.0625f}, large = {0.1875f};
    const auto view = [](const std::vector<float>& plane) { return PlaneView{1, 1, plane}; };
    EXPECT_NEAR(ZTest({view(mean), view(variance)}, {view(reference), {}}).greatestZ, 2.0, 1e-12);
    EXPECT_NEAR(ZTest({view(mean), view(variance)}, {view(reference), view(large)}).greatestZ, 1.0, 1e-12);
}

TEST(ZTest, WithoutVarianceOnlyRoundingPasses) {
    const std::vector<float> reference = {1.0f, 0.0f}, rounded = {1.000001f, 0.0f}, wrong = {1.001f, 0.0f};
    const auto view = [](const std::vector<float>& plane) { return Estimate{{2, 1, plane}, {}}; };
    EXPECT_FALSE(ZTest(view(rounded), view(reference)).HasFailures());
    EXPECT_EQ(ZTest(view(wrong), view(reference)).failedCount, 1u);
}

TEST(ZTest, NonFinitePixelFails) {
    const float bad[] = {std::nanf(""), std::numeric_limits<float>::infinity()};
    const std::vector<float> good = {1.0f, 1.0f}, variance = {1.0f, 1.0f};
    for (const float value : bad) {
        const std::vector<float> broken = {1.0f, value};
        const auto test = [&](const std::vector<float>& mean, const std::vector<float>& varianceOfMean) {
            return ZTest({{2, 1, mean}, {2, 1, varianceOfMean}}, {{2, 1, good}, {}}).failedCount;
        };
        EXPECT_EQ(test(broken, variance), 1u);
        EXPECT_EQ(test(good, broken), 1u);
        EXPECT_EQ(test(good, variance), 0u);
    }
}

TEST(ZTest, ThresholdIsSidakCorrected) {
    EXPECT_NEAR(TwoSidedDeviate(0.05), 1.959963984540054, 1e-9);
    EXPECT_NEAR(TwoSidedProbability(-3.0), 0.0026997960632602, 1e-12);
    std::mt19937 random(7);
    const ZTestResult result = Draw(random, 100, 10, 0.1).Test(0.05);
    EXPECT_NEAR(std::pow(1 - TwoSidedProbability(result.threshold), 1000), 0.95, 1e-9);
}

TEST(ZTest, PlanesMustFit) {
    const std::vector<float> four(4), three(3);
    const Estimate square{{2, 2, four}, {}};
    EXPECT_THROW(ZTest(square, {{4, 1, four}, {}}), std::invalid_argument);
    EXPECT_THROW(ZTest(square, {{2, 2, three}, {}}), std::invalid_argument);
    EXPECT_THROW(ZTest(square, {{2, 2, four}, {1, 3, three}}), std::invalid_argument);
    EXPECT_THROW(Mean({}), std::invalid_argument);
}

TEST(ImageCompare, ClosedValues) {
    const std::vector<float> rgba = {1, 0, 2, 0, 3, 0, 6, 0};
    const PlaneView red{2, 1, rgba, 4}, blue{2, 1, std::span<const float>(rgba).subspan(2), 4};
    EXPECT_EQ(Mean(red), 2.0);
    EXPECT_EQ(Mean(blue), 4.0);
    EXPECT_EQ(MaxAbsDifference(red, blue), 3.0);
    EXPECT_DOUBLE_EQ(RelativeMse(red, blue, 0.0), (1.0 / 4 + 9.0 / 36) / 2);
    EXPECT_DOUBLE_EQ(RelativeMse(red, blue, 5.0), (1.0 / 9 + 9.0 / 41) / 2);
    const std::vector<float> broken = {1, std::nanf("")};
    EXPECT_TRUE(std::isnan(MaxAbsDifference(red, {2, 1, broken})));
}

TEST(ImageCompare, BlocksAtTheEdgeAreMeansOfWhatTheyHold) {
    std::vector<float> values;
    for (int i = 0; i < 5 * 3; ++i) values.push_back(static_cast<float>(i));
    const BlockMeans blocks = MeansOfBlocks({5, 3, values}, 2);
    EXPECT_EQ(blocks.columns, 3u);
    EXPECT_EQ(blocks.rows, 2u);
    EXPECT_EQ(blocks.means, (std::vector<double>{3, 5, 6.5, 10.5, 12.5, 14}));
}

}  // namespace
}  // namespace raygraph::test::image_compare_test

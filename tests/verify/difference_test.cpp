// Pictures that are compared: how they are read, what the numbers of their difference are, and the verdict.
#include "editor/session/verify/difference.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "editor/session/verify/diagnosis.h"
#include "editor/session/verify/verdict.h"
#include "renderer/image/exr.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session::difference_test {

namespace {

using test::TemporaryFolder;

Picture Constant(Extent2D size, float value) {
    Picture picture{.name = "constant", .size = size};
    picture.radiance.assign(4 * PixelCount(size), value);
    return picture;
}

class DifferenceTest : public testing::VulkanTest {};

}  // namespace

TEST(Transfer, Encode_InvertsDecode) {
    for (const char* text : {"srgb", "linear", "gamma:2.2", "gamma:1.8"}) {
        const Transfer transfer = ParseTransfer(text);
        EXPECT_EQ(ToText(transfer), text);
        for (const float code : {0.0f, 0.02f, 0.2f, 0.7f, 1.0f})
            EXPECT_NEAR(transfer.Encode(transfer.Decode(code)), code, 1e-6f) << text;
    }
    // IEC 61966-2-1: half of the code is 21.4 % of the light
    EXPECT_NEAR(Transfer().Decode(0.5f), 0.2140f, 1e-4f);
    for (const char* text : {"", "pq", "gamma", "gamma:9", "gamma:x"})
        EXPECT_EQ(testing::ErrorOf([&] { ParseTransfer(text); }).Kind(), ErrorKind::Usage) << text;
}

TEST(ReadPicture, Png_IsDecodedWithItsExposureAndWhite) {
    const TemporaryFolder folder;
    image::WritePng(folder / "a.png", {2, 1, {128, 0, 255, 255, 64, 254, 10, 255}});
    Transfer transfer;
    transfer.exposureEv = 1.0f;
    const Picture picture = ReadPicture(folder / "a.png", transfer);
    EXPECT_EQ(picture.size, (Extent2D{2, 1}));
    EXPECT_NEAR(picture.radiance[0], 0.5f * Transfer().Decode(128.0f / 255.0f), 1e-6f);
    EXPECT_NEAR(picture.radiance[2], 0.5f, 1e-6f);
    EXPECT_EQ(picture.white, picture.radiance[5]) << "254 is rounded like what is cut at 1";
    // A step of the code, evenly distributed
    const float step = picture.radiance[0] - 0.5f * Transfer().Decode(127.0f / 255.0f);
    EXPECT_NEAR(picture.RoundingVariance(picture.radiance[0]), step * step / 12.0f, 0.02f * step * step);
    EXPECT_TRUE(picture.variance.empty());
}

// Normals and differences have them.
TEST(ReadPicture, Exr_KeepsNegativeValues) {
    const TemporaryFolder folder;
    image::ExrImage file{.width = 1, .height = 1};
    file.channels = {
        {"R", std::vector<float>{-0.5f}}, {"G", std::vector<float>{0.25f}}, {"B", std::vector<float>{-2.0f}}};
    image::WriteExr(folder / "a.exr", file);
    EXPECT_EQ(ReadPicture(folder / "a.exr").radiance, (std::vector<float>{-0.5f, 0.25f, -2.0f, 1.0f}));
}

TEST(ReadPicture, Hdr_IsDividedByItsExposure) {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.hdr", std::ios::binary)
        << "#?RADIANCE\nEXPOSURE=4\nEXPOSURE=0.5\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\x20\x81";
    const Picture picture = ReadPicture(folder / "a.hdr");
    EXPECT_EQ(picture.radiance, (std::vector<float>{0.5f, 0.25f, 0.125f, 1.0f}));
}

TEST(ReadPicture, ExrWithZAlone_IsDepth) {
    const TemporaryFolder folder;
    image::ExrImage file{.width = 2, .height = 1};
    file.channels = {{"Z", std::vector<float>{2.5f, std::numeric_limits<float>::infinity()}}};
    image::WriteExr(folder / "a.exr", file);
    EXPECT_EQ(ReadPicture(folder / "a.exr").radiance,
              (std::vector<float>{2.5f, 2.5f, 2.5f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f}));

    // Beside layers of colors it is not what the picture shows
    for (const char* channel : {"light.R", "light.G", "light.B"})
        file.channels.push_back({channel, std::vector<float>{1.0f, 2.0f}});
    image::WriteExr(folder / "layers.exr", file);
    const Error refused = testing::ErrorOf([&] { ReadPicture(folder / "layers.exr"); });
    EXPECT_EQ(refused.Kind(), ErrorKind::BadInput);
    EXPECT_NE(std::string_view(refused.what()).find("R, G and B are in layers: light; give one"),
              std::string_view::npos)
        << refused.what();
}

TEST(ReadPicture, ExrWithVarianceOfASample_HasThatOfTheMean) {
    const TemporaryFolder folder;
    image::ExrImage file{.width = 2, .height = 1};
    for (const char* channel : {"R", "G", "B"}) {
        file.channels.push_back({channel, std::vector<float>{1.0f, 2.0f}});
        file.channels.push_back({std::string("variance.") + channel, std::vector<float>{8.0f, 4.0f}});
    }
    file.channels.push_back({"samples", std::vector<uint32_t>{4, 8}});
    image::WriteExr(folder / "a.exr", file);
    const Picture picture = ReadPicture(folder / "a.exr");
    EXPECT_EQ(picture.samples, 6u);
    EXPECT_EQ(picture.variance[0], 2.0f);
    EXPECT_EQ(picture.variance[4], 0.5f);
    EXPECT_EQ(testing::ErrorOf([&] { ReadPicture(folder / "none.exr"); }).Kind(), ErrorKind::BadInput);
}

TEST_F(DifferenceTest, ConstantPictures_HaveNumbersByHand) {
    Renderer renderer(Device());
    const Extent2D size{24, 20};
    Picture a = Constant(size, 0.25f), b = Constant(size, 0.3f);
    a.variance.assign(a.radiance.size(), 1e-4f);
    b.variance.assign(b.radiance.size(), 3e-4f);
    const PictureDifference difference = Difference(renderer, a, b);
    EXPECT_NEAR(difference.relMse, 0.0025 / (0.0625 + 0.01), 1e-6);
    EXPECT_NEAR(difference.relMseOfNoise, 4e-4 / (0.0625 + 0.01), 1e-8);
    ASSERT_TRUE(difference.z);
    EXPECT_NEAR(difference.z->rms, 0.05 / 0.02, 1e-4);
    EXPECT_EQ(difference.z->beyondThree, 0.0);
    EXPECT_NEAR(difference.z->ofMean[1], 2.5 * std::sqrt(480.0), 1e-2);
    EXPECT_NEAR(difference.mean[0] / difference.meanOfReference[0], 1.2, 1e-6);
    EXPECT_TRUE(difference.z->isOfBoth);
    // Half of the pixels have no noise: one of these differs, and the others do not count
    Picture partly = a, other = b;
    for (size_t i = 0; i < partly.variance.size() / 2; ++i) {
        partly.variance[i] = other.variance[i] = 0.0f;
        other.radiance[i] = i < 4 ? 0.3f : 0.25f;
    }
    const ZScores halves = *Difference(renderer, partly, other).z;
    EXPECT_NEAR(halves.rms, 0.05 / 0.02, 1e-4);
    EXPECT_EQ(halves.differsWithoutNoise, 3u);
    other.variance.clear();
    EXPECT_FALSE(Difference(renderer, partly, other).z->isOfBoth);
    const double x = Transfer().Encode(0.25f), y = Transfer().Encode(0.3f);
    EXPECT_NEAR(difference.ssim, (2.0 * x * y + 1e-4) / (x * x + y * y + 1e-4), 1e-5);
    EXPECT_GT(difference.flip, 0.02);
    EXPECT_EQ(difference.flipMap.size(), 480u);

    const PictureDifference same = Difference(renderer, a, a);
    EXPECT_EQ(same.relMse, 0.0);
    EXPECT_EQ(same.flip, 0.0);
    EXPECT_NEAR(same.ssim, 1.0, 1e-12);
    EXPECT_FALSE(Difference(renderer, Constant(size, 1.0f), Constant(size, 1.0f)).z);
    // FLIP sees nothing above the display's white but by exposure
    const Picture bright = Constant(size, 2.0f), brighter = Constant(size, 3.0f);
    EXPECT_EQ(Difference(renderer, bright, brighter).flip, 0.0);
    EXPECT_GT(Difference(renderer, bright, brighter, -2.0f).flip, 0.02);
}

TEST_F(DifferenceTest, PicturesOfTwoSizes_AreRefused) {
    Renderer renderer(Device());
    const Error error = testing::ErrorOf([&] {
        Difference(renderer, Constant({4, 4}, 1.0f), Constant({4, 5}, 1.0f));
    });
    EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
    EXPECT_STREQ(error.what(), "constant has 4x5 pixels, and constant has 4x4");
}

TEST_F(DifferenceTest, Verdict_AllowsTheToleranceAndNoMore) {
    Renderer renderer(Device());
    const Extent2D size{64, 64};
    Picture reference = Constant(size, 1.0f);
    const auto judge = [&](const Picture& picture, const Tolerance& tolerance,
                           const std::vector<float>& relative = {}) {
        return Judge(renderer, picture,
                     {.reference = reference, .tolerance = tolerance, .relative = relative});
    };
    const Tolerance five{.relative = 0.05, .energy = 0.05};
    EXPECT_TRUE(judge(Constant(size, 1.04f), five).isRight);
    EXPECT_FALSE(judge(Constant(size, 1.06f), five).isRight);
    // One of 16 tiles
    Picture spot = reference;
    for (uint32_t y = 16; y < 32; ++y)
        for (uint32_t x = 32; x < 48; ++x)
            for (size_t c = 0; c < 3; ++c) spot.radiance[4 * (y * 64 + x) + c] = 1.3f;
    const Verdict verdict = judge(spot, five);
    EXPECT_FALSE(verdict.isRight);
    EXPECT_FALSE(verdict.checks[0].isPassed);
    EXPECT_NEAR(verdict.checks[0].value, 1.0 / 16.0, 1e-12);
    const VerdictTile& worst = *std::ranges::max_element(verdict.tiles, {}, &VerdictTile::excess);
    EXPECT_EQ(worst.x, 32u);
    EXPECT_EQ(worst.y, 16u);
    EXPECT_NEAR(worst.relativeError, 0.3, 1e-5);
    EXPECT_TRUE(judge(spot, {.relative = 0.05, .tiles = 0.1, .pixels = 0.1, .energy = 0.05}).isRight);
    // There, more is allowed, or nothing counts
    for (const float there : {0.4f, std::numeric_limits<float>::infinity()}) {
        std::vector<float> relative(PixelCount(size), 0.05f);
        for (uint32_t y = 16; y < 32; ++y) std::fill_n(&relative[y * 64 + 32], 16, there);
        EXPECT_TRUE(judge(spot, five, relative).isRight) << there;
    }
    std::vector<float> nothing(PixelCount(size), std::numeric_limits<float>::infinity());
    EXPECT_EQ(testing::ErrorOf([&] { judge(spot, five, nothing); }).Kind(), ErrorKind::BadInput);
}

TEST_F(DifferenceTest, Verdict_OfNoiseDependsOnItsVariance) {
    Renderer renderer(Device());
    const Extent2D size{64, 64};
    Picture reference = Constant(size, 1.0f), noisy = reference;
    uint32_t state = 1;
    for (float& value : noisy.radiance) {
        state = state * 1664525u + 1013904223u;
        value += 0.4f * (float(state >> 8) * 0x1p-24f - 0.5f);
    }
    const Tolerance tolerance{.relative = 0.01, .flip = 0.02, .ssim = 0.05};
    const auto judge = [&](float variance) {
        noisy.variance.assign(noisy.radiance.size(), variance);
        return Judge(renderer, noisy, {.reference = reference, .tolerance = tolerance});
    };
    const float right = 0.4f * 0.4f / 12.0f;
    EXPECT_TRUE(judge(right).isRight);
    EXPECT_FALSE(judge(0.05f * right).isRight);
}

// A picture is judged only where it counts: what is masked adds nothing to any number.
TEST_F(DifferenceTest, Masked_PixelsDoNotDilute) {
    Renderer renderer(Device());
    const Extent2D size{64, 32}, half{32, 32};
    const auto whole = Difference(renderer, Constant(half, 0.25f), Constant(half, 0.5f));
    std::vector<float> relative(PixelCount(size), std::numeric_limits<float>::infinity());
    Picture picture = Constant(size, 0.5f);
    for (uint32_t y = 0; y < 32; ++y) {
        std::fill_n(&relative[y * 64], 32, 0.05f);
        picture.radiance[4 * (y * 64 + 40)] = std::numeric_limits<float>::quiet_NaN();
    }
    const Picture reference = Constant(size, 0.25f);
    const Verdict verdict = Judge(renderer, picture, {.reference = reference, .relative = relative});
    EXPECT_NEAR(verdict.difference.relMse, whole.relMse, 1e-9);
    EXPECT_NEAR(verdict.difference.mean[1], 0.5, 1e-9);
    // Windows reach across the border of the mask, where the pictures agree
    EXPECT_GT(verdict.difference.flip, 0.9 * whole.flip);
    EXPECT_LT(verdict.difference.ssim, 0.9);
    EXPECT_FALSE(verdict.isRight);
}

TEST_F(DifferenceTest, PixelsThatAreNoNumbers_FailACheck) {
    Renderer renderer(Device());
    const Extent2D size{32, 32};
    const Picture reference = Constant(size, 1.0f);
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        Picture picture = reference;
        picture.radiance[3] = bad;  // alpha has no meaning
        EXPECT_TRUE(Judge(renderer, picture, {.reference = reference}).isRight);
        picture.radiance[4 * (3 * 32 + 2) + 1] = bad;
        const Verdict verdict = Judge(renderer, picture, {.reference = reference});
        EXPECT_FALSE(verdict.isRight);
        EXPECT_TRUE(verdict.isDecided);
        EXPECT_EQ(verdict.checks.back().name, "nonfinite");
        EXPECT_EQ(verdict.checks.back().value, 1.0);
        EXPECT_EQ(verdict.checks.back().where, "pixels 2,3");
        for (const VerdictCheck& check : verdict.checks)
            EXPECT_TRUE(std::isfinite(check.value)) << check.name;
        EXPECT_EQ(testing::ErrorOf([&] { Difference(renderer, reference, picture); }).Kind(),
                  ErrorKind::BadInput);
    }
}

}  // namespace raygraph::session::difference_test

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/files.h"
#include "tests/image/image_files.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::test::radiance_hdr_test {
namespace {

using image::DecodeEnvironment;
using image::Environment;
using image::ImageF;
using image::ReadEnvironment;

std::string HdrRefusal(const Bytes& bytes) {
    return Refusal("x.hdr", [&] { DecodeEnvironment(bytes, "x.hdr"); });
}

// The 9 texels, in each of the three codings, are eight of (128, 64, 32) * 2^(e - 136), then one of another
// color.
const std::vector<uint8_t> kFlatRow = [] {
    std::vector<uint8_t> row;
    for (int i = 0; i < 8; ++i) row.insert(row.end(), {128, 64, 32, 130});
    row.insert(row.end(), {1, 200, 3, 129});
    return row;
}();
const std::vector<uint8_t> kOldRleRow = {128, 64, 32, 130, 1, 1, 1, 7, 1, 200, 3, 129};
const std::vector<uint8_t> kNewRleRow = {2,  2, 0, 9, 128 + 8, 128, 1,   1,   128 + 8, 64,  1,   200, 128 + 8,
                                         32, 1, 3, 9, 130,     130, 130, 130, 130,     130, 130, 130, 129};

TEST(RadianceHdr, TheThreeCodingsGiveTheSameTexels) {
    std::vector<float> expected;
    for (int i = 0; i < 8; ++i) expected.insert(expected.end(), {2.0f, 1.0f, 0.5f, 1.0f});
    expected.insert(expected.end(), {1.0f / 128, 200.0f / 128, 3.0f / 128, 1.0f});
    for (const auto& row : {kFlatRow, kOldRleRow, kNewRleRow}) {
        const Environment environment = DecodeEnvironment(MakeHdr(9, 1, row), "x.hdr");
        EXPECT_EQ(environment.image.rgba, expected);
        EXPECT_TRUE(environment.warnings.empty());
    }
}

TEST(RadianceHdr, ConsecutiveOldRunsCountInBase256) {
    std::vector<uint8_t> row = {128, 128, 128, 129, 1, 1, 1, 44, 1, 1, 1, 1};  // 1 + 44 + 256 = 301
    const Environment environment = DecodeEnvironment(MakeHdr(301, 1, row), "x.hdr");
    EXPECT_EQ(environment.image.rgba[4 * 300], 1.0f);
}

TEST(RadianceHdr, ExponentZeroIsBlack) {
    const std::vector<uint8_t> row = {255, 255, 255, 0};
    EXPECT_EQ(DecodeEnvironment(MakeHdr(1, 1, row), "x.hdr").image.rgba, (std::vector<float>{0, 0, 0, 1}));
}

TEST(RadianceHdr, MalformedPicturesAreRefused) {
    const auto body = [](std::vector<uint8_t> bytes) { return MakeHdr(9, 1, bytes); };
    EXPECT_NE(HdrRefusal(body({1, 1, 1, 9, 0, 0, 0, 0})).find("starts with a run"), std::string::npos);
    EXPECT_NE(HdrRefusal(body({5, 5, 5, 9, 1, 1, 1, 9})).find("run exceeds"), std::string::npos);
    EXPECT_NE(HdrRefusal(body({2, 2, 0, 8, 9, 9, 9, 9})).find("row of 8 texels"), std::string::npos);
    EXPECT_NE(HdrRefusal(body({2, 2, 0, 9, 128 + 10, 7})).find("run exceeds"), std::string::npos);
    EXPECT_NE(HdrRefusal(body({2, 2, 0, 9, 0, 7})).find("run exceeds"), std::string::npos);
    // Five empty runs in a row would shift out of range.
    std::vector<uint8_t> shifts = {5, 5, 5, 9};
    for (int i = 0; i < 6; ++i) shifts.insert(shifts.end(), {1, 1, 1, 0});
    EXPECT_NE(HdrRefusal(body(shifts)).find("run exceeds"), std::string::npos);
}

TEST(RadianceHdr, OnlyRowsFromTheTopLeftAreRead) {
    for (const char* resolution : {"+Y 1 +X 1", "-Y 1 -X 1", "+X 1 -Y 1", "-Y 1", "-Y 1 +X 1 ", "-Y x +X 1",
                                   "-Y -1 +X 1", "-Y 99999999999 +X 1", ""}) {
        const Bytes bytes =
            ToBytes(std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n") + resolution + "\n....");
        EXPECT_NE(HdrRefusal(bytes).find("resolution"), std::string::npos) << resolution;
    }
    EXPECT_NE(HdrRefusal(ToBytes("#?RADIANCE\n\n-Y 0 +X 1\n....")).find("empty"), std::string::npos);
}

TEST(RadianceHdr, OtherColorFormatIsRefused) {
    const Bytes bytes = ToBytes("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n....");
    EXPECT_NE(HdrRefusal(bytes).find("32-bit_rle_xyze"), std::string::npos);
}

TEST(RadianceHdr, ExposureIsNotAppliedAndSaidSo) {
    const std::vector<uint8_t> row = {128, 128, 128, 129};
    const Environment two = DecodeEnvironment(MakeHdr(1, 1, row, "EXPOSURE= 2.0\n"), "x.hdr");
    EXPECT_EQ(two.image.rgba[0], 1.0f);
    ASSERT_EQ(two.warnings.size(), 1u);
    EXPECT_EQ(two.warnings[0], "x.hdr: EXPOSURE in the header is not applied");
    EXPECT_TRUE(DecodeEnvironment(MakeHdr(1, 1, row, "EXPOSURE=1.0\n"), "x.hdr").warnings.empty());
}

class WriteHdrOfWidth : public ::testing::TestWithParam<uint32_t> {};

// The largest channel has eight bits, so every channel is within 1/256 of it (half of a step, which is at
// most 1/128).
TEST_P(WriteHdrOfWidth, ComesBackWithinHalfAStepAndThenExactly) {
    const TemporaryFolder folder;
    const uint32_t width = GetParam(), height = 5;
    ImageF image{width, height, {}};
    uint32_t state = width;
    const auto random = [&] {
        return static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f;
    };
    for (uint32_t i = 0; i < width * height; ++i) {
        const float scale = std::exp2(60.0f * random() - 30.0f);
        const bool isRun = i % 50 > 20;  // Runs and literals.
        for (int c = 0; c < 3; ++c) {
            image.rgba.push_back(isRun ? 0.25f : scale * random());
        }
        image.rgba.push_back(1.0f);
    }
    WriteHdr(folder / "a.hdr", image);
    const ImageF back = ReadEnvironment(folder / "a.hdr").image;
    ASSERT_EQ(back.rgba.size(), image.rgba.size());
    for (size_t i = 0; i < image.rgba.size(); i += 4) {
        const float greatest = std::max({image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]});
        for (size_t c = 0; c < 3; ++c) {
            ASSERT_LE(std::abs(back.rgba[i + c] - image.rgba[i + c]), greatest / 256) << i;
        }
    }
    WriteHdr(folder / "b.hdr", back);
    EXPECT_EQ(ReadFile(folder / "a.hdr"), ReadFile(folder / "b.hdr"));
}

// The widths are flat, the smallest coded one, and longer than one literal and one run.
INSTANTIATE_TEST_SUITE_P(RadianceHdr, WriteHdrOfWidth, ::testing::Values(1u, 7u, 8u, 127u, 129u, 1000u));

TEST(WriteHdr, ExtremesAreKeptOrClamped) {
    const TemporaryFolder folder;
    const float infinity = std::numeric_limits<float>::infinity();
    const ImageF image{5, 1, {109568.0f,     1.0f,  0.0f,   1.0f,                            //
                              infinity,      0.0f,  0.0f,   1.0f,                            //
                              std::nanf(""), -3.0f, 1.0f,   1.0f, 1e-42f, 0.0f, 0.0f, 1.0f,  //
                              255.75f,       0.0f,  128.0f, 1.0f}};
    WriteHdr(folder / "x.hdr", image);
    const ImageF back = ReadEnvironment(folder / "x.hdr").image;
    EXPECT_EQ(back.rgba[0], 109568.0f);
    EXPECT_EQ(back.rgba[4], 0x1.fep126f);
    EXPECT_EQ(back.rgba[8], 0.0f);
    EXPECT_EQ(back.rgba[9], 0.0f);
    EXPECT_EQ(back.rgba[10], 1.0f);
    EXPECT_EQ(back.rgba[12], 0.0f);
    EXPECT_EQ(back.rgba[16], 256.0f);  // Rounds up to the next exponent.
    EXPECT_EQ(back.rgba[18], 128.0f);
}

}  // namespace
}  // namespace raygraph::test::radiance_hdr_test

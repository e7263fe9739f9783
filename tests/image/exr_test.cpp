// Pictures of a high dynamic range, and environments made of them.
#include <gtest/gtest.h>

#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfThreading.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/files.h"
#include "renderer/image/exr.h"
#include "tests/image/image_files.h"
#include "tests/support/error_of.h"
#include "tests/support/reference_assets.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::test::exr_test {
namespace {

using image::ExrImage;
using image::ExrPlane;

// Makes the channels of a full render, each with bit patterns of every kind: NaNs with payloads, infinities,
// denormals.
ExrImage Render(uint32_t width, uint32_t height) {
    ExrImage image{width, height, {}, {}};
    uint32_t state = 1;
    const auto random = [&] {
        state = state * 1664525u + 1013904223u;
        return state ^ (state >> 16);
    };
    for (const char* name : {"A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "albedo.B", "albedo.G", "albedo.R",
                             "id.instance", "id.material", "samples", "variance.R"}) {
        const std::string_view text = name;
        image::ExrChannel channel{name, {}};
        if (text.starts_with("id.") || text == "samples") {
            std::vector<uint32_t> samples;
            for (uint32_t i = 0; i < width * height; ++i)
                samples.push_back(i % 5 == 0 ? UINT32_MAX : random());
            channel.samples = std::move(samples);
        } else {
            std::vector<float> samples;
            for (uint32_t i = 0; i < width * height; ++i) samples.push_back(std::bit_cast<float>(random()));
            samples[0] = std::bit_cast<float>(0x7fc12345u);
            samples[1] = -std::numeric_limits<float>::infinity();
            samples[2] = std::bit_cast<float>(1u);
            samples[3] = -0.0f;
            channel.samples = std::move(samples);
        }
        image.channels.push_back(std::move(channel));
    }
    image.attributes = {{"raygraph.samples", int32_t{256}},
                        {"raygraph.sampleOffset", int32_t{-7}},
                        {"raygraph.seed", std::string("18446744073709551615")},
                        {"raygraph.exposure", 0.1f},
                        {"raygraph.seconds", 0.1},
                        {"raygraph.device", std::string("A device, with Ünicode")},
                        {"raygraph.note", std::string()},
                        {"an.attribute.with.a.name.longer.than.the.classic.limit", std::string(5000, 'x')}};
    return image;
}

void ExpectSameBits(const ExrImage& a, const ExrImage& b) {
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (size_t c = 0; c < a.channels.size(); ++c) {
        EXPECT_EQ(a.channels[c].name, b.channels[c].name);
        ASSERT_EQ(a.channels[c].samples.index(), b.channels[c].samples.index()) << a.channels[c].name;
        std::visit(
            [&](const auto& samples) {
                const auto& others = std::get<std::decay_t<decltype(samples)>>(b.channels[c].samples);
                ASSERT_EQ(samples.size(), others.size());
                EXPECT_EQ(std::memcmp(samples.data(), others.data(), samples.size() * 4), 0)
                    << a.channels[c].name;
            },
            a.channels[c].samples);
    }
    EXPECT_EQ(a.attributes, b.attributes);
}

TEST(Exr, EveryBitAndAttributeComesBack) {
    const TemporaryFolder folder;
    for (const auto& [width, height] : {std::pair{4u, 1u}, {37u, 53u}, {3u, 700u}}) {
        const ExrImage image = Render(width, height);
        WriteExr(folder / "render.exr", image);
        ExpectSameBits(image::ReadExr(folder / "render.exr"), image);
    }
}

TEST(Exr, SameInputGivesTheSameFile) {
    const TemporaryFolder folder;
    WriteExr(folder / "a.exr", Render(20, 20));
    WriteExr(folder / "b.exr", Render(20, 20));
    EXPECT_EQ(ReadFile(folder / "a.exr"), ReadFile(folder / "b.exr"));
}

TEST(Exr, PlanesAreReadWhereTheyLie) {
    const TemporaryFolder folder;
    std::vector<float> rgba;
    for (int i = 0; i < 6 * 4; ++i) rgba.push_back(static_cast<float>(i));
    const std::vector<uint32_t> ids = {9, 8, 7, 6, 5, 4};
    const std::span<const float> texels(rgba);
    const ExrPlane planes[] = {
        {"albedo.R", texels, 4}, {"albedo.B", texels.subspan(2), 4}, {"id.instance", std::span(ids)}};
    image::WriteExr(folder / "x.exr", 3, 2, planes);
    const ExrImage back = image::ReadExr(folder / "x.exr");
    ASSERT_NE(back.FloatChannel("albedo.B"), nullptr);
    EXPECT_EQ(*back.FloatChannel("albedo.R"), (std::vector<float>{0, 4, 8, 12, 16, 20}));
    EXPECT_EQ(*back.FloatChannel("albedo.B"), (std::vector<float>{2, 6, 10, 14, 18, 22}));
    ASSERT_NE(back.UintChannel("id.instance"), nullptr);
    EXPECT_EQ(*back.UintChannel("id.instance"), ids);
    EXPECT_EQ(back.FloatChannel("id.instance"), nullptr);
    EXPECT_EQ(back.UintChannel("albedo.G"), nullptr);
}

TEST(Exr, WrittenFileIsAnEnvironmentToo) {
    const TemporaryFolder folder;
    const std::vector<float> rgba = {1, 2, 3, 0.5f, 4, 5, 6, 0.25f};
    const std::span<const float> texels(rgba);
    const ExrPlane planes[] = {{"R", texels, 4},
                               {"G", texels.subspan(1), 4},
                               {"B", texels.subspan(2), 4},
                               {"A", texels.subspan(3), 4}};
    image::WriteExr(folder / "x.exr", 2, 1, planes);
    EXPECT_EQ(image::ReadEnvironment(folder / "x.exr").image.rgba, rgba);
}

TEST(Exr, ThePartOfALargerPictureKeepsItsPlace) {
    const TemporaryFolder folder;
    const ExrImage whole = Render(64, 40);
    for (const image::ExrWindow& window :
         {image::ExrWindow{17, 5, 100, 80}, image::ExrWindow{-3, -7, 1, 1}, image::ExrWindow{0, 0, 64, 40}}) {
        ExrImage part = whole;
        part.window = window;
        image::WriteExr(folder / "x.exr", part);
        const ExrImage read = image::ReadExr(folder / "x.exr");
        EXPECT_EQ(read.window, window);
        EXPECT_EQ(read.width, 64u);
        EXPECT_EQ(read.channels.back().samples.index(), whole.channels.back().samples.index());
        EXPECT_EQ(*read.UintChannel("samples"), *whole.UintChannel("samples"));
        const Imf::InputFile file((folder / "x.exr").c_str());
        EXPECT_EQ(file.header().dataWindow().min, Imath::V2i(window.x, window.y));
        EXPECT_EQ(file.header().dataWindow().max, Imath::V2i(window.x + 63, window.y + 39));
        EXPECT_EQ(file.header().displayWindow().max, Imath::V2i(static_cast<int>(window.pictureWidth) - 1,
                                                                static_cast<int>(window.pictureHeight) - 1));
    }
    // Without a window, there are only the pixels
    image::WriteExr(folder / "x.exr", whole);
    EXPECT_EQ(image::ReadExr(folder / "x.exr").window, (image::ExrWindow{0, 0, 64, 40}));
    const auto write = [&](const image::ExrWindow& window) {
        return testing::ErrorTextOf([&] { image::WriteExr(folder / "y.exr", 4, 4, {}, {}, window); });
    };
    EXPECT_NE(write({1 << 29, 0, 9, 9}).find("of a picture of 9 x 9"), std::string::npos);
    EXPECT_NE(write({0, 0, 1u << 31, 9}).find("cannot write pixels"), std::string::npos);
}

TEST(Exr, ThreadsWriteTheSameBytesAndEnd) {
    const TemporaryFolder folder;
    const ExrImage picture = Render(301, 157);
    image::WriteExr(folder / "alone.exr", picture);
    const auto alone = ReadFile(folder / "alone.exr");
    for (const unsigned count : {1u, 2u, 3u, 8u}) {
        {
            const image::ExrThreads threads(count);
            EXPECT_EQ(Imf::globalThreadCount(), count < 2 ? 0 : static_cast<int>(count));
            const image::ExrThreads within(5);  // has no effect
            EXPECT_EQ(Imf::globalThreadCount(), count < 2 ? 5 : static_cast<int>(count));
            image::WriteExr(folder / "x.exr", picture);
            EXPECT_EQ(ReadFile(folder / "x.exr"), alone) << count << " threads";
            const ExrImage read = image::ReadExr(folder / "x.exr");
            EXPECT_EQ(*read.UintChannel("id.instance"), *picture.UintChannel("id.instance"));
        }
        EXPECT_EQ(Imf::globalThreadCount(), 0);
    }
    // The process's own threads are not changed
    Imf::setGlobalThreadCount(2);
    {
        const image::ExrThreads threads(7);
        EXPECT_EQ(Imf::globalThreadCount(), 2);
    }
    EXPECT_EQ(Imf::globalThreadCount(), 2);
    Imf::setGlobalThreadCount(0);
}

TEST(Exr, HalfPlanesAreRoundedAndClamped) {
    const TemporaryFolder folder;
    const float infinity = std::numeric_limits<float>::infinity();
    const std::vector<float> values = {1.0f, 0.1f, 65504.0f, 65505.0f, -1e9f, infinity, 1e-9f, std::nanf("")};
    const std::vector<uint32_t> ids(8, 70000);
    const std::span<const float> samples(values);
    const uint64_t clamped = image::WriteExr(
        folder / "x.exr", 8, 1,
        std::vector<ExrPlane>{
            {"R", samples, 1, true}, {"Z", samples, 1}, {"id", std::span<const uint32_t>(ids)}});
    EXPECT_EQ(clamped, 3u);
    const ExrImage read = image::ReadExr(folder / "x.exr");
    const std::vector<float>& half = *read.FloatChannel("R");
    EXPECT_EQ(half[0], 1.0f);
    EXPECT_EQ(half[1], 0x1.998p-4f);  // the nearest number with 11 bits
    EXPECT_EQ(half[2], 65504.0f);
    EXPECT_EQ(half[3], 65504.0f);
    EXPECT_EQ(half[4], -65504.0f);
    EXPECT_EQ(half[5], 65504.0f);
    EXPECT_EQ(half[6], 0.0f);
    EXPECT_TRUE(std::isnan(half[7]));
    EXPECT_EQ((*read.FloatChannel("Z"))[3], 65505.0f);
    EXPECT_EQ(*read.UintChannel("id"), ids);
    EXPECT_NE(testing::ErrorTextOf([&] {
                  image::WriteExr(folder / "y.exr", 8, 1,
                                  std::vector<ExrPlane>{{"id", std::span<const uint32_t>(ids), 1, true}});
              }).find("as half floats"),
              std::string::npos);
}

TEST(Exr, HalfIsWidenedExactly) {
    const std::vector<std::vector<float>> planes = {{0.5f, -65504.0f, 0x1p-24f}};
    const ExrDesc desc{.width = 3, .channels = {"Z"}, .type = Imf::HALF};
    EXPECT_EQ(*image::DecodeExr(MakeExr(desc, planes), "x.exr").FloatChannel("Z"), planes[0]);
}

TEST(Exr, TilesAndDataWindowAreRead) {
    std::vector<std::vector<float>> planes(1);
    for (int i = 0; i < 20 * 30; ++i) planes[0].push_back(static_cast<float>(i));
    const ExrDesc desc{
        .minX = 5, .minY = -9, .width = 20, .height = 30, .channels = {"depth"}, .tileSize = 16};
    EXPECT_EQ(*image::DecodeExr(MakeExr(desc, planes), "x.exr").FloatChannel("depth"), planes[0]);
}

TEST(Exr, WhatCannotBeWrittenIsRefusedByName) {
    const TemporaryFolder folder;
    const auto path = folder / "x.exr";
    const std::vector<float> four(4);
    const std::span<const float> samples(four);
    const auto write = [&](std::vector<ExrPlane> planes, image::ExrAttributes attributes = {}) {
        return testing::ErrorTextOf([&] { image::WriteExr(path, 2, 2, planes, attributes); });
    };
    EXPECT_EQ(write({{"R", samples, 2}}), path.string() + ": channel 'R': 4 numbers, 7 needed");
    EXPECT_EQ(write({{"R", samples.first(3), 1}}), path.string() + ": channel 'R': 3 numbers, 4 needed");
    EXPECT_NE(write({{"R", samples, 0}}).find("channel 'R'"), std::string::npos);
    EXPECT_NE(write({{"R", samples}, {"R", samples}}).find("already"), std::string::npos);
    EXPECT_NE(write({{"", samples}}).find("not a name"), std::string::npos);
    EXPECT_NE(write({{std::string(300, 'c'), samples}}).find("not a name"), std::string::npos);
    EXPECT_NE(write({}).find("no channels"), std::string::npos);
    for (const char* reserved : {"channels", "dataWindow", "version", "type", ""}) {
        EXPECT_NE(write({{"R", samples}}, {{reserved, 1}}).find("attribute"), std::string::npos) << reserved;
    }
    EXPECT_NE(testing::ErrorTextOf([&] { image::WriteExr(path, 0, 2, {}); }).find("0 x 2"),
              std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Exr, ReadingAnotherFormatIsRefused) {
    EXPECT_EQ(Refusal("x", [] { image::DecodeExr(ToBytes("hello"), "x"); }), "x: is not an OpenEXR file");
}

}  // namespace
}  // namespace raygraph::test::exr_test

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

namespace raygraph::test::environment_test {
namespace {

using image::DecodeEnvironment;
using image::Environment;
using image::ImageF;

std::string ExrRefusal(const Bytes& bytes) {
    return Refusal("x.exr", [&] { DecodeEnvironment(bytes, "x.exr"); });
}

// Makes smooth planes of whole numbers up to 2000, which are exact in half floats.
std::vector<std::vector<float>> Planes(size_t count, uint32_t width, uint32_t height) {
    std::vector<std::vector<float>> planes(count);
    for (size_t c = 0; c < count; ++c) {
        for (uint32_t i = 0; i < width * height; ++i) {
            const double phase = 0.07 * (i % width) + 0.05 * static_cast<double>((c + 1) * (i / width));
            planes[c].push_back(static_cast<float>(std::floor(1000.0 + 1000.0 * std::sin(phase))));
        }
    }
    return planes;
}

// Interleaves R, G and B planes with an alpha of 1.
std::vector<float> Interleaved(const std::vector<std::vector<float>>& planes) {
    std::vector<float> rgba;
    for (size_t i = 0; i < planes[0].size(); ++i) {
        for (size_t c = 0; c < 4; ++c) rgba.push_back(c < planes.size() ? planes[c][i] : 1.0f);
    }
    return rgba;
}

struct Coding {
    Imf::PixelType type;
    Imf::Compression compression;
    uint32_t tileSize;
    double tolerance;  // relative to the largest value; 0: exact
};

class EnvironmentOfCoding : public ::testing::TestWithParam<Coding> {};

TEST_P(EnvironmentOfCoding, ValuesAreRead) {
    const Coding& coding = GetParam();
    const ExrDesc desc{.width = 70,
                       .height = 41,
                       .type = coding.type,
                       .compression = coding.compression,
                       .tileSize = coding.tileSize};
    const auto planes = Planes(3, 70, 41);
    const ImageF image = DecodeEnvironment(MakeExr(desc, planes), "x.exr").image;
    EXPECT_EQ(image.width, 70u);
    EXPECT_EQ(image.height, 41u);
    const auto expected = Interleaved(planes);
    ASSERT_EQ(image.rgba.size(), expected.size());
    double greatest = 0.0;
    for (size_t i = 0; i < expected.size(); ++i) {
        greatest = std::max(greatest, std::abs(double{image.rgba[i]} - expected[i]));
    }
    EXPECT_LE(greatest, coding.tolerance * 2000.0);
}

INSTANTIATE_TEST_SUITE_P(
    Exr, EnvironmentOfCoding,
    ::testing::Values(
        Coding{Imf::FLOAT, Imf::NO_COMPRESSION, 0, 0}, Coding{Imf::HALF, Imf::RLE_COMPRESSION, 0, 0},
        Coding{Imf::FLOAT, Imf::ZIPS_COMPRESSION, 0, 0}, Coding{Imf::UINT, Imf::ZIP_COMPRESSION, 0, 0},
        Coding{Imf::HALF, Imf::PIZ_COMPRESSION, 0, 0}, Coding{Imf::FLOAT, Imf::PXR24_COMPRESSION, 0, 1e-4},
        Coding{Imf::HALF, Imf::B44_COMPRESSION, 0, 0.05}, Coding{Imf::HALF, Imf::B44A_COMPRESSION, 0, 0.05},
        Coding{Imf::FLOAT, Imf::DWAA_COMPRESSION, 0, 0.1}, Coding{Imf::HALF, Imf::DWAB_COMPRESSION, 0, 0.1},
        Coding{Imf::FLOAT, Imf::ZIP_COMPRESSION, 16, 0}, Coding{Imf::HALF, Imf::NO_COMPRESSION, 64, 0}));

TEST(Environment, TallPictureIsReadOverManyChunks) {
    const auto planes = Planes(3, 3, 600);
    const ImageF image = DecodeEnvironment(MakeExr({.width = 3, .height = 600}, planes), "x.exr").image;
    EXPECT_EQ(image.rgba, Interleaved(planes));
}

TEST(Environment, DataWindowMayLieAnywhere) {
    for (const uint32_t tileSize : {0u, 8u}) {
        const ExrDesc desc{.minX = -37,
                           .minY = 1001,
                           .width = 10,
                           .height = 20,
                           .tileSize = tileSize,
                           .picture = {{-37, 1001, -28, 1020}}};
        const auto planes = Planes(3, 10, 20);
        EXPECT_EQ(DecodeEnvironment(MakeExr(desc, planes), "x.exr").image.rgba, Interleaved(planes));
    }
}

// Expects pixel (x, y) of the planes at (x + right, y + down) in a picture of the size of desc.picture, and
// black elsewhere.
void ExpectPlaced(const ImageF& image, const std::vector<std::vector<float>>& planes, const ExrDesc& desc,
                  int right, int down) {
    const auto& box = *desc.picture;
    const int columns = box[2] - box[0] + 1, rows = box[3] - box[1] + 1;
    ASSERT_EQ(image.width, static_cast<uint32_t>(columns));
    ASSERT_EQ(image.height, static_cast<uint32_t>(rows));
    const auto width = static_cast<int>(desc.width), height = static_cast<int>(desc.height);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const int column = x - right, row = y - down;
            const bool isThere = column >= 0 && column < width && row >= 0 && row < height;
            const auto source = static_cast<size_t>(row * width + column);
            for (size_t c = 0; c < 3; ++c)
                ASSERT_EQ(image.rgba[4 * static_cast<size_t>(y * columns + x) + c],
                          isThere ? planes[c][source] : 0.0f)
                    << x << ", " << y;
        }
}

TEST(Environment, CroppedPictureIsPlacedInItsDisplayWindowAndBlackBeyond) {
    const auto planes = Planes(3, 5, 3);
    ExrDesc desc{.minX = 4, .minY = 2, .width = 5, .height = 3, .picture = {{0, 0, 15, 7}}};
    ExpectPlaced(DecodeEnvironment(MakeExr(desc, planes), "x.exr").image, planes, desc, 4, 2);
    desc.picture = {{-6, -1, 9, 6}};
    ExpectPlaced(DecodeEnvironment(MakeExr(desc, planes), "x.exr").image, planes, desc, 10, 3);
}

TEST(Environment, OverscanIsCutOffAndNotLookedAt) {
    auto planes = Planes(3, 8, 6);
    planes[1][0] = std::nanf("");
    const ExrDesc desc{.minX = -1, .minY = -2, .width = 8, .height = 6, .picture = {{0, 0, 3, 2}}};
    ExpectPlaced(DecodeEnvironment(MakeExr(desc, planes), "x.exr").image, planes, desc, -1, -2);
    // The data window reaches beyond the left and the bottom, and leaves the right and the top black
    const ExrDesc both{.minX = -4, .minY = 1, .width = 8, .height = 6, .picture = {{0, 0, 7, 3}}};
    ExpectPlaced(DecodeEnvironment(MakeExr(both, planes), "x.exr").image, planes, both, -4, 1);
}

TEST(Environment, PartThatCannotBePlacedIsRefused) {
    const auto planes = Planes(3, 2, 2);
    const ExrDesc outside{.minX = 8, .minY = 3, .width = 2, .height = 2, .picture = {{0, 0, 7, 3}}};
    EXPECT_EQ(ExrRefusal(MakeExr(outside, planes)),
              "x.exr: EXR: 2 x 2 pixels from 8, 3 on are outside of its picture of 8 x 4");
    const ExrDesc bomb{.width = 2, .height = 2, .picture = {{0, 0, 16383, 8191}}};
    EXPECT_EQ(ExrRefusal(MakeExr(bomb, planes)),
              "x.exr: EXR: 2 x 2 pixels are too few for a picture of 16384 x 8192");
    const ExrDesc huge{.width = 2, .height = 2, .picture = {{-(1 << 29), -(1 << 29), 1 << 29, 1 << 29}}};
    EXPECT_EQ(ExrRefusal(MakeExr(huge, planes)),
              "x.exr: 1073741825 x 1073741825 pixels exceed the limit of 16384 x 16384");
}

constexpr std::array<float, 8> kAces{0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f, 0.32168f, 0.33767f};

TEST(Environment, OtherPrimariesAreConvertedToRec709) {
    // The picture has a pixel of each primary, and a white one
    const std::vector<std::vector<float>> planes = {{1, 0, 0, 2}, {0, 1, 0, 2}, {0, 0, 1, 2}};
    const Bytes bytes = MakeExr({.width = 4, .chromaticities = kAces}, planes);
    const Environment environment = DecodeEnvironment(bytes, "x.exr");
    // The published matrix from ACES2065-1 to linear Rec. 709 by the Bradford transform; colors out of the
    // gamut have a negative part, which becomes 0
    const std::vector<float> expected = {2.521686f, 0, 0,         1, 0, 1.372719f, 0, 1,
                                         0,         0, 1.168353f, 1, 2, 2,         2, 1};
    ASSERT_EQ(environment.image.rgba.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i)
        EXPECT_NEAR(environment.image.rgba[i], expected[i], 2e-5f) << i;
    EXPECT_EQ(environment.warnings.size(), 0u);
    EXPECT_EQ(environment.note, "x.exr: 6 negative values set to 0");
    // A color within the gamut is converted by rows of the same matrix
    const std::vector<std::vector<float>> inside = {{0.5f}, {0.4f}, {0.3f}};
    const ImageF image = DecodeEnvironment(MakeExr({.chromaticities = kAces}, inside), "x.exr").image;
    EXPECT_NEAR(image.rgba[0], 0.5f * 2.521686f - 0.4f * 1.134131f - 0.3f * 0.387555f, 2e-5f);
    EXPECT_NEAR(image.rgba[1], -0.5f * 0.276480f + 0.4f * 1.372719f - 0.3f * 0.096239f, 2e-5f);
    EXPECT_NEAR(image.rgba[2], -0.5f * 0.015378f - 0.4f * 0.152975f + 0.3f * 1.168353f, 2e-5f);
}

TEST(Environment, Rec709AndLuminanceKeepTheirBits) {
    const auto planes = Planes(3, 9, 4);
    const ExrDesc rec709{.width = 9,
                         .height = 4,
                         .chromaticities = {{0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f}}};
    EXPECT_EQ(DecodeEnvironment(MakeExr(rec709, planes), "x.exr").image.rgba, Interleaved(planes));
    const ExrDesc gray{.width = 9, .height = 4, .channels = {"Y"}, .chromaticities = kAces};
    EXPECT_EQ(DecodeEnvironment(MakeExr(gray, std::span(planes).first(1)), "x.exr").image.rgba,
              Interleaved({planes[0], planes[0], planes[0]}));
}

TEST(Environment, PrimariesThatSpanNoColorsAreRefused) {
    const auto planes = Planes(3, 1, 1);
    const float infinity = std::numeric_limits<float>::infinity();
    const std::array<float, 8> broken[] = {
        {0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f},
        {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3f, 0.0f},
        {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, std::nanf(""), 0.3f},
        {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, infinity, 0.31f, 0.33f},
    };
    for (const std::array<float, 8>& chromaticities : broken) {
        const Bytes bytes = MakeExr({.chromaticities = chromaticities}, planes);
        EXPECT_NE(ExrRefusal(bytes).find("hromaticities"), std::string::npos) << ExrRefusal(bytes);
    }
}

TEST(Environment, EnvmapAttributeSaysWhatKindOfMapItIs) {
    constexpr int kLatitudeLongitude = 0, kCube = 1;
    const auto planes = Planes(3, 6, 36);
    const ExrDesc cube{.width = 6, .height = 36, .envmap = kCube};
    EXPECT_EQ(ExrRefusal(MakeExr(cube, planes)),
              "x.exr: EXR: is a cube map by its envmap attribute; an environment is "
              "a latitude-longitude map");
    // OpenEXR defines such a map by its data window
    const ExrDesc sphere{.minX = 3,
                         .minY = 1,
                         .width = 6,
                         .height = 36,
                         .picture = {{0, 0, 99, 49}},
                         .envmap = kLatitudeLongitude};
    const ImageF image = DecodeEnvironment(MakeExr(sphere, planes), "x.exr").image;
    EXPECT_EQ(image.width, 6u);
    EXPECT_EQ(image.rgba, Interleaved(planes));
}

TEST(Environment, AlphaIsKeptAndLuminanceIsGray) {
    const auto planes = Planes(4, 5, 4);
    const Bytes rgba = MakeExr({.width = 5, .height = 4, .channels = {"R", "G", "B", "A"}}, planes);
    EXPECT_EQ(DecodeEnvironment(rgba, "x.exr").image.rgba, Interleaved(planes));
    const auto gray = Planes(1, 5, 4);
    const Bytes y = MakeExr({.width = 5, .height = 4, .channels = {"Y"}}, gray);
    EXPECT_EQ(DecodeEnvironment(y, "x.exr").image.rgba, Interleaved({gray[0], gray[0], gray[0]}));
}

TEST(Environment, ValuesAboveTheHalfRangeAreKept) {
    const std::vector<std::vector<float>> planes = {{109568.0f}, {1e30f}, {65505.0f}};
    EXPECT_EQ(DecodeEnvironment(MakeExr({}, planes), "x.exr").image.rgba,
              (std::vector<float>{109568.0f, 1e30f, 65505.0f, 1.0f}));
}

TEST(Environment, NonFiniteTexelIsRefusedByItsPlace) {
    auto planes = Planes(3, 7, 5);
    planes[1][2 * 7 + 3] = std::nanf("");
    EXPECT_EQ(ExrRefusal(MakeExr({.width = 7, .height = 5}, planes)), "x.exr: pixel (3, 2) is NaN");
    planes[1][2 * 7 + 3] = -std::numeric_limits<float>::infinity();
    EXPECT_EQ(ExrRefusal(MakeExr({.width = 7, .height = 5}, planes)), "x.exr: pixel (3, 2) is infinite");
}

TEST(Environment, NegativeTexelBecomesZeroWithAWarning) {
    auto planes = Planes(3, 7, 5);
    planes[0][8] = -1.0f;
    planes[2][30] = -2.0f;
    const Environment environment = DecodeEnvironment(MakeExr({.width = 7, .height = 5}, planes), "x.exr");
    planes[0][8] = planes[2][30] = 0.0f;
    EXPECT_EQ(environment.image.rgba, Interleaved(planes));
    EXPECT_EQ(environment.warnings.size(), 0u);
    EXPECT_EQ(environment.note, "x.exr: 2 negative values set to 0");
}

TEST(Environment, MissingColorIsRefusedWithWhatThereIs) {
    const auto planes = Planes(3, 2, 2);
    const Bytes bytes = MakeExr({.width = 2, .height = 2, .channels = {"L.R", "L.G", "Z"}}, planes);
    EXPECT_EQ(ExrRefusal(bytes), "x.exr: EXR: no R, G, B and no Y among its channels: L.G L.R Z");
    const Bytes layered =
        MakeExr({.width = 2, .height = 2, .channels = {"L.all.R", "L.all.G", "L.all.B"}}, planes);
    EXPECT_EQ(
        ExrRefusal(layered),
        "x.exr: EXR: R, G and B are in layers: L.all; give one of them in a file of its own, as R, G and B");
    const Bytes chroma = MakeExr({.width = 2, .height = 2, .channels = {"Y", "RY", "BY"}}, planes);
    EXPECT_EQ(ExrRefusal(chroma),
              "x.exr: EXR: luminance with chroma (Y, RY, BY) is not supported, only R, G, B or Y alone");
}

TEST(Environment, SubsampledAndMultiPartFilesAreRefused) {
    const std::vector<std::vector<float>> planes = {std::vector<float>(16), std::vector<float>(4)};
    const ExrDesc desc{.width = 4, .height = 4, .channels = {"Y", "Z"}, .sampling = 2};
    EXPECT_EQ(ExrRefusal(MakeExr(desc, planes)),
              "x.exr: EXR: channel 'Z' is subsampled, which is not supported");
    const Bytes parts = MakeMultiPartExr();
    EXPECT_EQ(ExrRefusal(parts),
              "x.exr: EXR: multi-part files are not supported; its parts: part0 part1; give one of them in a "
              "file of its own");
    for (size_t size = 8; size < parts.size(); ++size)
        EXPECT_THAT(ExrRefusal(Bytes(parts.begin(), parts.begin() + std::ptrdiff_t(size))),
                    ::testing::StartsWith("x.exr: EXR: "));
}

TEST(Environment, OtherFilesAreRefusedByTheirContent) {
    EXPECT_EQ(Refusal("x", [] { DecodeEnvironment(ToBytes("\xff\xd8\xff\xe0"), "x"); }),
              "x: is a JPEG; an environment is Radiance HDR or OpenEXR");
    EXPECT_EQ(Refusal("x", [] { DecodeEnvironment({}, "x"); }), "x: the file is empty");
}

// Uses maps by other programs, from the asset collection.
class EnvironmentAssets : public ::testing::Test {
  protected:
    void SetUp() override {
        RAYGRAPH_SKIP_WITHOUT_ASSETS();
        m_folder = *ReferenceAssets();
    }
    ImageF Read(const char* name) const {
        return image::ReadEnvironment(m_folder / "scenes/env" / name).image;
    }
    const std::filesystem::path& Folder() const { return m_folder; }

  private:
    std::filesystem::path m_folder;
};

TEST_F(EnvironmentAssets, AxesMapHasItsColorsWhereTheConventionSays) {
    const ImageF image = Read("env_axes.exr");
    const auto texel = [&](double x, double y, double z) {
        const double u = 0.5 + std::atan2(z, x) / (2 * M_PI), v = std::acos(y) / M_PI;
        const auto column = static_cast<size_t>(u * image.width) % image.width;
        const auto row = std::min(static_cast<size_t>(v * image.height), size_t{image.height} - 1);
        const float* rgba = image.rgba.data() + 4 * (row * image.width + column);
        return std::array{rgba[0], rgba[1], rgba[2]};
    };
    const auto brightest = [](const std::array<float, 3>& rgb) {
        return std::max_element(rgb.begin(), rgb.end()) - rgb.begin();
    };
    EXPECT_NEAR(texel(1, 0, 0)[0], 1.0f, 0.02f);
    EXPECT_EQ(brightest(texel(1, 0, 0)), 0);
    EXPECT_NEAR(texel(0, 1, 0)[1], 1.0f, 0.02f);
    EXPECT_EQ(brightest(texel(0, 1, 0)), 1);
    EXPECT_NEAR(texel(0, 0, 1)[2], 1.0f, 0.02f);
    EXPECT_EQ(brightest(texel(0, 0, 1)), 2);
    EXPECT_NEAR(texel(-1, 0, 0)[0], 0.25f, 0.02f);
    EXPECT_NEAR(texel(0, -1, 0)[1], 0.25f, 0.02f);
    EXPECT_NEAR(texel(0, 0, -1)[2], 0.25f, 0.02f);
}

TEST_F(EnvironmentAssets, SunAboveTheHalfRangeIsKept) {
    const ImageF image = Read("qwantani_afternoon_puresky_1k.hdr");
    EXPECT_EQ(image.width, 1024u);
    EXPECT_EQ(image.height, 512u);
    EXPECT_EQ(*std::max_element(image.rgba.begin(), image.rgba.end()), 109568.0f);
}

TEST_F(EnvironmentAssets, EveryMapIsRead) {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(Folder() / "scenes/env")) {
        const ImageF image = image::ReadEnvironment(entry.path()).image;
        EXPECT_EQ(image.width, 2 * image.height) << entry.path();
        EXPECT_GT(*std::max_element(image.rgba.begin(), image.rgba.end()), 0.5f) << entry.path();
        ++count;
    }
    EXPECT_GE(count, 5u);
}

TEST_F(EnvironmentAssets, EveryReferenceImageIsRead) {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(Folder() / "references")) {
        if (entry.path().extension() != ".exr") continue;
        const image::ExrImage image = image::ReadExr(entry.path());
        EXPECT_GE(image.channels.size(), 3u) << entry.path();
        ++count;
    }
    EXPECT_GE(count, 5u);
}

}  // namespace
}  // namespace raygraph::test::environment_test

#include "renderer/image/exr.h"

#include <gtest/gtest.h>

#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfThreading.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/files.h"
#include "renderer/image/exr_read.h"
#include "tests/image/image_files.h"
#include "tests/support/error_of.h"
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

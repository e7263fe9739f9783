#include "editor/session/render_file.h"

#include <cmath>
#include <fstream>

#include "renderer/image/exr.h"
#include "tests/cli/cli_test.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::session {
namespace {

using test::ExpectError;
using test::MakeRender;

void ExpectSameColor(const Texels& a, const Texels& b) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); i++) {
        if (i % 4 != 3) {
            EXPECT_EQ(a[i], b[i]) << i;
        }
    }
}

void ExpectSameColor(const passes::ExactSums& a, const passes::ExactSums& b) {
    for (size_t k = 0; k < passes::ExactSums::kPlanes; k++)
        for (size_t i = 0; i < b.sums[k].size(); i++) {
            if (i % 4 != 3) {
                EXPECT_EQ(a.sums[k].at(i), b.sums[k][i]) << i;
            }
        }
}

TEST(RenderFile, ReadsBackWhatWasWrittenBitForBit) {
    const test::TemporaryFolder folder;
    RenderFile written = MakeRender(128, 64);
    written.radiance[4] = 1e-42f;  // a denormal
    written.radiance[8] = INFINITY;
    written.samples = {{0, 3}, {128, 61}};
    const size_t diffuse = static_cast<size_t>(passes::PathPart::Diffuse);
    written.parts[diffuse] = written.normal;
    written.sums.parts[diffuse] = written.sums.normal;
    WriteRenderFile(folder / "a.exr", written);
    const RenderFile read = ReadRenderFile(folder / "a.exr");
    ExpectSameColor(*MeanOf(read, Aov::Diffuse), written.normal);
    EXPECT_EQ(AovsOf(read), AovsOf(written));
    EXPECT_EQ(read.size, written.size);
    EXPECT_EQ(read.radiance, written.radiance);
    ExpectSameColor(read.variance, written.variance);
    EXPECT_TRUE(HasSums(read));
    EXPECT_EQ(read.sums.radiance, written.sums.radiance);
    ExpectSameColor(read.sums.normal, written.sums.normal);
    ExpectSameColor(read.sums.parts[diffuse], written.sums.normal);
    ExpectSameColor(read.albedo, written.albedo);
    ExpectSameColor(read.normal, written.normal);
    EXPECT_EQ(read.depth, written.depth);
    EXPECT_EQ(read.instance, written.instance);
    EXPECT_EQ(read.material, written.material);
    EXPECT_EQ(read.samples, written.samples);
    EXPECT_EQ(read.settings, written.settings);
    EXPECT_EQ(FirstMismatch(read, written), "");
    EXPECT_EQ(read.version, written.version);
    EXPECT_EQ(read.device, written.device);
    EXPECT_EQ(read.driver, written.driver);
}

TEST(RenderFile, ChannelsAndMetadataHaveTheirPublishedNames) {
    const test::TemporaryFolder folder;
    WriteRenderFile(folder / "a.exr", MakeRender(16, 48));
    const image::ExrImage file = image::ReadExr(folder / "a.exr");
    std::vector<std::string> names;
    size_t words = 0;
    for (const image::ExrChannel& channel : file.channels) {
        const bool isWord = channel.name.find("sum") != std::string::npos ||
                            channel.name.find("squares") != std::string::npos;
        words += isWord;
        if (!isWord) names.push_back(channel.name);
    }
    EXPECT_EQ(words, 4u * 4 + 5 * 3 + 4 * 3 + 4 * 3);
    for (const char* name : {"sum0.R", "sum3.A", "squares4.B", "albedo.sum2.G", "N.sum0.X"})
        EXPECT_NE(file.UintChannel(name), nullptr) << name;
    EXPECT_EQ(names, (std::vector<std::string>{"A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "albedo.B",
                                               "albedo.G", "albedo.R", "id.instance", "id.material",
                                               "samples", "variance.B", "variance.G", "variance.R"}));
    const std::vector<uint32_t>* samples = file.UintChannel("samples");
    ASSERT_NE(samples, nullptr);
    EXPECT_EQ((*samples)[7], 48u);
    const auto text = [&](const char* name) { return std::get<std::string>(file.attributes.at(name)); };
    EXPECT_EQ(text("raygraph.format"), "2");
    EXPECT_EQ(text("raygraph.samples"), "48");
    EXPECT_EQ(text("raygraph.sampleOffset"), "16");
    EXPECT_EQ(text("raygraph.sampleRanges"), "16-63");
    EXPECT_EQ(text("raygraph.setting.seed"), "9");
    EXPECT_EQ(text("raygraph.scene"), "box.gltf");
    EXPECT_EQ(text("raygraph.device"), "a device");
    EXPECT_EQ(text("raygraph.driver"), "a driver");
    EXPECT_EQ(text("raygraph.version"), "0.1.0");
}

TEST(RenderFile, RemovedLightNeedsItsVarianceAndCount) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    RenderFile written = MakeRender(0, 40);
    written.removed[1] = written.normal;
    written.removedVariance[1] = written.variance;
    written.removedSamples = 3;
    WriteRenderFile(path, written);
    const RenderFile read = ReadRenderFile(path);
    ExpectSameColor(read.removed[1], written.removed[1]);
    ExpectSameColor(read.removedVariance[1], written.removedVariance[1]);
    EXPECT_EQ(read.removedSamples, 3u);
    EXPECT_TRUE(AovsOf(read).Has(Aov::RemovedClampIndirect));

    image::ExrImage file = image::ReadExr(path);
    EXPECT_NE(file.FloatChannel("removed_clamp_indirect.R"), nullptr);
    file.attributes["raygraph.removedSamples"] = "some";
    image::WriteExr(path, file);
    const auto readAgain = [&] { ReadRenderFile(path); };
    ExpectError(ErrorKind::BadInput, readAgain, "a.exr", "raygraph.removedSamples");
    written.removedVariance[1].clear();
    WriteRenderFile(path, written);
    ExpectError(ErrorKind::BadInput, readAgain, "a.exr", "removed_clamp_indirect", "variance");
}

TEST(RenderFile, ChannelsThatWereNotRenderedAreLeftOut) {
    const test::TemporaryFolder folder;
    RenderFile written = MakeRender(0, 1);
    written.albedo.clear();
    written.normal.clear();
    written.depth.clear();
    written.instance.clear();
    written.material.clear();
    WriteRenderFile(folder / "a.exr", written);
    EXPECT_EQ(image::ReadExr(folder / "a.exr").channels.size(), 8u + 4 * 4 + 5 * 3);
    const RenderFile read = ReadRenderFile(folder / "a.exr");
    EXPECT_TRUE(read.albedo.empty() && read.normal.empty() && read.depth.empty() && read.instance.empty());
}

TEST(RenderFile, WhatIsNoRenderIsBadInputNamingTheFile) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    const auto read = [&] { ReadRenderFile(path); };
    ExpectError(ErrorKind::BadInput, read, "a.exr");  // missing

    std::ofstream(path) << "no picture";
    ExpectError(ErrorKind::BadInput, read, "a.exr");

    image::ExrImage file{2, 1, {{"R", std::vector<float>{1, 2}}}, {}};
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "not a render");

    file.attributes["raygraph.sampleRanges"] = "0-3";
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "older version");
    file.attributes["raygraph.format"] = "3";
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "raygraph.format is 3");
    file.attributes["raygraph.format"] = "2";

    file.attributes["raygraph.sampleRanges"] = "0-x";
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "0-x");

    file.attributes["raygraph.sampleRanges"] = int32_t{4};
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "raygraph.sampleRanges", "not a text");

    file.attributes["raygraph.sampleRanges"] = "0-3";
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "no G");

    for (const char* name : {"G", "B", "A"}) file.channels.push_back({name, std::vector<float>{1, 2}});
    file.channels.push_back({"samples", std::vector<uint32_t>{4, 5}});
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "a pixel has 5 samples, the render 4");

    file.channels.back().samples = std::vector<uint32_t>{4, 4};
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "size 640x360", "2x1");

    file.attributes["raygraph.setting.size"] = "2x1";
    file.attributes["raygraph.setting.seed"] = "twelve";
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "seed", "twelve");

    file.attributes["raygraph.setting.seed"] = "12";
    image::WriteExr(path, file);
    EXPECT_EQ(ReadRenderFile(path).radiance, (Texels{1, 1, 1, 1, 2, 2, 2, 2}));
    EXPECT_FALSE(HasSums(ReadRenderFile(path)));

    file.channels.push_back({"sum0.R", std::vector<uint32_t>{0, 0}});
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "no channel sum1.R");
}

}  // namespace
}  // namespace raygraph::session

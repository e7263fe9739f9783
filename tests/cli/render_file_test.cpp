#include <algorithm>
#include <cmath>
#include <fstream>

#include "base/median.h"
#include "editor/cli/aov_request.h"
#include "editor/cli/resume_settings.h"
#include "editor/session/file/image_statistics.h"
#include "editor/session/file/merge.h"
#include "editor/session/file/render_file.h"
#include "editor/session/file/render_file_parts.h"
#include "editor/session/file/sample_ranges.h"
#include "editor/session/frames/pass_times.h"
#include "renderer/image/exr.h"
#include "tests/cli/cli_test.h"
#include "tests/support/format_of_words.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::session::render_file_test {
namespace {

using test::ExpectError;
using test::MakeRender;

void ExpectSameColor(const Texels& a, const Texels& b) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
        if (i % 4 != 3) {
            EXPECT_EQ(a[i], b[i]) << i;
        }
    }
}

void ExpectSameColor(const passes::ExactSums& a, const passes::ExactSums& b) {
    for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k)
        for (size_t i = 0; i < b.sums[k].size(); ++i) {
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
    EXPECT_EQ(read.motion, written.motion);
    EXPECT_EQ(read.instance, written.instance);
    EXPECT_EQ(read.material, written.material);
    EXPECT_EQ(read.samples, written.samples);
    EXPECT_EQ(read.settings, written.settings);
    EXPECT_EQ(FirstMismatch(read, written), "");
    EXPECT_EQ(read.version, written.version);
    EXPECT_EQ(read.device, written.device);
    EXPECT_EQ(read.driver, written.driver);
}

// Makes a render whose pixels have different numbers of samples, and would get more.
RenderFile MakeAdaptiveRender() {
    RenderFile render = MakeRender(0, 64);
    PictureSettings settings = SettingsFrom(render.settings);
    settings.isAdaptive = true;
    render.settings = Texts(settings);
    AdaptiveState state{.stages = {128, 128}};
    for (uint32_t i = 0; i < 15; ++i) state.counts.push_back(36 + 4 * i);
    for (uint32_t i = 0; i < 15; ++i) state.wanted.push_back(132 + 4 * (i / 2));
    for (const uint32_t base : {32u, 64u})
        for (uint32_t i = 0; i < 15; ++i) {
            const float value = state.counts[i] > base ? 0.5f * static_cast<float>(i) : 0.0f;
            state.noted[base].variance.push_back(value);
            state.noted[base].mean.push_back(2.0f * value);
        }
    render.adaptive = state;
    return render;
}

TEST(RenderFile, AdaptiveRenderHasItsCountsAndWhatComesNext) {
    const test::TemporaryFolder folder;
    const RenderFile written = MakeAdaptiveRender();
    WriteRenderFile(folder / "a.exr", written);
    const RenderFile read = ReadRenderFile(folder / "a.exr");
    ASSERT_TRUE(read.adaptive);
    EXPECT_EQ(*read.adaptive, *written.adaptive);
    EXPECT_EQ(SampleCount(read.samples), 64u);
    const image::ExrImage file = image::ReadExr(folder / "a.exr");
    ASSERT_NE(file.UintChannel("samples"), nullptr);
    EXPECT_EQ(*file.UintChannel("samples"), written.adaptive->counts);
    EXPECT_NE(file.UintChannel("samples.wanted"), nullptr);
    EXPECT_NE(file.FloatChannel("samples.variance32"), nullptr);
    EXPECT_NE(file.FloatChannel("samples.mean64"), nullptr);
    EXPECT_EQ(std::get<std::string>(file.attributes.at("raygraph.adaptiveStage")), "128 128");
    // Without sums it cannot be resumed
    WriteRenderFile(folder / "half.exr", written, {}, ExrType::Half);
    const RenderFile half = ReadRenderFile(folder / "half.exr");
    EXPECT_EQ(half.adaptive->counts, written.adaptive->counts);
    EXPECT_TRUE(half.adaptive->wanted.empty());
}

TEST(RenderFile, CountsThatCannotBeAreRefused) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    const auto expectRefused = [&](const char* part, auto&& change) {
        RenderFile render = MakeAdaptiveRender();
        change(render);
        ExpectError(
            ErrorKind::Usage, [&] { WriteRenderFile(path, render); }, part);
    };
    expectRefused("samples on average", [](RenderFile& r) { r.samples = {{0, 63}}; });
    expectRefused("more samples than it is to have", [](RenderFile& r) { r.adaptive->wanted[14] = 90; });
    expectRefused("adaptive", [](RenderFile& r) { r.adaptive.reset(); });
    const auto expectUnreadable = [&](const char* part, auto&& change) {
        WriteRenderFile(path, MakeAdaptiveRender());
        image::ExrImage file = image::ReadExr(path);
        change(file);
        image::WriteExr(path, file);
        ExpectError(
            ErrorKind::BadInput, [&] { ReadRenderFile(path); }, "a.exr", part);
    };
    const auto channel = [](image::ExrImage& file, const char* name) -> image::ExrChannel& {
        return *std::ranges::find(file.channels, name, &image::ExrChannel::name);
    };
    expectUnreadable("without a sample", [&](image::ExrImage& file) {
        std::get<std::vector<uint32_t>>(channel(file, "samples").samples)[2] = 0;
    });
    expectUnreadable("no variance of 64 samples",
                     [&](image::ExrImage& file) { channel(file, "samples.mean64").name = "other"; });
    expectUnreadable("gives no pixel as many", [&](image::ExrImage& file) {
        std::get<std::vector<uint32_t>>(channel(file, "samples.wanted").samples)[2] = 0xFFFFFFFFu;
    });
    expectUnreadable("no variance of 32 samples",
                     [&](image::ExrImage& file) { channel(file, "samples.variance32").name = "other"; });
    expectUnreadable("adaptiveStage", [](image::ExrImage& file) {
        file.attributes["raygraph.adaptiveStage"] = std::string("128 perhaps");
    });
    expectUnreadable("a pixel has", [](image::ExrImage& file) {
        file.attributes["raygraph.setting.adaptive"] = std::string("off");
    });
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
    // The upper words of residuals are 0
    EXPECT_EQ(words, 2u * 4 + 2 * 3 + 2 * 3 + 2 * 3);
    for (const char* name : {"sum0.R", "sum1.A", "squares1.B", "albedo.sum0.G", "N.sum1.X"})
        EXPECT_NE(file.UintChannel(name), nullptr) << name;
    EXPECT_EQ(names,
              (std::vector<std::string>{"A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "albedo.B", "albedo.G",
                                        "albedo.R", "id.instance", "id.material", "motion.X", "motion.Y",
                                        "samples", "variance.B", "variance.G", "variance.R"}));
    const std::vector<uint32_t>* samples = file.UintChannel("samples");
    ASSERT_NE(samples, nullptr);
    EXPECT_EQ((*samples)[7], 48u);
    const auto text = [&](const char* name) { return std::get<std::string>(file.attributes.at(name)); };
    EXPECT_EQ(text("raygraph.format"), "4");
    EXPECT_EQ(text("raygraph.sumsDigest").size(), 16u);
    EXPECT_EQ(text("raygraph.samples"), "48");
    EXPECT_EQ(text("raygraph.sampleOffset"), "16");
    EXPECT_EQ(text("raygraph.sampleRanges"), "16-63");
    EXPECT_EQ(text("raygraph.setting.seed"), "9");
    EXPECT_EQ(text("raygraph.scene"), "box.gltf");
    EXPECT_EQ(text("raygraph.device"), "a device");
    EXPECT_EQ(text("raygraph.driver"), "a driver");
    EXPECT_EQ(text("raygraph.version"), "1.2.3");
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
    file.attributes["raygraph.removedSamples"] = "3";
    std::erase_if(file.channels, [](const image::ExrChannel& channel) {
        return channel.name.starts_with("removed_clamp_indirect.variance.");
    });
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, readAgain, "a.exr", "removed_clamp_indirect", "variance");
}

// A resumed render ends at the sample at which this one would have.
TEST(RenderFile, MeasuredErrorReadsBackToTheLastBit) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    RenderFile written = MakeRender(0, 130);
    written.measuredError = {128, 0.1 + 0.2};
    WriteRenderFile(path, written);
    EXPECT_EQ(ReadRenderFile(path).measuredError, written.measuredError);
    image::ExrImage file = image::ReadExr(path);
    EXPECT_EQ(std::get<std::string>(file.attributes.at("raygraph.measuredError")), "128 0.30000000000000004");
    for (const char* text : {"128", "128 ", " 0.3", "0 0.3", "128 -1", "128 nan", "128 0.3 4", "x 0.3"}) {
        file.attributes["raygraph.measuredError"] = text;
        image::WriteExr(path, file);
        ExpectError(
            ErrorKind::BadInput, [&] { ReadRenderFile(path); }, "a.exr", "raygraph.measuredError");
    }
    for (const std::optional<MeasuredError>& none :
         {std::optional<MeasuredError>(), std::optional<MeasuredError>({128, std::nullopt})}) {
        written.measuredError = none;
        WriteRenderFile(path, written);
        EXPECT_FALSE(image::ReadExr(path).attributes.contains("raygraph.measuredError"));
        EXPECT_FALSE(ReadRenderFile(path).measuredError);
    }
}

TEST(RenderFile, SettingThatIsNotKnownIsOfANewerVersion) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    WriteRenderFile(path, MakeRender(0, 4));
    image::ExrImage file = image::ReadExr(path);
    file.attributes["raygraph.setting.caustics"] = "on";
    image::WriteExr(path, file);
    ExpectError(
        ErrorKind::BadInput, [&] { ReadRenderFile(path); }, "a.exr",
        "setting caustics is of a newer version");
}

// A render from any source is checked: no file is written that cannot be read.
TEST(RenderFile, WhatCouldNotBeReadIsNotWritten) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    const auto expectRefused = [&](auto&& change, const char* part) {
        RenderFile render = MakeRender(0, 4);
        change(render);
        ExpectError(
            ErrorKind::Usage, [&] { WriteRenderFile(path, render); }, "a.exr", part);
        EXPECT_FALSE(std::filesystem::exists(path));
    };
    expectRefused([](RenderFile& r) { r.settings["seed"] = "twelve"; }, "seed: \"twelve\"");
    expectRefused([](RenderFile& r) { r.settings["caustics"] = "on"; }, "setting caustics is not known");
    expectRefused([](RenderFile& r) { r.settings["size"] = "3x5"; }, "3x5");
    expectRefused([](RenderFile& r) { r.settings["light-group"] = "lamps=a*"; }, "groups of lights");
    expectRefused([](RenderFile& r) { r.samples.clear(); }, "it has no samples");
    expectRefused([](RenderFile& r) { r.samples = {{0, 2}, {7, 0}}; }, "a range of no samples");
    expectRefused([](RenderFile& r) { r.samples = {{4, 2}, {0, 2}}; }, "4-5 0-1");
    expectRefused([](RenderFile& r) { r.samples = {{0xFFFFFFFFu, 2}}; }, "beyond the last");
    expectRefused([](RenderFile& r) { r.radiance.clear(); }, "radiance");
    expectRefused([](RenderFile& r) { r.albedo.pop_back(); }, "albedo has 59 values, not 60");
    expectRefused([](RenderFile& r) { r.depth.push_back(1.0f); }, "depth has 16 values, not 15");
    expectRefused([](RenderFile& r) { r.motion.push_back(1.0f); }, "motion has 31 values, not 30");
    expectRefused([](RenderFile& r) { r.sums.normal.sums[2].clear(); }, "sums of normal");
    expectRefused([](RenderFile& r) { r.removed[1] = r.normal; }, "removed_clamp_indirect");
}

// Makes a render with all kinds of sums, also those of removed light and of light groups.
RenderFile MakeRenderOfAllSums() {
    RenderFile render = MakeRender(3, 24);
    PictureSettings settings = SettingsFrom(render.settings);
    settings.lightGroups = ParseLightGroups("lamps=lamp*;sky=*");
    render.settings = Texts(settings);
    const size_t clamped = static_cast<size_t>(Bias::ClampIndirect);
    render.removedSamples = 5;
    render.sums.removed[clamped] = MakeRender(0, 5).sums.radiance;
    render.removed[clamped] = passes::MeanOf(render.sums.removed[clamped], 5);
    render.removedVariance[clamped] = passes::VarianceOf(render.sums.removed[clamped], 5);
    for (size_t i = 0; i < LightGroupNames(settings.lightGroups).size(); ++i) {
        render.lightGroups.push_back(i == 0 ? render.albedo : render.normal);
        render.sums.lightGroups.push_back(i == 0 ? render.sums.albedo : render.sums.normal);
    }
    return render;
}

void ExpectSameSums(const RenderFile& read, const RenderFile& written) {
    EXPECT_EQ(read.sums.radiance, written.sums.radiance);
    ExpectSameColor(read.sums.albedo, written.sums.albedo);
    ExpectSameColor(read.sums.normal, written.sums.normal);
    ASSERT_EQ(read.sums.lightGroups.size(), written.sums.lightGroups.size());
    for (size_t i = 0; i < written.sums.lightGroups.size(); ++i)
        ExpectSameColor(read.sums.lightGroups[i], written.sums.lightGroups[i]);
    for (size_t i = 0; i < kBiasCount; ++i) {
        ExpectSameColor(read.sums.removed[i], written.sums.removed[i]);
        EXPECT_EQ(read.sums.removed[i].HasSquares(), written.sums.removed[i].HasSquares());
        if (!written.removed[i].empty()) {
            ExpectSameColor(passes::VarianceOf(read.sums.removed[i], read.removedSamples),
                            written.removedVariance[i]);
        }
    }
}

TEST(RenderFile, AllSumsReadBackBitForBit) {
    const test::TemporaryFolder folder;
    const RenderFile written = MakeRenderOfAllSums();
    WriteRenderFile(folder / "a.exr", written);
    ExpectSameSums(ReadRenderFile(folder / "a.exr"), written);
}

TEST(RenderFile, FilesOfWordsAreReadAndMerged) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    for (const RenderFile& written : {MakeRenderOfAllSums(), MakeAdaptiveRender()}) {
        WriteRenderFile(path, written);
        const image::ExrImage file = test::WithWordChannels(image::ReadExr(path), written);
        EXPECT_NE(file.UintChannel("squares4.B"), nullptr);
        image::WriteExr(path, file);
        ExpectSameSums(ReadRenderFile(path), written);
    }
    const RenderFile first = MakeRender(0, 3), second = MakeRender(3, 2);
    WriteRenderFile(path, first);
    image::WriteExr(path, test::WithWordChannels(image::ReadExr(path), first));
    WriteRenderFile(folder / "b.exr", second);
    const RenderFile merged = Merge({{"a", ReadRenderFile(path)}, {"b", ReadRenderFile(folder / "b.exr")}});
    EXPECT_EQ(merged.sums.radiance, MakeRender(0, 5).sums.radiance);
    EXPECT_EQ(merged.variance, MakeRender(0, 5).variance);
}

TEST(RenderFile, SumsOfChangedChannelsAreRefused) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    const auto expectRefused = [&](auto&& change) {
        WriteRenderFile(path, MakeRender(0, 24));
        image::ExrImage file = image::ReadExr(path);
        change(file);
        image::WriteExr(path, file);
        ExpectError(
            ErrorKind::BadInput, [&] { ReadRenderFile(path); }, "a.exr",
            "another program has changed its channels");
    };
    const auto at = [](image::ExrImage& file, const char* name) {
        return std::ranges::find(file.channels, name, &image::ExrChannel::name);
    };
    expectRefused([&](image::ExrImage& file) {
        for (float& value : std::get<std::vector<float>>(at(file, "G")->samples)) value *= 2.0f;
    });
    for (const char* name : {"sum1.R", "squares1.B", "squares0.R", "N.sum0.X"})
        expectRefused([&](image::ExrImage& file) { file.channels.erase(at(file, name)); });
    expectRefused([&](image::ExrImage& file) { std::swap(at(file, "R")->name, at(file, "B")->name); });
    expectRefused([](image::ExrImage& file) { file.attributes.erase("raygraph.sumsDigest"); });
    // Without sums it is a picture that cannot be resumed
    WriteRenderFile(path, MakeRender(0, 24));
    image::ExrImage file = image::ReadExr(path);
    std::erase_if(file.channels, [](const image::ExrChannel& channel) {
        return std::holds_alternative<std::vector<uint32_t>>(channel.samples) && channel.name != "samples";
    });
    image::WriteExr(path, file);
    EXPECT_FALSE(HasSums(ReadRenderFile(path)));
}

TEST(RenderFile, ChannelsThatWereNotRenderedAreLeftOut) {
    const test::TemporaryFolder folder;
    RenderFile written = MakeRender(0, 1);
    written.albedo.clear();
    written.normal.clear();
    written.depth.clear();
    written.motion.clear();
    written.instance.clear();
    written.material.clear();
    WriteRenderFile(folder / "a.exr", written);
    EXPECT_EQ(image::ReadExr(folder / "a.exr").channels.size(), 8u + 4 + 3);
    const RenderFile read = ReadRenderFile(folder / "a.exr");
    EXPECT_TRUE(read.albedo.empty() && read.normal.empty() && read.depth.empty() && read.instance.empty() &&
                read.motion.empty());
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
    file.attributes["raygraph.format"] = "2";
    image::WriteExr(path, file);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "raygraph.format is 2");
    file.attributes["raygraph.format"] = "3";

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
    ExpectError(ErrorKind::BadInput, read, "a.exr", "size 1280x720", "2x1");

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
}  // namespace raygraph::session::render_file_test

namespace raygraph::session::merge_test {
namespace {

using test::ExpectError;
using test::MakeRender;

void ExpectSameBits(const RenderFile& a, const RenderFile& b) {
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(a.radiance, b.radiance);
    EXPECT_EQ(a.variance, b.variance);
    EXPECT_EQ(a.albedo, b.albedo);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.sums.radiance, b.sums.radiance);
    EXPECT_EQ(a.sums.albedo, b.sums.albedo);
}

TEST(Merge, HasTheBitsOfOneRenderOfAllSamplesInAnyOrder) {
    const RenderFile whole = MakeRender(0, 8);
    const RenderFile a = MakeRender(0, 1), b = MakeRender(1, 2), c = MakeRender(3, 5);
    ExpectSameBits(Merge({{"a", a}, {"b", b}, {"c", c}}), whole);
    ExpectSameBits(Merge({{"c", c}, {"a", a}, {"b", b}}), whole);
    ExpectSameBits(Merge({{"a", a}, {"bc", Merge({{"c", c}, {"b", b}})}}), whole);
    ExpectSameBits(Merge({{"b", MakeRender(20, 44)}, {"a", MakeRender(0, 19)}, {"c", MakeRender(19, 1)}}),
                   MakeRender(0, 64));
}

// Files of earlier versions record how rays were traced, which changes no picture.
TEST(Merge, SettingsThatAreNoneAnyMoreAreLeftOut) {
    const test::TemporaryFolder folder;
    const RenderFile written = MakeRender(0, 4);
    WriteRenderFile(folder / "a.exr", written);
    image::ExrImage file = image::ReadExr(folder / "a.exr");
    file.attributes["raygraph.setting.traversal"] = "own";
    file.attributes["raygraph.setting.integrator-form"] = "wavefront:4";
    image::WriteExr(folder / "a.exr", file);
    const RenderFile read = ReadRenderFile(folder / "a.exr");
    EXPECT_EQ(read.settings, written.settings);
    EXPECT_EQ(FirstMismatch(read, written), "");
    file.attributes["raygraph.setting.wavelength"] = "500";
    image::WriteExr(folder / "a.exr", file);
    EXPECT_THROW(std::ignore = ReadRenderFile(folder / "a.exr"), Error);
}

TEST(Merge, APartThatIsRefusedLeavesTheOthers) {
    Merger merger;
    ExpectError(
        ErrorKind::Usage, [&] { merger.Take(); }, "no renders");
    merger.Add({"b", MakeRender(3, 5)});
    merger.Add({"a", MakeRender(0, 2)});
    ExpectError(
        ErrorKind::BadInput,
        [&] {
            merger.Add({"again", MakeRender(1, 2)});
        },
        "a and again", "0-1 and 1-2");
    RenderFile other = MakeRender(2, 1);
    other.settings["seed"] = "10";
    ExpectError(
        ErrorKind::BadInput,
        [&] {
            merger.Add({"other", other});
        },
        "b and other differ");
    merger.Add({"c", MakeRender(2, 1)});
    ExpectSameBits(merger.Take(), MakeRender(0, 8));
    ExpectError(
        ErrorKind::Usage, [&] { merger.Take(); }, "no renders");
    merger.Add({"d", MakeRender(1, 2)});
    ExpectSameBits(merger.Take(), MakeRender(1, 2));
}

TEST(Merge, RemovedLightIsWeighedByTheSamplesTracedTwice) {
    const auto part = [](uint32_t first, const std::vector<float>& removed) {
        RenderFile render = MakeRender(first, 8);
        passes::ExactSums& sums = render.sums.removed[1];
        sums = passes::MakeExactSums(PixelCount(render.size), true);
        for (const float value : removed) passes::AddSample(sums, Texels(render.radiance.size(), value));
        render.removedSamples = static_cast<uint32_t>(removed.size());
        render.removed[1] = render.removedVariance[1] = Texels(render.radiance.size(), 0.0f);
        return render;
    };
    const RenderFile merged = Merge({{"a", part(0, {2})}, {"b", part(8, {})}, {"c", part(16, {3, 4, 5})}});
    EXPECT_EQ(merged.removedSamples, 4u);
    EXPECT_FLOAT_EQ(merged.removed[1][5], 3.5f);
    EXPECT_FLOAT_EQ(merged.removedVariance[1][5], 5.0f / 3.0f);
    EXPECT_TRUE(merged.removed[0].empty());
    EXPECT_EQ(Merge({{"a", part(0, {})}, {"b", part(8, {})}}).removed[1][5], 0.0f);
}

TEST(Merge, WhatHasNoSumsIsNamed) {
    RenderFile other = MakeRender(8, 8);
    other.sums = {};
    ExpectError(
        ErrorKind::BadInput,
        [&] {
            Merge({{"a.exr", MakeRender(0, 8)}, {"b.exr", other}});
        },
        "b.exr", "no channel sum0.R");
    other = MakeRender(8, 8);
    other.sums.albedo = other.sums.normal = {};  // as saved by the editor
    ExpectError(
        ErrorKind::BadInput,
        [&] {
            Merge({{"a.exr", MakeRender(0, 8)}, {"b.exr", other}});
        },
        "b.exr", "no channel albedo.sum0.R", "resume it once");
}

TEST(Merge, RendersThatNoReaderCheckedAreRefused) {
    ExpectError(
        ErrorKind::Usage, [] { Merge({}); }, "no renders");
    const auto expectRefused = [](auto&& change, const char* part) {
        RenderFile other = MakeRender(8, 8);
        change(other);
        ExpectError(
            ErrorKind::BadInput,
            [&] {
                Merge({{"a.exr", MakeRender(0, 8)}, {"b.exr", other}});
            },
            "b.exr", part);
    };
    expectRefused([](RenderFile& r) { r.samples.clear(); }, "it has no samples");
    expectRefused([](RenderFile& r) { r.sums.radiance = passes::MakeExactSums(4, true); },
                  "sums of radiance");
    expectRefused([](RenderFile& r) { r.sums.lightGroups.resize(2); }, "groups of lights");
}

TEST(Merge, KeepsTheListOfSeparateRanges) {
    const RenderFile merged =
        Merge({{"a", MakeRender(100, 10)}, {"b", MakeRender(0, 10)}, {"c", MakeRender(10, 5)}});
    EXPECT_EQ(merged.samples, (SampleRanges{{0, 15}, {100, 10}}));
}

TEST(Merge, DepthAndIdsAreThoseOfTheFirstSamples) {
    RenderFile other = MakeRender(8, 8);
    other.depth.assign(other.depth.size(), 3.0f);
    other.instance.assign(other.instance.size(), 5);
    const RenderFile first = MakeRender(0, 8), merged = Merge({{"b", other}, {"a", first}});
    EXPECT_EQ(merged.depth, first.depth);
    EXPECT_EQ(merged.instance, first.instance);
}

TEST(Merge, OverlapNamesBothFilesAndRanges) {
    ExpectError(
        ErrorKind::BadInput,
        [] {
            Merge(
                {{"a.exr", MakeRender(0, 32)}, {"b.exr", MakeRender(64, 8)}, {"c.exr", MakeRender(31, 32)}});
        },
        "a.exr", "c.exr", "0-31", "31-62");
}

TEST(Merge, DifferentPicturesAreRefusedNamingTheDifference) {
    const auto merge = [](auto change) {
        RenderFile other = MakeRender(8, 8);
        change(other);
        return [other] { Merge({{"a.exr", MakeRender(0, 8)}, {"b.exr", other}}); };
    };
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.settings["seed"] = "10"; }), "a.exr",
                "b.exr", "seed: 9 against 10");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.settings["size"] = "3x5"; }),
                "size: 5x3 against 3x5");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.sceneFile = "ball.gltf"; }),
                "scene: box.gltf against ball.gltf");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.sceneHash = "other"; }),
                "box.gltf has changed");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.sceneHash.clear(); }),
                "box.gltf was saved by the editor");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.environmentFile.clear(); }),
                "environment: sky.hdr against none");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.environmentHash.clear(); }),
                "sky.hdr has changed");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.albedo.clear(); }),
                "a.exr has the channels of albedo, b.exr has not");
}

}  // namespace
}  // namespace raygraph::session::merge_test

namespace raygraph::cli::resume_test {
namespace {

using test::ExpectError;
using test::MakeRender;

ResumedRender Resumed(uint32_t first, uint32_t count) {
    return {"old.exr", MakeRender(first, count)};
}

RenderArguments Asking(uint32_t samples, const SettingTexts& given = {}) {
    RenderArguments arguments;
    arguments.samples = samples;
    arguments.given = given;
    return arguments;
}

TEST(Resume, TakesTheSettingsOfTheFile) {
    const PictureSettings settings = SettingsOf(Resumed(0, 8), Asking(16));
    EXPECT_EQ(settings.size, (Extent2D{5, 3}));
    EXPECT_EQ(settings.paths.seed, 9u);
    EXPECT_EQ(SettingsOf(Resumed(0, 8), Asking(16, {{"seed", "9"}, {"size", "5x3"}})).paths.seed, 9u);
}

TEST(Resume, AnOptionThatSaysOtherwiseIsNamed) {
    ExpectError(
        ErrorKind::Usage,
        [] {
            SettingsOf(Resumed(0, 8), Asking(16, {{"seed", "1"}}));
        },
        "seed 1", "old.exr was rendered with 9");
    ExpectError(
        ErrorKind::Usage,
        [] {
            SettingsOf(Resumed(0, 8), Asking(16, {{"camera", "Cam"}}));
        },
        "camera Cam", "the default");
    RenderArguments offset = Asking(16);
    offset.sampleOffset = 4;
    ExpectError(
        ErrorKind::Usage, [&] { SettingsOf(Resumed(2, 8), offset); }, "sample-offset 4", "with 2");
    RenderArguments aovs = Asking(16);
    aovs.aovs = ParseAovs("albedo,normal");
    ExpectError(
        ErrorKind::Usage, [&] { SettingsOf(Resumed(0, 8), aovs); }, "aov albedo,normal",
        "albedo,normal,depth,instance,material");
}

// A choice that the render has made stays.
TEST(Resume, AnOptionThatLeavesAChoiceOpenTakesThatOfTheFile) {
    ResumedRender resumed = Resumed(0, 8);
    resumed.render.settings["light"] = "studio";
    EXPECT_EQ(SettingsOf(resumed, Asking(16, {{"light", "auto"}})).light, DefaultLight::Studio);
    ExpectError(
        ErrorKind::Usage,
        [&] {
            SettingsOf(resumed, Asking(16, {{"light", "none"}}));
        },
        "light none", "old.exr was rendered with studio");
}

TEST(Resume, TheTotalMustBeMoreThanThereIs) {
    ExpectError(
        ErrorKind::Usage, [] { SettingsOf(Resumed(0, 8), Asking(8)); }, "--spp 8", "holds 8 samples");
    ExpectError(
        ErrorKind::Usage, [] { SettingsOf(Resumed(0, 8), {}); }, "--spp", "--time");
    RenderArguments timed;
    timed.seconds = 1.0;
    EXPECT_EQ(SettingsOf(Resumed(0, 8), timed).paths.seed, 9u);
}

TEST(Resume, WhatCannotBeContinuedIsBadInput) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    const auto read = [&] { ReadResumedRender(path); };
    RenderFile render = MakeRender(0, 8);
    render.samples = {{0, 4}, {8, 4}};
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "0-3 8-11");

    render = MakeRender(0, 8);
    render.variance.clear();
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "variance");

    render = MakeRender(0, 8);
    render.sums = {};
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "sum0.R");

    render = MakeRender(0, 8);
    render.settings["view"] = "albedo";
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "albedo");

    render = MakeRender(0, 8);
    render.sceneHash.clear();
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "saved by the editor");

    WriteRenderFile(path, MakeRender(3, 8));
    EXPECT_EQ(ReadResumedRender(path).render.samples, (SampleRanges{{3, 8}}));
}

TEST(Resume, ACompleteRenderHasTheSamplesOrTheError) {
    RenderFile render = MakeRender(5, 100);
    EXPECT_TRUE(IsComplete(render, {.samples = 100}));
    EXPECT_TRUE(IsComplete(render, {.samples = 99}));
    EXPECT_FALSE(IsComplete(render, {.samples = 101}));
    EXPECT_FALSE(IsComplete(render, {.seconds = 1.0})) << "each run takes its time";
    EXPECT_FALSE(IsComplete(render, {.relativeError = 0.9})) << "nothing was measured";
    // An error of 0.1 at 64 samples is 0.08 at 100
    render.measuredError = {64, 0.1};
    EXPECT_TRUE(IsComplete(render, {.relativeError = 0.08}));
    EXPECT_FALSE(IsComplete(render, {.relativeError = 0.0799}));
    EXPECT_TRUE(IsComplete(render, {.samples = 200, .relativeError = 0.08}));
    EXPECT_TRUE(IsComplete(render, {.samples = 100, .relativeError = 0.01}));
    EXPECT_FALSE(IsComplete(render, {.samples = 200, .relativeError = 0.01}));
    render.samples = {{5, 63}};  // no render stops before the first measurement
    EXPECT_FALSE(IsComplete(render, {.relativeError = 0.9}));
    render.measuredError = {64, std::nullopt};
    render.samples = {{5, 100}};
    EXPECT_FALSE(IsComplete(render, {.relativeError = 0.9}));
}

}  // namespace
}  // namespace raygraph::cli::resume_test

namespace raygraph::session::sample_ranges_test {

TEST(SampleRanges, TextReadsBack) {
    const SampleRanges ranges{{0, 64}, {128, 1}, {200, 0xFFFFFFFFu - 199}};
    EXPECT_EQ(ToText(ranges), "0-63 128-128 200-4294967295");
    EXPECT_EQ(ParseSampleRanges(ToText(ranges)), ranges);
    EXPECT_EQ(SampleCount(ranges), 65u + 0xFFFFFFFFull - 199);
}

TEST(SampleRanges, MalformedTextIsBadInput) {
    for (const char* text : {"", "-", "5", "5-", "-5", "5-4", "0-3 2-5", "4-5 0-1", "0-1  2-3", "0-1 ", "a-b",
                             "0-4294967295", "0-4294967296"})
        test::ExpectError(
            ErrorKind::BadInput, [&] { ParseSampleRanges(text); }, "sample ranges");
}

TEST(SampleRanges, NeighborsDoNotOverlapAndAreJoined) {
    const SampleRanges a{{0, 10}}, b{{10, 5}}, c{{20, 5}};
    EXPECT_FALSE(Overlap(a, b));
    EXPECT_EQ(Union(b, a), (SampleRanges{{0, 15}}));
    EXPECT_EQ(Union(c, a), (SampleRanges{{0, 10}, {20, 5}}));
    EXPECT_EQ(Union(Union(c, a), {{10, 10}}), (SampleRanges{{0, 25}}));
}

TEST(SampleRanges, OneSharedSampleIsAnOverlap) {
    EXPECT_TRUE(Overlap({{0, 10}}, {{9, 5}}));
    EXPECT_TRUE(Overlap({{9, 5}}, {{0, 10}}));
    EXPECT_TRUE(Overlap({{0, 100}}, {{200, 5}, {50, 1}}));
    EXPECT_FALSE(Overlap({{0, 10}, {20, 10}}, {{10, 10}, {30, 10}}));
}

}  // namespace raygraph::session::sample_ranges_test

// Tests the sums of a render as one process sends them to another.
namespace raygraph::session::render_sums_test {
namespace {

TEST(RenderSums, AllOfThemAreEachOnce) {
    RenderSums sums;
    sums.lightGroups.resize(2);
    const std::vector<passes::ExactSums*> all = AllOf(sums);
    const auto count = [&](const passes::ExactSums* one) { return std::ranges::count(all, one); };
    EXPECT_EQ(count(&sums.radiance), 1);
    for (const Aov aov : kAovs) {
        const passes::ExactSums* ofAov = SumsOf(sums, aov);
        EXPECT_TRUE(ofAov == nullptr || count(ofAov) == 1) << Name(aov);
    }
    for (const passes::ExactSums& group : sums.lightGroups) EXPECT_EQ(count(&group), 1);
    EXPECT_EQ(all.size(), 3 + sums.parts.size() + sums.removed.size() + 2);
}

}  // namespace
}  // namespace raygraph::session::render_sums_test

namespace raygraph::session::statistics_test {
namespace {

TEST(ImageStatistics, RelativeErrorIsTheStandardErrorOverTheMean) {
    // Two pixels have the mean 2 and the sample variance 9, so that 9 samples make a standard error of 1
    const std::vector<float> mean{1, 2, 3, 1, 1, 2, 3, 1}, variance{9, 9, 9, 0, 9, 9, 9, 0};
    const ImageStatistics statistics = Measure(mean, variance, 9);
    EXPECT_EQ(statistics.mean, (std::array<double, 3>{1, 2, 3}));
    ASSERT_TRUE(statistics.relativeError);
    EXPECT_DOUBLE_EQ(*statistics.relativeError, 0.5);
}

TEST(ImageStatistics, EachPixelMayHaveAsManySamplesAsItLikes) {
    // The variances of the means are 1 and 3, so 2 on average
    const std::vector<float> mean{1, 2, 3, 1, 1, 2, 3, 1}, variance{9, 9, 9, 0, 9, 9, 9, 0};
    EXPECT_DOUBLE_EQ(Measure(mean, variance, std::vector<uint32_t>{9, 3}).relativeError.value_or(0.0),
                     std::sqrt(2.0) / 2.0);
    EXPECT_FALSE(Measure(mean, variance, std::vector<uint32_t>{1, 1}).relativeError);
}

TEST(ImageStatistics, NoErrorWithoutTwoSamplesVarianceOrLight) {
    const std::vector<float> light{1, 1, 1, 1}, black{0, 0, 0, 1};
    EXPECT_FALSE(Measure(light, light, 1).relativeError);
    EXPECT_FALSE(Measure(light, {}, 8).relativeError);
    EXPECT_FALSE(Measure(black, black, 8).relativeError);
    EXPECT_FALSE(Measure({}, {}, 8).relativeError);
}

TEST(Median, IsTheMiddleOrTheMeanOfTheTwo) {
    EXPECT_EQ(Median({}), 0.0);
    EXPECT_EQ(Median({3, 1, 2}), 2.0);
    EXPECT_EQ(Median({4, 1, 3, 2}), 2.5);
}

TEST(PassTimes, PassesOfOneNameInAFrameAddUp) {
    PassTimes times;
    const auto frame = [](double trace) {
        FrameTiming timing;
        timing.passes = {{"Trace", 0.0, trace}, {"Accumulate", 0.0, 1.0}, {"Accumulate", 0.0, 2.0}};
        return timing;
    };
    times.Add(std::vector<FrameTiming>{frame(10), frame(30), frame(11)});
    const std::vector<PassTime> summary = times.Summary();
    ASSERT_EQ(summary.size(), 2u);
    EXPECT_EQ(summary[0].name, "Trace");
    EXPECT_EQ(summary[0].gpuMsMedian, 11.0);
    EXPECT_EQ(summary[0].gpuMsTotal, 51.0);
    EXPECT_EQ(summary[0].count, 3u);
    EXPECT_EQ(summary[1].gpuMsMedian, 3.0);
    EXPECT_EQ(times.MedianMs("Tonemap"), 0.0);
}

}  // namespace
}  // namespace raygraph::session::statistics_test

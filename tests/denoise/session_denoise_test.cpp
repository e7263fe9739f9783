// Tests that a session denoises beside the radiance, and what it refuses to denoise. It needs a device.
#include <cmath>
#include <functional>
#include <tuple>

#include "editor/session/denoise.h"
#include "editor/session/file/merge.h"
#include "editor/session/file/render_file_parts.h"
#include "editor/session/session.h"

#include "renderer/image/exr.h"
#include "tests/support/error_of.h"
#include "tests/support/source_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session::session_denoise_test {

namespace {

class DenoisingSession : public testing::VulkanTest {
  protected:
    static SessionDesc Desc(bool isDenoised) {
        SessionDesc desc;
        desc.settings.size = {64, 64};
        desc.isDenoised = isDenoised;
        return desc;
    }
    static SceneInput Cornell() { return LoadInput(test::SourceFile("scenes/cornell.gltf")); }
    RenderFile Rendered(SessionDesc desc, uint32_t samples, uint32_t first = 0) {
        desc.firstSample = first;
        Session session(Device(), Cornell(), desc);
        session.Run({.samples = samples});
        return session.Result().render;
    }
    Texels Truth() {
        SessionDesc other = Desc(false);
        other.settings.paths.seed = 1;
        return Rendered(other, 512).radiance;
    }
    static double RelativeError(const Texels& a, const Texels& b) {
        double sum = 0.0;
        for (size_t i = 0; i < a.size(); ++i)
            if (i % 4 != 3) sum += std::pow(double(a[i]) - b[i], 2) / (double(b[i]) * b[i] + 0.01);
        return sum;
    }
};

}  // namespace

TEST_F(DenoisingSession, PictureHasLessNoiseBesideARadianceThatStays) {
    Session plain(Device(), Cornell(), Desc(false)), denoising(Device(), Cornell(), Desc(true));
    plain.Run({.samples = 32});
    denoising.Run({.samples = 32});
    const RenderFile before = plain.Result().render, after = denoising.Result().render;
    EXPECT_TRUE(before.radiance == after.radiance && before.variance == after.variance);
    EXPECT_TRUE(after.albedo.empty() && after.normal.empty());
    EXPECT_TRUE(before.denoised.empty());
    EXPECT_NE(plain.Display().rgba, denoising.Display().rgba);

    const Texels truth = Truth();
    ASSERT_EQ(after.denoised.size(), truth.size());
    EXPECT_GT(RelativeError(after.radiance, truth), 2.0 * RelativeError(after.denoised, truth));

    const test::TemporaryFolder folder;
    WriteRenderFile(folder / "a.exr", after);
    const image::ExrImage file = image::ReadExr(folder / "a.exr");
    for (size_t c = 0; c < 3; ++c) {
        const std::vector<float>* channel = file.FloatChannel(std::string("denoised.") + "RGB"[c]);
        ASSERT_NE(channel, nullptr);
        for (size_t i = 0; i < channel->size(); ++i) ASSERT_EQ((*channel)[i], after.denoised[4 * i + c]);
    }
    // The render goes on from its file, and is denoised by all samples
    const ResumedRender resumed{"a.exr", ReadRenderFile(folder / "a.exr")};
    SessionDesc more = Resuming(resumed);
    more.isDenoised = true;
    Session resuming(Device(), Cornell(), more);
    resuming.Run({.samples = 64});
    denoising.Run({.samples = 64});
    EXPECT_TRUE(resuming.Result().render.denoised == denoising.Result().render.denoised);
}

TEST_F(DenoisingSession, FileIsDenoisedToTheBitsOfTheSession) {
    const test::TemporaryFolder folder;
    for (const bool isCropped : {false, true}) {
        SessionDesc desc = Desc(true);
        desc.aovs = {Aov::Denoising};
        if (isCropped) desc.settings.crop = passes::Region{17, 9, 33, 31};
        Session session(Device(), Cornell(), desc);
        session.Run({.samples = 32});
        const RenderFile whole = session.Result().render;
        EXPECT_EQ(whole.denoising.firstSamples, 16u);
        // The guides are traced without the session's own denoising, too
        desc.isDenoised = false;
        WriteRenderFile(folder / "a.exr", Rendered(desc, 32));
        const RenderFile read = ReadRenderFile(folder / "a.exr");
        EXPECT_TRUE(read.denoised.empty() && AovsOf(read) == desc.aovs && HasSums(read));
        RenderFile denoised = read;
        EXPECT_EQ(Denoise(Device(), denoised).rgba, session.Display().rgba);
        EXPECT_TRUE(denoised.denoised == whole.denoised);
        EXPECT_TRUE(denoised.radiance == whole.radiance);
        // Each plane matters
        for (const std::function<void(DenoisingPlanes&)>& change : {
                 std::function([](DenoisingPlanes& p) { p.albedo.assign(p.albedo.size(), 0.5f); }),
                 std::function([](DenoisingPlanes& p) { p.normal.assign(p.normal.size(), 0.5f); }),
                 std::function([](DenoisingPlanes& p) { p.firstHalf = p.albedo; }),
                 std::function([](DenoisingPlanes& p) { p.firstSamples = 8; }),
                 std::function([](DenoisingPlanes& p) { p.seen = p.albedo; }),
                 std::function([](DenoisingPlanes& p) { p.seenByAll = p.albedo; }),
                 std::function([](DenoisingPlanes& p) { p.seenSquares.assign(p.albedo.size(), 1e3f); }),
             }) {
            RenderFile other = read;
            change(other.denoising);
            Denoise(Device(), other);
            EXPECT_FALSE(other.denoised == whole.denoised);
        }
    }
}

TEST_F(DenoisingSession, MergedFilesHalfFloatsAndPlainChannelsAreDenoised) {
    const test::TemporaryFolder folder;
    const Texels truth = Truth();
    SessionDesc desc = Desc(false);
    desc.aovs = {Aov::Denoising, Aov::Albedo, Aov::Normal};
    RenderFile merged = Merge({{"a", Rendered(desc, 16)}, {"b", Rendered(desc, 48, 16)}});
    const RenderFile whole = Rendered(desc, 64);
    EXPECT_EQ(merged.denoising.firstSamples, 8u + 32u);
    const auto expectNear = [](const Texels& a, const Texels& b, double most) {
        ASSERT_EQ(a.size(), b.size());
        EXPECT_LT(RelativeError(a, b), most * static_cast<double>(a.size()));
    };
    expectNear(merged.denoising.seen, whole.denoising.seen, 1e-3);
    expectNear(merged.denoising.seenByAll, whole.denoising.seenByAll, 1e-3);
    expectNear(merged.denoising.albedo, whole.denoising.albedo, 5e-3);
    expectNear(merged.denoising.normal, whole.denoising.normal, 5e-3);
    expectNear(merged.denoising.firstHalf, whole.denoising.firstHalf, 2e-2);

    WriteRenderFile(folder / "half.exr", whole, {}, ExrType::Half);
    RenderFile half = ReadRenderFile(folder / "half.exr"), plain = whole;
    plain.denoising = {};
    for (RenderFile* render : {&merged, &half, &plain}) {
        Denoise(Device(), *render);
        EXPECT_GT(RelativeError(whole.radiance, truth), 2.0 * RelativeError(render->denoised, truth));
    }
}

TEST_F(DenoisingSession, PlanesOfTheDenoiserAreReadBackAndMergedByTheirCounts) {
    const test::TemporaryFolder folder;
    SessionDesc desc = Desc(false);
    desc.settings.size = {5, 3};
    const auto filled = [&](uint32_t first, uint32_t count, uint32_t ofFirstHalf, float value) {
        RenderFile render = Rendered(desc, count, first);
        Texels texels(render.radiance.size(), 0.0f);
        for (size_t i = 0; i < texels.size(); ++i)
            if (i % 4 != 3) texels[i] = value + static_cast<float>(i);
        render.denoising = {texels, texels, {}, ofFirstHalf, texels, texels, texels};
        if (ofFirstHalf > 0) render.denoising.firstHalf = texels;
        return render;
    };
    const RenderFile a = filled(0, 8, 4, 1.0f), b = filled(8, 24, 12, 5.0f), c = filled(32, 4, 0, 9.0f);
    WriteRenderFile(folder / "a.exr", a);
    const RenderFile read = ReadRenderFile(folder / "a.exr");
    EXPECT_EQ(read.denoising.firstSamples, 4u);
    for (const auto& [names, plane] : DenoisingChannels())
        EXPECT_EQ(read.denoising.*plane, a.denoising.*plane) << names[0];
    EXPECT_TRUE(AovsOf(read).Has(Aov::Denoising));
    for (const RenderFile& merged : {Merge({{"a", a}, {"b", b}}), Merge({{"b", b}, {"a", a}})})
        for (const auto& [names, plane] : DenoisingChannels())
            EXPECT_EQ((merged.denoising.*plane)[1], 5.0f) << names[0];
    // A part with few samples has no first half
    const RenderFile more = Merge({{"c", c}, {"a", a}});
    EXPECT_EQ(more.denoising.firstSamples, 4u);
    EXPECT_EQ(more.denoising.firstHalf, a.denoising.firstHalf);
    EXPECT_FLOAT_EQ(more.denoising.seen[0], (8.0f * 1.0f + 4.0f * 9.0f) / 12.0f);
    RenderFile without = b;
    KeepOnly(without, AovSet{});
    EXPECT_TRUE(without.denoising.albedo.empty() && without.denoising.firstSamples == 0);
    const auto refusal = [](const auto& run) { return std::string(testing::ErrorOf(run).what()); };
    EXPECT_EQ(refusal([&] {
                  Merge({{"a", a}, {"b", without}});
              }),
              "a has the channels of denoising, b has not");

    // Another program may have changed the file
    image::ExrImage file = image::ReadExr(folder / "a.exr");
    file.attributes["raygraph.firstHalfSamples"] = "8";
    image::WriteExr(folder / "b.exr", file);
    const auto refusalOfFile = [&] {
        return refusal([&] { std::ignore = ReadRenderFile(folder / "b.exr"); });
    };
    EXPECT_NE(refusalOfFile().find("8 of its 8 samples"), std::string::npos) << refusalOfFile();
    file.attributes.erase("raygraph.firstHalfSamples");
    image::WriteExr(folder / "b.exr", file);
    EXPECT_NE(refusalOfFile().find("are incomplete"), std::string::npos) << refusalOfFile();
}

TEST_F(DenoisingSession, FilesThatCannotBeDenoisedSayWhy) {
    SessionDesc desc = Desc(false);
    desc.settings.size = {8, 8};
    desc.aovs = {Aov::Denoising};
    const RenderFile render = Rendered(desc, 16);
    EXPECT_EQ(NotDenoisableReason(render), "");
    const auto reason = [&](const std::function<void(RenderFile&)>& change) {
        RenderFile changed = render;
        change(changed);
        EXPECT_THROW(Denoise(Device(), changed), Error);
        return NotDenoisableReason(changed);
    };
    const auto expect = [](const std::string& text, const std::string& part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    expect(reason([](RenderFile& r) { r.denoising = {}; }), "neither the channels of --aov denoising");
    expect(reason([](RenderFile& r) { r.variance.clear(); }), "variance.R");
    expect(reason([](RenderFile& r) { r.settings["view"] = "raster"; }), "the view raster");
    for (const auto& change : {std::function([](DenoisingPlanes& p) { p.normal.clear(); }),
                               std::function([](DenoisingPlanes& p) { p.seen.clear(); }),
                               std::function([](DenoisingPlanes& p) { p.seenSquares.clear(); }),
                               std::function([](DenoisingPlanes& p) { p.firstSamples = 0; }),
                               std::function([](DenoisingPlanes& p) { p.firstHalf.clear(); })})
        expect(reason([&](RenderFile& r) { change(r.denoising); }), "are incomplete");
    expect(reason([](RenderFile& r) { r.denoising.firstSamples = 16; }), "16 of its 16 samples");
    expect(reason([](RenderFile& r) { r.denoising.seen.pop_back(); }), "denoising.seen.R has 255 values");

    desc.aovs = {};
    desc.settings.isAdaptive = true;
    expect(NotDenoisableReason(Rendered(desc, 16)), "adaptive");
    desc.aovs = {Aov::Denoising};
    EXPECT_THROW(Session(Device(), Cornell(), desc), Error);
}

TEST_F(DenoisingSession, WhatCannotBeDenoisedIsRefused) {
    SessionDesc raster = Desc(true), adaptive = Desc(true), blind = Desc(true);
    raster.settings.view = View::Raster;
    adaptive.settings.isAdaptive = true;
    blind.withVariance = false;
    for (const SessionDesc& desc : {raster, adaptive, blind})
        EXPECT_THROW(Session(Device(), Cornell(), desc), SettingError);
    rhi::Device* const twice[] = {&Device(), &Device()};
    SessionDesc guided = Desc(false);
    guided.aovs = {Aov::Denoising};
    for (const SessionDesc& desc : {Desc(true), guided})
        EXPECT_THROW(Session(twice, Cornell(), desc), SettingError);
}

TEST(DenoisingLimit, PictureThatGetsTheRegressionInsteadOfTheNetworkIsWarnedOf) {
    const rhi::DeviceInfo device{.name = "small", .maxStorageBufferBytes = 56 * 20 * 10};
    std::string warned;
    const Log log([&](const LogMessage& message) { warned += message.text; }, LogLevel::Warning);
    WarnIfTooLarge(device, {20, 10}, passes::Denoiser::Network, log);
    WarnIfTooLarge(device, {22, 10}, passes::Denoiser::Regression, log);
    EXPECT_EQ(warned, "");
    WarnIfTooLarge(device, {22, 10}, passes::Denoiser::Network, log);
    EXPECT_EQ(
        warned,
        "22x10 pixels are too many for the denoiser's network on small; the regression is used instead");
}

}  // namespace raygraph::session::session_denoise_test

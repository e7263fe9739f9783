// Tests that a session denoises beside the radiance, and what it refuses to denoise. It needs a device.
#include "editor/session/session.h"

#include <cmath>

#include "renderer/image/exr.h"
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

    SessionDesc other = Desc(false);
    other.settings.paths.seed = 1;
    Session reference(Device(), Cornell(), other);
    reference.Run({.samples = 512});
    const Texels truth = reference.Result().render.radiance;
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

TEST_F(DenoisingSession, WhatCannotBeDenoisedIsRefused) {
    SessionDesc raster = Desc(true), adaptive = Desc(true), blind = Desc(true);
    raster.settings.view = View::Raster;
    adaptive.settings.isAdaptive = true;
    blind.withVariance = false;
    for (const SessionDesc& desc : {raster, adaptive, blind})
        EXPECT_THROW(Session(Device(), Cornell(), desc), SettingError);
    rhi::Device* const twice[] = {&Device(), &Device()};
    EXPECT_THROW(Session(twice, Cornell(), Desc(true)), SettingError);
}

}  // namespace raygraph::session::session_denoise_test

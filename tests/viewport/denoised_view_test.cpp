// The denoised picture of a viewport: when it is made, and that the samples stay as they are.
#include <gtest/gtest.h>

#include "editor/viewport/denoised_view.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::denoised_view_test {

using viewport::DenoisedView;

namespace {

using Picture = std::vector<uint8_t>;

class ViewportDenoised : public VulkanTest {
  protected:
    ViewportDenoised() { SetDenoised(true); }
    void SetDenoised(bool isOn) { viewed.viewport.SetShow({.isDenoised = isOn}); }
    void Move() {
        scene::CameraView camera = InsideBoxes();
        camera.eye.x += 0.1;
        viewed.viewport.SetCamera(camera);
    }
    bool Denoises() { return viewed.renderer.DescribePlan().find("DenoiseBlend") != std::string::npos; }
    // A picture as small as these takes as long as many samples.
    void RenderUntilDenoised() {
        for (int i = 0; i < 300 && DenoisedSamples() == 0; ++i) viewed.RenderFrames(1);
    }
    uint32_t DenoisedSamples() const { return viewed.viewport.Progress().denoisedSamples; }
    viewport::CaptureResult Capture() {
        const viewport::Capture capture = viewed.viewport.RequestCapture();
        for (int i = 0; i < 100 && !capture.IsTaken(); ++i) viewed.RenderFrames(1);
        Device().WaitIdle();
        return capture.Result();
    }

    ViewedScene viewed{Device()};
};

}  // namespace

TEST(DenoisedViewCounts, LeaveMostOfTheTimeToSamplesAndKeepUpWithMany) {
    EXPECT_EQ(DenoisedView::First(0.1), 4u);
    EXPECT_EQ(DenoisedView::First(10.0), 5u) << "after half as much time as it takes";
    EXPECT_EQ(DenoisedView::Next(10, 10.0), 40u) << "a quarter of the time";
    EXPECT_EQ(DenoisedView::Next(1000, 10.0), 1250u) << "less of it";
    EXPECT_EQ(DenoisedView::Next(1, 0.01), 2u);
    EXPECT_EQ(DenoisedView::Next(1, 1e30), 4000000000u);
}

TEST_F(ViewportDenoised, IsShownOnceThereAreSomeSamplesAndIsLessNoisy) {
    viewed.RenderFrames(1);
    EXPECT_EQ(DenoisedSamples(), 0u);
    uint32_t frames = 1, made = 0;
    for (; frames < 100 && DenoisedSamples() == 0; ++frames) {
        viewed.RenderFrames(1);
        made += Denoises() ? 1 : 0;
    }
    EXPECT_EQ(DenoisedSamples(), viewed.Samples());
    EXPECT_GE(DenoisedSamples(), 4u);
    EXPECT_EQ(made, 1u);
    EXPECT_EQ(viewed.Samples(), frames) << "a sample a frame, as without";
    const Picture denoised = viewed.Picture();
    EXPECT_FALSE(Denoises()) << "it is kept";
    EXPECT_EQ(viewed.Samples(), frames + 1) << "samples go on";
    SetDenoised(false);
    const Picture mean = viewed.Picture();
    viewed.viewport.SetBudget({.samplesPerFrame = 64});
    viewed.RenderFrames(32);
    const Picture converged = viewed.Picture();
    EXPECT_LT(MeanDifference(denoised, converged), 0.6 * MeanDifference(mean, converged));
}

TEST_F(ViewportDenoised, IsMadeAnewAsSamplesGrow) {
    viewed.viewport.SetBudget({.samplesPerFrame = 64});
    uint32_t last = 0, made = 0;
    for (int i = 0; i < 60; ++i) {
        viewed.RenderFrames(1);
        const uint32_t now = DenoisedSamples();
        if (now == last) continue;
        if (last > 0) {
            EXPECT_GE(now, last + last / 4);
        }
        last = now;
        ++made;
    }
    EXPECT_GE(made, 3u);
    EXPECT_LE(made, 30u);
    EXPECT_GT(last, viewed.Samples() / 2);
}

TEST_F(ViewportDenoised, SamplesAreThoseWithoutIt) {
    viewed.viewport.SetBudget({.maxSamples = 16});
    viewed.RenderFrames(20);
    const viewport::CaptureResult denoised = Capture();
    EXPECT_EQ(DenoisedSamples(), 16u) << "of all that there will be";
    SetDenoised(false);
    const Picture mean = viewed.Picture();
    const viewport::CaptureResult plain = Capture();
    EXPECT_EQ(denoised.sampleCount, 16u);
    EXPECT_EQ(denoised.sums, plain.sums);
    EXPECT_EQ(denoised.mean, plain.mean);
    EXPECT_EQ(denoised.denoised.size(), denoised.mean.size());
    EXPECT_NE(denoised.denoised, denoised.mean);
    EXPECT_TRUE(plain.denoised.empty());
    ViewedScene other(Device());
    other.viewport.SetBudget({.samplesPerFrame = 16, .maxSamples = 16});
    other.RenderFrames(1);
    EXPECT_EQ(other.Picture(), mean);
}

// The first half tells how noisy a picture is. One that begins to denoise late lacks it.
TEST_F(ViewportDenoised, MeanOfTheFirstHalfIsUsedWhereThereIsOne) {
    viewed.viewport.SetBudget({.maxSamples = 16});
    viewed.RenderFrames(20);
    ViewedScene late(Device());
    late.viewport.SetBudget({.maxSamples = 16});
    late.RenderFrames(20);
    const Picture denoised = viewed.Picture(), mean = late.Picture();
    late.viewport.SetShow({.isDenoised = true});
    const Picture denoisedLate = late.Picture();
    EXPECT_NE(denoisedLate, mean);
    EXPECT_NE(denoised, denoisedLate);
}

// Passes are divided and wait for later frames where a frame may take a moment only.
TEST_F(ViewportDenoised, PictureOfManyFramesIsThatOfOneFrame) {
    viewed.viewport.SetBudget({.maxSamples = 16});
    viewed.RenderFrames(20);
    ASSERT_EQ(DenoisedSamples(), 16u);
    ViewedScene other(Device());
    other.viewport.SetShow({.isDenoised = true});
    other.viewport.SetBudget({.frameMs = 2.0, .maxSamples = 16, .settleMs = 0.0});
    uint32_t parts = 0, samplesMeanwhile = 0;
    for (int i = 0; i < 20'000 && other.viewport.Progress().denoisedSamples < 16; ++i) {
        const uint32_t before = other.Samples();
        other.RenderFrames(1);
        if (other.renderer.DescribePlan().find("its series goes on") == std::string::npos) continue;
        ++parts;
        samplesMeanwhile += other.Samples() - before;
    }
    EXPECT_EQ(other.viewport.Progress().denoisedSamples, 16u);
    EXPECT_GT(parts, 20u);
    EXPECT_GT(samplesMeanwhile, 0u) << "samples go on";
    EXPECT_EQ(other.Picture(), viewed.Picture());
}

TEST_F(ViewportDenoised, CaptureIsDenoisedWithItsSamplesWhateverWasShown) {
    viewed.viewport.SetBudget({.samplesPerFrame = 64});
    viewed.RenderFrames(8);
    const viewport::CaptureResult first = Capture(), second = Capture();
    EXPECT_GT(second.sampleCount, first.sampleCount);
    EXPECT_NE(first.denoised, second.denoised);
    EXPECT_EQ(DenoisedSamples(), second.sampleCount);
}

TEST_F(ViewportDenoised, AChangeShowsTheMeanAtOnce) {
    viewed.viewport.SetBudget({.samplesPerFrame = 64, .settleMs = 0.0});
    viewed.RenderFrames(4);
    ASSERT_GT(DenoisedSamples(), 0u);
    viewed.viewport.SetBudget({.settleMs = 1e9});
    Move();
    viewed.RenderFrames(1);
    EXPECT_EQ(DenoisedSamples(), 0u);
    viewed.RenderFrames(30);
    EXPECT_EQ(DenoisedSamples(), 0u) << "the camera may go on moving";
    EXPECT_FALSE(Denoises());
    viewed.viewport.SetBudget({.settleMs = 0.0});
    RenderUntilDenoised();
    EXPECT_GT(DenoisedSamples(), 30u) << "of all samples since the camera moved";
    viewed.viewport.SetSize({31, 7});
    EXPECT_EQ(viewed.Picture().size(), size_t{4} * 31 * 7);
    EXPECT_EQ(DenoisedSamples(), 0u);
    RenderUntilDenoised();
    EXPECT_GT(DenoisedSamples(), 0u);
}

TEST_F(ViewportDenoised, TilesOfALimitedFrameEndWithWholeSamples) {
    viewed.viewport.SetSize({96, 64});
    viewed.viewport.SetBudget({.frameMs = 4.0, .settleMs = 0.0});
    for (int i = 0; i < 20'000 && DenoisedSamples() == 0; ++i) viewed.RenderFrames(1);
    EXPECT_GE(DenoisedSamples(), 4u);
}

TEST_F(ViewportDenoised, OtherViewsShowWhatTheyDidWithoutIt) {
    for (const View view : {View::Raster, View::Wipe, View::RealTime, View::Surface}) {
        SCOPED_TRACE(viewport::Name(view));
        viewed.viewport.SetShow({.view = view, .isDenoised = true});
        viewed.RenderFrames(20);
        EXPECT_EQ(DenoisedSamples(), 0u);
        EXPECT_FALSE(Denoises());
    }
}

TEST_F(ViewportDenoised, NoFrameWaitsForItsPipelines) {
    viewed.viewport.SetBudget({.whilePreparing = viewport::PreparingView::Preview, .settleMs = 0.0});
    for (int i = 0; i < 100'000 && DenoisedSamples() == 0; ++i) viewed.RenderFrames(1);
    EXPECT_GE(DenoisedSamples(), 4u);
}

TEST_F(ViewportDenoised, PictureThatIsStaleOrNotShownAnyMoreGivesItsMemoryBack) {
    const auto usedBytes = [&] {
        Device().WaitIdle();
        Device().CollectGarbage();
        return Device().Memory().usedBytes;
    };
    const auto renderUntilDivided = [&] {
        viewed.viewport.SetBudget({.frameMs = 2.0, .settleMs = 0.0});
        SetDenoised(true);
        const auto isDivided = [&] {
            return viewed.renderer.DescribePlan().find("its series goes on") != std::string::npos;
        };
        for (int i = 0; i < 20'000; ++i) {
            viewed.RenderFrames(1);
            if (isDivided()) return true;
        }
        return false;
    };
    constexpr uint64_t kPlane = 96 * 64 * 16;
    viewed.viewport.SetSize({96, 64});
    viewed.viewport.SetBudget({.frameMs = 2.0, .settleMs = 0.0});
    SetDenoised(false);
    viewed.RenderFrames(60);
    const uint64_t without = usedBytes();
    ASSERT_TRUE(renderUntilDivided());
    EXPECT_GT(usedBytes(), without + 4 * kPlane);
    viewed.viewport.SetBudget({.settleMs = 1e9});
    Move();
    viewed.RenderFrames(20);
    EXPECT_LT(usedBytes(), without + kPlane) << "of other samples";
    ASSERT_TRUE(renderUntilDivided());
    SetDenoised(false);
    viewed.RenderFrames(80);
    EXPECT_LT(usedBytes(), without + kPlane) << "not shown any more";
    viewed.viewport.SetShow({.view = View::RealTime});
    viewed.RenderFrames(3);
    EXPECT_GT(usedBytes(), without + kPlane);
    viewed.viewport.SetShow({});
    viewed.RenderFrames(80);
    EXPECT_LT(usedBytes(), without + kPlane);
}

}  // namespace raygraph::testing::denoised_view_test

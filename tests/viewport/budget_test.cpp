// A frame's budget: what it learns, and that submissions keep to it.
#include <algorithm>
#include <chrono>
#include <thread>

#include "editor/viewport/frame_budget.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::budget_test {

using passes::Region;
using passes::TileCursor;
using viewport::FrameBudget;

TEST(FrameBudgetTest, Tiles_GrowStepByStepToWhatTheLimitAllows) {
    FrameBudget budget;
    budget.SetLimit(10.0);
    const Extent2D picture{1000, 1000};
    EXPECT_EQ(budget.PixelsWithin(picture, {}, budget.TracingMs()), FrameBudget::kFirstPixels);
    // A device of 10,000 pixels a millisecond
    TileCursor cursor;
    uint64_t last = 0;
    for (int frame = 0; frame < 8; ++frame) {
        const Region tile = cursor.Next(picture, budget.PixelsWithin(picture, cursor, budget.TracingMs()));
        EXPECT_LE(double(tile.PixelCount()) / 1e4, 10.0);
        EXPECT_LE(tile.PixelCount(), std::max<uint64_t>(4 * last, FrameBudget::kFirstPixels));
        budget.LearnTile(picture.height, tile, double(tile.PixelCount()) / 1e4);
        last = tile.PixelCount();
        cursor.Advance(picture, tile);
    }
    EXPECT_NEAR(double(last), 70'000.0, 3'000.0);
}

TEST(FrameBudgetTest, Costs_RiseAtOnceFallByHalvesAndBelongToARow) {
    FrameBudget budget;
    budget.SetLimit(10.0);
    budget.LearnTile(320, {0, 0, 100, 320}, 32.0);  // 1 us a pixel everywhere
    const Region top{0, 0, 100, 10}, bottom{0, 300, 100, 10};
    EXPECT_NEAR(budget.Expect(320, top), 1.0, 1e-9);
    budget.LearnTile(320, top, 20.0);
    EXPECT_NEAR(budget.Expect(320, top), 20.0, 1e-9);
    EXPECT_NEAR(budget.Expect(320, bottom), 1.0, 1e-9);
    budget.LearnTile(320, top, 1.0);
    EXPECT_NEAR(budget.Expect(320, top), 10.5, 1e-9);
    // The same height of the picture at another resolution
    EXPECT_NEAR(budget.Expect(32, {0, 0, 100, 1}), 1.05, 1e-9);
    TileCursor atBottom;
    atBottom.Advance({100, 320}, {0, 0, 100, 300});
    EXPECT_GT(budget.PixelsWithin({100, 320}, atBottom, 1.0), 5 * budget.PixelsWithin({100, 320}, {}, 1.0));
    budget.Forget();
    EXPECT_FALSE(budget.HasLearned());
}

TEST(FrameBudgetTest, WhatElseAFrameDoes_IsTakenOffButNeverAll) {
    FrameBudget budget;
    budget.SetLimit(10.0);
    const double alone = budget.TracingMs();
    budget.LearnOverhead(4.0);
    EXPECT_NEAR(budget.TracingMs(), alone - 4.0, 1e-9);
    budget.LearnOverhead(400.0);
    EXPECT_GT(budget.TracingMs(), 1.0);
}

TEST(FrameBudgetTest, RasterPictures_AreAsCoarseAsTheLimitAsks) {
    FrameBudget budget;
    EXPECT_EQ(budget.RasterScale(1'000'000), 1u);
    budget.SetLimit(10.0);
    EXPECT_EQ(budget.RasterScale(1'000'000), 1u);
    budget.LearnRaster(1'000'000, 50.0);
    EXPECT_EQ(budget.RasterScale(1'000'000), 4u);
    EXPECT_EQ(budget.RasterScale(100'000), 1u);
    budget.LearnRaster(1'000'000, 1e9);
    EXPECT_EQ(budget.RasterScale(1'000'000), 16u);
}

namespace {

class ViewportBudget : public VulkanTest {
  protected:
    // GPU milliseconds of the frames that were executed since the last call.
    std::vector<double> FrameTimes() {
        Device().WaitIdle();
        std::vector<double> times;
        for (const FrameTiming& timing : viewed.renderer.TakeTimings()) {
            double sum = 0.0;
            for (const PassTiming& pass : timing.passes) sum += pass.gpuMs;
            times.push_back(sum);
        }
        return times;
    }
    // The shortest frame of a whole sample at that size.
    double SampleMs(Extent2D size) {
        viewed.viewport.SetSize(size);
        viewed.RenderFrames(4);
        const std::vector<double> times = FrameTimes();
        return *std::min_element(times.begin() + 1, times.end());
    }
    static double Median(std::vector<double> times) {
        std::nth_element(times.begin(), times.begin() + std::ssize(times) / 2, times.end());
        return times[times.size() / 2];
    }

    static constexpr Extent2D kSize{160, 96};
    ViewedScene viewed{Device(), kSize};
};

}  // namespace

TEST_F(ViewportBudget, Submissions_KeepToALimitThatASampleExceeds) {
    if (Device().Info().timestampValidBits == 0) GTEST_SKIP() << "the device has no timestamps";
    // So large that a sample takes many times as long as the first tile: a device that has room for all
    // pixels at once takes as long for few of them, and no tile would keep to the limit.
    const double tile = SampleMs({32, FrameBudget::kFirstPixels / 32});
    Extent2D size = kSize;
    double sample = SampleMs(size);
    while (sample < 6.0 * tile && size.width < 4096) {
        size = {2 * size.width, 2 * size.height};
        sample = SampleMs(size);
    }
    RecordProperty("size", std::to_string(size.width) + "x" + std::to_string(size.height));
    const double limit = sample / 4.0;

    viewed.viewport.SetBudget({.frameMs = limit});
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.02f;
    viewed.viewport.SetCamera(camera);
    std::vector<double> times;
    std::vector<uint32_t> coarseness;
    do {
        viewed.RenderFrames(1);
        const std::vector<double> arrived = FrameTimes();
        times.insert(times.end(), arrived.begin(), arrived.end());
        coarseness.push_back(viewed.viewport.Progress().coarseness);
    } while (viewed.Samples() < 1 && times.size() < 400);
    EXPECT_EQ(viewed.Samples(), 1u);
    EXPECT_GT(times.size(), 4u);
    // Machines that do other things as well delay them: what counts is that none is near a whole sample
    EXPECT_LT(Median(times), 2.0 * limit);
    // Something is seen after the first frame, and it only gets finer
    EXPECT_GT(coarseness.front(), 1u);
    EXPECT_TRUE(std::is_sorted(coarseness.rbegin(), coarseness.rend()));
    EXPECT_EQ(coarseness.back(), 1u);
}

TEST_F(ViewportBudget, PictureInTiles_IsThatOfWholeSamples) {
    viewed.RenderFrames(1);
    const std::vector<uint8_t> whole = viewed.Picture();
    ViewedScene tiled(Device(), kSize);
    tiled.viewport.SetBudget({.frameMs = 4.0, .maxSamples = 2});
    uint32_t frames = 0;
    for (; frames < 2000 && tiled.Samples() < 2; ++frames) tiled.RenderFrames(1);
    EXPECT_GT(frames, 1u);
    EXPECT_EQ(tiled.Samples(), 2u);
    EXPECT_EQ(tiled.viewport.Progress().pathTracedFraction, 0.0);
    EXPECT_EQ(tiled.Picture(), whole);
}

// While nothing changes frames are filled; while something does, each has one sample.
TEST_F(ViewportBudget, StillPictures_GetAsManySamplesAFrameAsFit) {
    if (Device().Info().timestampValidBits == 0) GTEST_SKIP() << "the device has no timestamps";
    const double sample = SampleMs(kSize);
    ViewedScene still(Device(), kSize);
    still.viewport.SetBudget({.frameMs = 40.0 * sample, .maxSamples = 40, .settleMs = 1.0});
    const auto framesTo40 = [&] {
        uint32_t frames = 0;
        for (; still.Samples() < 40 && frames < 200; ++frames) {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
            still.RenderFrames(1);
            Device().WaitIdle();
        }
        return frames;
    };
    EXPECT_LT(framesTo40(), 30u);
    EXPECT_EQ(still.Samples(), 40u);
    viewed.viewport.SetBudget({.maxSamples = 40});
    viewed.viewport.SetSize(kSize);
    viewed.RenderFrames(40);
    EXPECT_EQ(viewed.Samples(), 40u);
    EXPECT_EQ(still.Picture(), viewed.Picture()) << "the bits of one sample after another";

    still.viewport.SetBudget({.frameMs = 40.0 * sample, .maxSamples = 40, .settleMs = 1e9});
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.01f;
    still.viewport.SetCamera(camera);
    still.RenderFrames(1);
    EXPECT_GE(framesTo40(), 39u);
}

TEST_F(ViewportBudget, FirstPictures_LookLikeTheLastOne) {
    viewed.RenderFrames(16);
    const std::vector<uint8_t> done = viewed.Picture();
    ViewedScene tiled(Device(), kSize);
    tiled.viewport.SetBudget({.frameMs = 4.0});
    double worst = 0.0;
    for (int frame = 0; frame < 2000 && tiled.Samples() < 1; ++frame) {
        const std::vector<uint8_t> picture = tiled.Picture();
        double mean = 0.0, sum = 0.0;
        for (size_t i = 0; i < done.size(); ++i) {
            mean += double(done[i]);
            sum += double(picture[i]);
        }
        worst = std::max(worst, std::abs(sum / mean - 1.0));
    }
    // Display values saturate, so that a noisy picture is somewhat darker; black parts would be more
    EXPECT_GE(tiled.Samples(), 1u);
    EXPECT_LT(worst, 0.15);
}

// As the passes of a user interface do, and structures that are refitted: a coarser picture makes none of them
// shorter.
TEST_F(ViewportBudget, RasterPictures_AreNotCoarseForWhatTheHostAdds) {
    if (Device().Info().timestampValidBits == 0) GTEST_SKIP() << "the device has no timestamps";
    viewed.viewport.SetShow({.view = View::Raster});
    const double alone = SampleMs(kSize);
    GpuScene other(viewed.renderer);
    other.SetScene(Boxes());
    Viewport host(viewed.renderer, other, {.name = "host", .size = {96, 96}});
    host.SetCamera(InsideBoxes());
    host.SetPaths(viewed.viewport.Paths());
    host.SetBudget({.samplesPerFrame = 4});
    viewed.viewport.SetBudget({.frameMs = 3.0 * alone, .maxRasterSamples = 1, .settleMs = 1e9});
    scene::CameraView camera = InsideBoxes();
    std::vector<uint32_t> samples;
    for (int frame = 0; frame < 16; ++frame) {
        camera.eye.x += 0.001f;
        viewed.viewport.SetCamera(camera);
        viewed.renderer.BeginFrame();
        viewed.renderer.ReadBack(host.Declare());
        viewed.renderer.Present(viewed.viewport.Declare());
        viewed.renderer.Execute();
        Device().WaitIdle();
        samples.push_back(viewed.viewport.Progress().rasterSamples);
    }
    const std::vector<double> times = FrameTimes();
    EXPECT_GT(Median(times), 6.0 * alone) << "the host adds too little for the test to mean anything";
    // A first frame that compiled shaders, or one that was delayed, makes the next ones coarse, and each frame
    // halves that: counting what the host adds would make all of them coarse.
    EXPECT_GE(std::ranges::count(samples, 1u), std::ssize(samples) / 2)
        << "samples of each frame, 0 for a coarse picture: " << ::testing::PrintToString(samples);
}

TEST_F(ViewportBudget, WithoutTimes_AFrameStillAddsSomething) {
    Renderer renderer(Device(), {.gpuTimes = false});
    GpuScene scene(renderer);
    scene.SetScene(Boxes());
    Viewport untimed(renderer, scene, {.size = {64, 48}});
    untimed.SetCamera(InsideBoxes());
    untimed.SetPaths(viewed.viewport.Paths());
    untimed.SetBudget({.frameMs = 1.0});
    for (int frame = 0; frame < 8; ++frame) untimed.RenderFrame();
    EXPECT_GE(untimed.Progress().pathTracedSamples, 1u);
}

}  // namespace raygraph::testing::budget_test

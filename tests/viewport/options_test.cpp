// Every setting of a viewport changes the views or the counters that it is about, and nothing else. Those of
// what is accumulated (camera, paths, scene): reset_test.cpp.
#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <thread>

#include "base/error.h"
#include "editor/viewport/frame_budget.h"
#include "editor/viewport/real_time_view.h"
#include "tests/support/option_rows.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::options_test {

using viewport::BudgetSettings;
using viewport::MotionView;
using viewport::OutlineSettings;
using viewport::ShowSettings;

namespace {

using Picture = std::string;  // its bytes

constexpr View kViews[] = {View::PathTraced, View::Raster,     View::Wipe,
                           View::SideBySide, View::Difference, View::RelativeError,
                           View::Flip,       View::Surface,    View::RealTime};

// No two properties of a surface look alike.
scene::SceneData ThreeBoxes() {
    scene::SceneData data = Boxes();
    data.materials[1].metallicFactor = 0.3f;
    data.materials[1].roughnessFactor = 0.6f;
    data.instances.push_back({.mesh = 1, .objectToWorld = Translation({0.5f, 0.4f, -0.5f})});
    return data;
}

class ViewportOptions : public VulkanTest {
  protected:
    // Both views have all their samples: from here on, only settings change a picture.
    void TakeAllSamples() {
        viewed.viewport.SetBudget({.maxSamples = 1, .maxRasterSamples = 1});
        viewed.viewport.SetView(View::RealTime);
        viewed.RenderFrames(viewport::RealTimeView::kSettledFrames + 1);
        viewed.viewport.SetView(View::Wipe);
        viewed.RenderFrames(1);
    }
    Picture Show(const ShowSettings& show) {
        viewed.viewport.SetShow(show);
        const std::vector<uint8_t> bytes = viewed.Picture();
        return {bytes.begin(), bytes.end()};
    }
    void ExpectNothingElse() {
        EXPECT_EQ(viewed.AllResets(), 0u);
        EXPECT_EQ(viewed.Samples(), 1u);
        EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 1u);
    }

    ViewedScene viewed{Device(), {24, 16}, ThreeBoxes()};
};

ShowSettings Of(View view) {
    ShowSettings show;
    show.view = view;
    return show;
}

struct ShowRow {
    const char* name;
    void (*change)(ShowSettings&);
    std::set<View> views;  // where it shows
};

const std::set<View> kDisplayed{View::PathTraced, View::Raster, View::Wipe,    View::SideBySide,
                                View::Difference, View::Flip,   View::RealTime};

const ShowRow kShowRows[] = {
    {"compared",
     [](ShowSettings& s) { s.compared = viewport::Compared::RealTime; },
     {View::Wipe, View::SideBySide, View::Difference, View::RelativeError, View::Flip}},
    {"denoised", [](ShowSettings& s) { s.isDenoised = true; }, {View::PathTraced}},
    {"wipe", [](ShowSettings& s) { s.wipePosition = 0.25f; }, {View::Wipe}},
    {"exposure", [](ShowSettings& s) { s.tonemap.exposureEv = -1.0f; }, kDisplayed},
    {"linear", [](ShowSettings& s) { s.tonemap.tonemapOperator = TonemapOperator::Linear; }, kDisplayed},
    {"srgb", [](ShowSettings& s) { s.tonemap.tonemapOperator = TonemapOperator::Srgb; }, kDisplayed},
    {"reinhard", [](ShowSettings& s) { s.tonemap.tonemapOperator = TonemapOperator::Reinhard; }, kDisplayed},
    {"aces", [](ShowSettings& s) { s.tonemap.tonemapOperator = TonemapOperator::Aces; }, kDisplayed},
    {"agx", [](ShowSettings& s) { s.tonemap.tonemapOperator = TonemapOperator::AgX; }, kDisplayed},
    {"opaque", [](ShowSettings& s) { s.tonemap.isOpaque = true; }, {}},  // it always is
    {"unassociated", [](ShowSettings& s) { s.tonemap.isUnassociated = true; }, {}},
    {"white balance", [](ShowSettings& s) { s.tonemap.whiteBalance[0].y = 0.7f; }, kDisplayed},
    // The environment is not hidden
    {"backdrop", [](ShowSettings& s) { s.backdrop = passes::BackdropSettings{}; }, {}},
    {"surface", [](ShowSettings& s) { s.surface = passes::View::Depth; }, {View::Surface}},
    {"error", [](ShowSettings& s) { s.maxError = 4.0f; }, {View::RelativeError}},
    {"pixels per degree", [](ShowSettings& s) { s.pixelsPerDegree = 20.0f; }, {View::Flip}},
};

auto FieldsOf(ShowSettings& s) {
    auto& [view, compared, isDenoised, wipePosition, tonemap, backdrop, surface, maxError, pixelsPerDegree] =
        s;
    auto& [exposure, tonemapOperator, isOpaque, isUnassociated, whiteBalance] = tonemap;
    return std::tie(view, compared, isDenoised, wipePosition, exposure, tonemapOperator, isOpaque,
                    isUnassociated, whiteBalance, backdrop, surface, maxError, pixelsPerDegree);
}

}  // namespace

TEST_F(ViewportOptions, EverySettingOfWhatIsShownShowsInItsViewsAlone) {
    TakeAllSamples();
    auto rows = OptionRowsOf<ShowSettings>([](ShowSettings& s) { return FieldsOf(s); });
    for (const View view : kViews) {
        SCOPED_TRACE(viewport::Name(view));
        if (view != ShowSettings{}.view) rows.Add(viewport::Name(view), {}, Of(view));
        std::map<Picture, std::string> pictures{{Show(Of(view)), "the defaults"}};
        for (const ShowRow& row : kShowRows) {
            ShowSettings show = Of(view);
            row.change(show);
            rows.Add(row.name, Of(view), show);
            const Picture picture = Show(show);
            if (row.views.contains(view)) {
                const auto [found, isNew] = pictures.emplace(picture, row.name);
                EXPECT_TRUE(isNew) << row.name << " looks like " << found->second;
            } else {
                EXPECT_TRUE(pictures.contains(picture) && pictures.at(picture) == "the defaults") << row.name;
            }
        }
    }
    ExpectNothingElse();

    // Every surface view is accepted but those of light.
    std::map<Picture, std::string> pictures;
    for (size_t i = 0; i < passes::kViewCount; ++i) {
        ShowSettings show = Of(View::Surface);
        show.surface = static_cast<passes::View>(i);
        if (show.surface != ShowSettings{}.surface)
            rows.Add(passes::Name(show.surface), Of(View::Surface), show);
        if (passes::ShowsLight(show.surface)) {
            viewed.viewport.SetShow(show);
            EXPECT_THROW(viewed.viewport.RenderFrame(), Error);
            continue;
        }
        const auto [found, isNew] = pictures.emplace(Show(show), passes::Name(show.surface));
        EXPECT_TRUE(isNew) << passes::Name(show.surface) << " looks like " << found->second;
    }
    rows.ExpectComplete();
    ExpectNothingElse();
}

TEST_F(ViewportOptions, EveryViewIsAnotherPictureAndSamplesWhatItShows) {
    std::map<Picture, std::string> pictures;
    for (const View view : kViews) {
        SCOPED_TRACE(viewport::Name(view));
        const uint32_t traced = viewed.Samples(), drawn = viewed.viewport.Progress().rasterSamples;
        const auto [found, isNew] = pictures.emplace(Show(Of(view)), viewport::Name(view));
        EXPECT_TRUE(isNew) << "looks like " << found->second;
        const bool hasSample =
            viewport::ShowsPathTraced(view) && view != View::RealTime;  // not in its first frame
        EXPECT_EQ(viewed.Samples() - traced, hasSample ? 1u : 0u);
        EXPECT_EQ(viewed.viewport.Progress().rasterSamples - drawn,
                  viewport::ShowsRaster(Of(view)) ? 1u : 0u);
    }
    EXPECT_EQ(pictures.size(), EnumeratorCount<View>());
    EXPECT_EQ(viewed.AllResets(), 0u);
}

TEST_F(ViewportOptions, EverySettingOfTheOutlineChangesTheLineAlone) {
    struct Row {
        const char* name;
        void (*change)(OutlineSettings&);
    };
    const Row kRows[] = {{"red", [](OutlineSettings& s) { s.color.x = 0.2f; }},
                         {"green", [](OutlineSettings& s) { s.color.y = 0.1f; }},
                         {"blue", [](OutlineSettings& s) { s.color.z = 0.9f; }},
                         {"width", [](OutlineSettings& s) { s.width = 1.0f; }}};
    auto rows = OptionRowsOf<OutlineSettings>([](OutlineSettings& s) {
        auto& [color, width] = s;
        return std::tie(color.x, color.y, color.z, width);
    });
    TakeAllSamples();
    viewed.viewport.SetView(View::PathTraced);
    const auto frame = [&](const OutlineSettings& settings) {
        viewed.viewport.SetOutline(settings);
        viewed.renderer.BeginFrame();
        const TextureId picture = viewed.viewport.Declare();
        const Readback plain = viewed.renderer.ReadBack(picture),
                       outlined = viewed.renderer.ReadBack(viewed.viewport.DeclareOutline(picture));
        viewed.renderer.Execute();
        outlined.Wait();
        plain.Wait();
        return std::pair(As<uint8_t>(plain.Bytes()), As<uint8_t>(outlined.Bytes()));
    };
    for (const bool isSelected : {false, true}) {
        viewed.viewport.SetOutlined(isSelected ? std::vector<uint32_t>{1} : std::vector<uint32_t>{});
        const auto [picture, line] = frame({});
        for (const Row& row : kRows) {
            OutlineSettings settings;
            row.change(settings);
            rows.Add(row.name, {}, settings);
            const auto [plain, outlined] = frame(settings);
            EXPECT_TRUE(plain == picture) << row.name << " is in what may be saved";
            EXPECT_EQ(outlined != line, isSelected) << row.name;
        }
    }
    rows.ExpectComplete();
    ExpectNothingElse();
}

TEST_F(ViewportOptions, EverySettingOfTheBudgetHasItsCounter) {
    auto rows = OptionRowsOf<BudgetSettings>([](BudgetSettings& s) {
        auto& [frameMs, samplesPerFrame, maxSamples, maxRasterSamples, whileMoving, whilePreparing,
               settleMs] = s;
        return std::tie(frameMs, samplesPerFrame, maxSamples, maxRasterSamples, whileMoving, whilePreparing,
                        settleMs);
    });
    struct Counters {
        uint32_t traced = 0, drawn = 0, coarseness = 1;
        bool operator==(const Counters&) const = default;
    };
    // Counts over three frames; if `moves`, the camera moves before the last one.
    const auto counters = [&](const char* name, const BudgetSettings& before, const BudgetSettings& after,
                              bool moves) {
        SCOPED_TRACE(name);
        rows.Add(name, before, after);
        Viewport viewport(viewed.renderer, viewed.scene, {.name = "counted", .size = {96, 64}});
        viewport.SetCamera(InsideBoxes());
        viewport.SetPaths(viewed.viewport.Paths());
        viewport.SetRaster(PlainRaster());
        viewport.SetBudget(after);
        viewport.SetView(moves ? View::PathTraced : View::Wipe);
        for (int frame = 0; frame < 2; ++frame) viewport.RenderFrame();
        if (moves) {
            scene::CameraView camera = InsideBoxes();
            camera.eye.x += 0.1f;
            viewport.SetCamera(camera);
        }
        viewport.RenderFrame();
        EXPECT_EQ(viewport.ResetCount(passes::ResetCause::Camera), moves ? 1u : 0u);
        EXPECT_EQ(viewport.ResetCount(passes::ResetCause::Settings), 0u);
        const viewport::ViewportProgress progress = viewport.Progress();
        return Counters{progress.pathTracedSamples, progress.rasterSamples, progress.coarseness};
    };
    const auto still = [&](const char* name, const BudgetSettings& after) {
        return counters(name, {}, after, false);
    };
    EXPECT_EQ(still("samples a frame", {.samplesPerFrame = 2}), (Counters{6, 3}));
    EXPECT_EQ(still("samples at most", {.maxSamples = 2}), (Counters{2, 3}));
    EXPECT_EQ(still("drawn samples at most", {.maxRasterSamples = 2}), (Counters{3, 2}));
    const Counters limited = still("limit", {.frameMs = 1e-6});
    EXPECT_EQ(limited.traced, 0u);
    EXPECT_GT(limited.coarseness, 1u);
    constexpr double kForEver = std::numeric_limits<double>::max();
    const BudgetSettings slow{.settleMs = kForEver},
        drawn{.whileMoving = MotionView::Raster, .settleMs = kForEver};
    EXPECT_EQ(counters("shown while moving", slow, drawn, true), (Counters{0, 1, 0}));
    EXPECT_EQ(counters("settled never", {}, slow, true), (Counters{1, 0}));
    EXPECT_EQ(counters("shown while moving", slow,
                       {.whileMoving = MotionView::PathTraced, .settleMs = kForEver}, true),
              (Counters{1, 0}));
    EXPECT_EQ(counters("settled at once", drawn, {.whileMoving = MotionView::Raster, .settleMs = 0.0}, true),
              (Counters{1, 0}));
    // The path tracer for such paths is not there yet
    const BudgetSettings previewed{.whilePreparing = viewport::PreparingView::Preview};
    rows.Add("shown while preparing", {}, previewed);
    for (const bool isPreviewed : {true, false}) {
        Viewport viewport(viewed.renderer, viewed.scene, {.name = "prepared", .size = {96, 64}});
        viewport::PathSettings paths = viewed.viewport.Paths();
        paths.roulette.kind = isPreviewed ? Roulette::Constant : Roulette::Off;
        paths.biases.maxDepth = 3;
        viewport.SetPaths(paths);
        viewport.SetCamera(InsideBoxes());
        viewport.SetBudget(isPreviewed ? previewed : BudgetSettings{});
        viewport.RenderFrame();
        EXPECT_EQ(viewport.Progress().isPreview, isPreviewed);
        EXPECT_EQ(viewport.Progress().pathTracedSamples, isPreviewed ? 0u : 1u);
    }
    rows.ExpectComplete();
}

TEST_F(ViewportOptions, RasterStandsInForPixelsThatAreTooCoarseWhileSomethingChanges) {
    for (const auto motion : {MotionView::Auto, MotionView::PathTraced}) {
        const bool isAuto = motion == MotionView::Auto;
        Viewport viewport(viewed.renderer, viewed.scene, {.name = "changed", .size = {384, 256}});
        viewport.SetCamera(InsideBoxes());
        viewport.SetRaster(PlainRaster());
        viewport.SetBudget({.frameMs = 1e-6, .whileMoving = motion, .settleMs = 1e9});
        const auto move = [&](float x) {
            viewed.scene.SetTransform(1, Translation({x, 0.0f, 0.0f}));
            viewport.RenderFrame();
            return viewport.Progress();
        };
        viewport.RenderFrame();
        EXPECT_EQ(move(0.05f).rasterSamples, 0u) << "times are not known yet";
        for (int i = 0; i < 6; ++i) viewport.RenderFrame();
        while (viewed.renderer.IsPreparingPipelines())
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        viewport.RenderFrame();  // sees that the raster view's pipelines are there
        // A raster picture that the limit makes coarse has no sample, either, but the path tracer has none then
        EXPECT_EQ(move(0.1f).coarseness, isAuto ? 0u : 16u);
        viewport.SetBudget({.frameMs = 1e-6, .whileMoving = motion, .settleMs = 0.0});
        viewport.RenderFrame();
        EXPECT_EQ(viewport.Progress().coarseness, 16u) << "finer pictures take longer than four frames";
        viewport.SetBudget({.frameMs = 1e4, .whileMoving = motion, .settleMs = 0.0});
        move(0.15f);
        EXPECT_LE(viewport.Progress().coarseness, viewport::kCoarsestMotion);
    }
}

}  // namespace raygraph::testing::options_test

// A frame's budget: what it learns, and that submissions keep to it.
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
        budget.AddTileTiming(picture.height, tile, double(tile.PixelCount()) / 1e4);
        last = tile.PixelCount();
        cursor.Advance(picture, tile);
    }
    EXPECT_NEAR(double(last), 70'000.0, 3'000.0);
}

TEST(FrameBudgetTest, Costs_RiseAtOnceFallByHalvesAndBelongToARow) {
    FrameBudget budget;
    budget.SetLimit(10.0);
    budget.AddTileTiming(320, {0, 0, 100, 320}, 32.0);  // 1 us a pixel everywhere
    const Region top{0, 0, 100, 10}, bottom{0, 300, 100, 10};
    EXPECT_NEAR(budget.Expect(320, top), 1.0, 1e-9);
    budget.AddTileTiming(320, top, 20.0);
    EXPECT_NEAR(budget.Expect(320, top), 20.0, 1e-9);
    EXPECT_NEAR(budget.Expect(320, bottom), 1.0, 1e-9);
    budget.AddTileTiming(320, top, 1.0);
    EXPECT_NEAR(budget.Expect(320, top), 10.5, 1e-9);
    // A third of the picture's height takes as long at another resolution.
    EXPECT_NEAR(budget.Expect(32, {0, 0, 100, 1}), 1.05, 1e-9);
    TileCursor atBottom;
    atBottom.Advance({100, 320}, {0, 0, 100, 300});
    EXPECT_GT(budget.PixelsWithin({100, 320}, atBottom, 1.0), 5 * budget.PixelsWithin({100, 320}, {}, 1.0));
    budget.Reset();
    EXPECT_FALSE(budget.HasTimings());
}

TEST(FrameBudgetTest, WhatElseAFrameDoes_IsTakenOffButNeverAll) {
    FrameBudget budget;
    budget.SetLimit(10.0);
    const double alone = budget.TracingMs();
    budget.AddOverheadTiming(4.0);
    EXPECT_NEAR(budget.TracingMs(), alone - 4.0, 1e-9);
    budget.AddOverheadTiming(400.0);
    EXPECT_GT(budget.TracingMs(), 1.0);
}

TEST(FrameBudgetTest, RasterPictures_AreAsCoarseAsTheLimitAsks) {
    FrameBudget budget;
    EXPECT_EQ(budget.RasterScale(1'000'000), 1u);
    budget.SetLimit(10.0);
    EXPECT_EQ(budget.RasterScale(1'000'000), 1u);
    budget.AddRasterTiming(1'000'000, 50.0);
    EXPECT_EQ(budget.RasterScale(1'000'000), 4u);
    EXPECT_EQ(budget.RasterScale(100'000), 1u);
    budget.AddRasterTiming(1'000'000, 1e9);
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

// Passes of a user interface and refits take as long for a coarser picture, so they must not cause one.
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
    EXPECT_GE(std::ranges::count(samples, 1u), std::ssize(samples) / 4)
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

// Materials that change in a shown scene so that rays come to treat their surfaces in another way.
namespace raygraph::testing::material_edit_test {

namespace {

class ViewportMaterialEdit : public VulkanTest {
  protected:
    // A floor with a box in the light of a sun and a bulb, and a mesh of two one-sided walls of which the
    // first is between the camera and the box, and between box and bulb, its back to the camera.
    static scene::SceneData Room(const scene::Material& wall) {
        scene::Material chalk = Lambert({0.8f, 0.7f, 0.5f}), other = chalk;
        chalk.metallicFactor = chalk.specularFactor = 0.0f;
        other.isDoubleSided = false;
        scene::Mesh walls = QuadMesh(0.6f, 1);
        scene::Primitive second = QuadMesh(0.6f, 2).primitives[0];
        for (glm::vec3& position : second.positions) position.z -= 0.5f;
        second.bounds.min.z -= 0.5f;
        second.bounds.max.z -= 0.5f;
        walls.primitives.push_back(std::move(second));
        const glm::mat4x3 flat({1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, -1, 0});
        const glm::mat4x3 upright({0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {-0.2f, -0.4f, 0});
        scene::SceneData data = SceneOf({QuadMesh(3.0f, 0), BoxMesh(0.3f, 0), std::move(walls)},
                                        {chalk, wall, other}, {flat, Translation({0.4f, -0.7f, 0}), upright});
        scene::Light sun, bulb;
        sun.type = scene::LightType::Directional;
        sun.lightToWorld = {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0}};
        bulb.intensity = 0.5f;
        bulb.lightToWorld = Translation({-0.7f, 0.3f, 0.2f});
        data.lights = {sun, bulb};
        return data;
    }
    static scene::Material Wall() {
        scene::Material wall = Lambert(glm::vec3(0.4f));
        wall.isDoubleSided = false;
        return wall;
    }
    static scene::Material Pane() {
        scene::Material pane;
        pane.baseColorFactor = {0.5f, 0.8f, 0.9f, 1.0f};
        pane.metallicFactor = pane.roughnessFactor = 0.0f;
        pane.transmissionFactor = 1.0f;
        return pane;
    }
    static scene::Material Veil() {
        scene::Material veil = Wall();
        veil.alphaMode = scene::AlphaMode::Blend;
        veil.baseColorFactor.a = 0.5f;
        return veil;
    }
    static void Prepare(ViewedScene& viewed, View view) {
        viewport::PathSettings paths = viewed.viewport.Paths();
        paths.scattering.brdf = BrdfModel::Gltf;
        viewed.viewport.SetPaths(paths);
        passes::RasterSettings raster = PlainRaster();
        raster.shadows = passes::RasterShadows::Rays;
        viewed.viewport.SetRaster(raster);
        viewed.viewport.SetBudget({});  // no limit, which compiling shaders on a CPU device could exceed
        viewed.viewport.SetView(view);
    }
};

}  // namespace

TEST_F(ViewportMaterialEdit, AnEditedWall_IsAsInASceneThatHasItSo) {
    for (const View view : {View::PathTraced, View::Raster}) {
        ViewedScene edited(Device(), {24, 16}, Room(Wall()));
        Prepare(edited, view);
        edited.RenderFrames(2);
        std::vector<uint8_t> last = edited.Picture();
        for (const scene::Material& material : {Veil(), Pane(), Wall()}) {
            SCOPED_TRACE(std::string(viewport::Name(view)) + ", alpha mode " +
                         std::to_string(int(material.alphaMode)) + ", transmission " +
                         std::to_string(material.transmissionFactor));
            edited.scene.SetMaterial(1, material);
            edited.RenderFrames(3);
            const std::vector<uint8_t> picture = edited.Picture();
            // Which rays a veil stops hangs on the numbers of its triangles
            if (material.alphaMode == scene::AlphaMode::Opaque) {
                ViewedScene fresh(Device(), {24, 16}, Room(material));
                Prepare(fresh, view);
                fresh.RenderFrames(3);
                EXPECT_EQ(picture, fresh.Picture());
            }
            EXPECT_NE(picture, last) << "the edit does not show";
            last = picture;
        }
    }
}

}  // namespace raygraph::testing::material_edit_test

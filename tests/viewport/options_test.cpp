// Every setting of a viewport changes the views or the counters that it is about, and nothing else. Those of
// what is accumulated (camera, paths, scene): reset_cause_test.cpp.
#include <limits>
#include <map>
#include <set>
#include <string>

#include "base/error.h"
#include "tests/support/option_rows.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::options_test {

using viewport::BudgetSettings;
using viewport::MotionView;
using viewport::OutlineSettings;
using viewport::ShowSettings;

namespace {

using Picture = std::string;  // its bytes

constexpr View kViews[] = {View::PathTraced, View::Raster,        View::Wipe, View::SideBySide,
                           View::Difference, View::RelativeError, View::Flip, View::Surface};

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

const std::set<View> kDisplayed{View::PathTraced, View::Raster,     View::Wipe,
                                View::SideBySide, View::Difference, View::Flip};

const ShowRow kShowRows[] = {
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
    {"surface", [](ShowSettings& s) { s.surface = passes::View::Depth; }, {View::Surface}},
    {"error", [](ShowSettings& s) { s.maxError = 4.0f; }, {View::RelativeError}},
    {"pixels per degree", [](ShowSettings& s) { s.pixelsPerDegree = 20.0f; }, {View::Flip}},
};

auto FieldsOf(ShowSettings& s) {
    auto& [view, wipePosition, tonemap, surface, maxError, pixelsPerDegree] = s;
    auto& [exposure, tonemapOperator, isOpaque, isUnassociated, whiteBalance] = tonemap;
    return std::tie(view, wipePosition, exposure, tonemapOperator, isOpaque, isUnassociated, whiteBalance,
                    surface, maxError, pixelsPerDegree);
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

    // Of all surface views, those of light are refused
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
        EXPECT_EQ(viewed.Samples() - traced, viewport::ShowsPathTraced(view) ? 1u : 0u);
        EXPECT_EQ(viewed.viewport.Progress().rasterSamples - drawn, viewport::ShowsRaster(view) ? 1u : 0u);
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
    // Of three frames, the camera having moved before the last one if `moves`
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

}  // namespace raygraph::testing::options_test

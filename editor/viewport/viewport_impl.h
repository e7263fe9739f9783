// Holds the private state of a Viewport. Only for the sources of this folder.
#pragma once

#include <chrono>
#include <deque>
#include <string>

#include "editor/viewport/compare_view.h"
#include "editor/viewport/denoised_view.h"
#include "editor/viewport/kept_display.h"
#include "editor/viewport/outline_view.h"
#include "editor/viewport/path_traced_view.h"
#include "editor/viewport/raster_view.h"
#include "editor/viewport/real_time_view.h"
#include "editor/viewport/viewport.h"

namespace raygraph::viewport {

struct Viewport::Impl {
    using Clock = std::chrono::steady_clock;

    Impl(Renderer& ofRenderer, GpuScene& ofScene, const ViewportDesc& desc);

    TextureId Declare(const SceneIds& ids);
    TextureId DeclareOutline(TextureId picture);
    // Restarts accumulation for each cause since the last declared frame.
    void DetectChanges();
    void Restart(passes::ResetCause cause);
    // Updates the budget's estimates with the times of earlier frames.
    void UpdateBudgets();
    // Returns the limits of this frame's samples: it ends where their mean is denoised.
    BudgetSettings Limits(const ShowSettings& shownAs);
    // Returns the display of the denoised mean, or `display`, that of the mean itself, while there is none.
    TextureId DisplayDenoised(const SceneIds& ids, const passes::TraceSettings& settings,
                              const PathTracedView::Ids& traced, TextureId display,
                              const passes::TonemapSettings& tonemap,
                              const std::optional<passes::Backdrop>& backdrop);
    // Returns how this frame is shown: as requested, but opaque, and by another view while the camera moves.
    // Returns `show`, with another view where the hidden environment leaves it no picture.
    ShowSettings RequestedAs() const;
    ShowSettings ShownAs() const;
    bool IsRecent(const std::optional<Clock::time_point>& time) const;
    void ReleaseRealTime();
    void ReleaseDenoised();
    // Releases the memory of views that have not been shown for a while.
    void ReleaseUnseen(const ShowSettings& shownAs);
    // Returns the display of a picture of the real-time view, with which the samples of that progress are
    // blended. Without a whole one, each picture is another; else that of the last frame stays if it is the
    // same.
    TextureId DisplayRealTime(TextureId picture, const passes::Accumulation::Progress& blended,
                              const passes::TonemapSettings& tonemap);
    TextureId DisplayHandOver(TextureId picture, const passes::AccumulatedIds& accumulated,
                              const passes::TonemapSettings& tonemap);
    // Returns an invalid id while pipelines are being made and no frame may wait for them.
    TextureId DeclareRealTime(const SceneIds& ids, const passes::TraceSettings& settings,
                              const passes::TonemapSettings& tonemap);
    TextureId DeclareSurface(const SceneIds& ids, const passes::TraceSettings& settings);

    // Answers what was asked about the pictures that are shown, if they are.
    void AnswerRequests(const SceneIds& ids, const passes::TraceSettings& settings,
                        const std::optional<PixelRequests::Shown>& pathTracedShown,
                        const std::optional<PixelRequests::Shown>& rasterShown);

    // Holds everything that the picture depends on, in the last declared frame.
    struct DrawnInputs {
        const GpuScene* scene = nullptr;
        SceneRevisions revisions;
        scene::CameraView camera;
        LensSettings lens;
        PathSettings paths;
        passes::RasterSettings rasterSettings;
        Extent2D size;
    };
    struct TimedFrame {
        uint64_t frame = 0;
        uint64_t rasterPixels = 0;                // 0: the raster view is not shown alone
        PassId firstDrawing, endDrawing;          // passes that draw these pixels
        std::vector<PathTracedView::Tile> tiles;  // empty: the path-traced view is not shown
        DenoisedView::Ids denoised;
        RealTimeView::Ids realTime;  // pixels of 0: no frame of the real-time view was filtered
    };
    void NoteTimed(const TimedFrame& timed);

    Renderer& renderer;
    GpuScene* scene;
    std::string name;
    Extent2D size;
    scene::CameraView camera;
    LensSettings lens;
    ShowSettings show;
    PathSettings paths;
    passes::RasterSettings rasterSettings;
    BudgetSettings budgetSettings;
    OutlineSettings outlineSettings;

    FrameBudget budget;
    PathTracedView pathTraced;
    RasterView raster;
    RealTimeView realTime;
    DenoisedView denoised;
    DenoisedView::Ids denoisedIds;  // of the last declared frame; without a picture, it shows none
    uint64_t realTimeVersion = 0;   // of the picture in realTimeDisplay
    passes::Accumulation::Progress realTimeBlended;
    CachedDisplay pathTracedDisplay, rasterDisplay, realTimeDisplay, denoisedDisplay;
    passes::BlurredEnvironment blurredEnvironment;
    CompareView compare;
    OutlineView outline;
    PixelRequests requests;
    CaptureRequests captures;
    NoiseRequests errors;
    RealTimeErrorRequests realTimeErrors;
    std::optional<DrawnInputs> drawnInputs;
    std::optional<Clock::time_point> movedAt;    // last change of the camera
    std::optional<Clock::time_point> changedAt;  // last change of anything
    std::weak_ptr<const void> declaredIn;
    // These are of the last declared frame
    SceneIds declaredScene;
    passes::TraceSettings declaredSettings;
    std::deque<TimedFrame> timedFrames;  // submitted frames whose times are pending
    uint32_t framesWithoutRealTime = 0, framesWithoutDenoised = 0;  // declared since these were shown
    double lastFrameMs = 0.0;
    bool isPreview = false;      // whether the last declared frame shows a preview
    bool isRasterReady = false;  // the raster view's pipelines exist, for MotionView::Auto
};

}  // namespace raygraph::viewport

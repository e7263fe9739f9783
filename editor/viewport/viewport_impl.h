// What a Viewport keeps behind its public face. For the sources of this folder alone.
#pragma once

#include <chrono>
#include <deque>
#include <string>

#include "editor/viewport/compare_view.h"
#include "editor/viewport/kept_display.h"
#include "editor/viewport/outline_view.h"
#include "editor/viewport/path_traced_view.h"
#include "editor/viewport/raster_view.h"
#include "editor/viewport/viewport.h"

namespace raygraph::viewport {

struct Viewport::Impl {
    using Clock = std::chrono::steady_clock;

    Impl(Renderer& ofRenderer, GpuScene& ofScene, const ViewportDesc& desc);

    TextureId Declare(const SceneIds& ids);
    TextureId DeclareOutline(TextureId picture);
    // Starts anew for each cause that there is since the frame declared last.
    void NoteChanges();
    void StartAnew(passes::ResetCause cause);
    // What the times of earlier frames say about the next.
    void LearnFromTimings();
    // The view of this frame: not the one that was asked for while the camera moves.
    View ShownView() const;
    bool IsRecent(const std::optional<Clock::time_point>& time) const;
    passes::TraceSettings TraceSettingsNow() const;
    TextureId DeclareSurface(const SceneIds& ids, const passes::TraceSettings& settings);

    // Everything that the picture depends on, as of the frame declared last.
    struct DrawnFrom {
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
        uint64_t rasterPixels = 0;                // 0: the raster view is not alone
        std::vector<PathTracedView::Tile> tiles;  // empty: the path-traced view is not shown
    };
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
    KeptDisplay pathTracedDisplay, rasterDisplay;
    CompareView compare;
    OutlineView outline;
    PixelRequests requests;
    CaptureRequests captures;
    ErrorRequests errors;
    std::optional<DrawnFrom> drawnFrom;
    std::optional<Clock::time_point> movedAt;    // the camera
    std::optional<Clock::time_point> changedAt;  // anything
    std::weak_ptr<const void> declaredIn;
    // Of that frame
    SceneIds declaredScene;
    passes::TraceSettings declaredSettings;
    std::deque<TimedFrame> timedFrames;  // submitted, without times so far
    double lastFrameMs = 0.0;
};

}  // namespace raygraph::viewport

// Defines what a Viewport shows, and how. Threads: plain values and pure functions, for any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "base/api.h"
#include "passes/tonemap.h"
#include "passes/trace.h"
#include "passes/views.h"
#include "shaders/shared/choice.h"

namespace raygraph::viewport {

//   PathTraced, Raster
// Views that compare the path-traced picture with another one, ShowSettings::compared:
//   Wipe:          path-traced left of a line, the other right of it
//   SideBySide:    both at half the size
//   Difference:    |other - path-traced| of the radiance, exposed and tone-mapped
//   RelativeError: of the other's luminance against the path-traced one, as colors
//   Flip:          what a person sees who switches between the two, as colors (passes/flip.h)
// Others:
//   RealTime:      path-traced, without most of the noise while something moves; then it becomes PathTraced
//   Surface:       a property of what is seen, or what it costs: ShowSettings::surface
#define RAYGRAPH_VIEWPORT_VIEWS(X, Of)            \
    X(Of, PathTraced, 0, "path-traced", "")       \
    X(Of, Raster, 1, "raster", "")                \
    X(Of, Wipe, 2, "wipe", "")                    \
    X(Of, SideBySide, 3, "side by side", "")      \
    X(Of, Difference, 4, "difference", "")        \
    X(Of, RelativeError, 5, "relative error", "") \
    X(Of, Flip, 6, "FLIP", "")                    \
    X(Of, Surface, 7, "surface", "")              \
    X(Of, RealTime, 8, "real-time", "")
RAYGRAPH_CHOICE(View, RAYGRAPH_VIEWPORT_VIEWS)
inline constexpr auto kViewCount = static_cast<uint32_t>(Texts(View{}).size());
RAYGRAPH_API bool ShowsPathTraced(View view);
RAYGRAPH_API bool IsComparison(View view);
// Returns whether the view has statistics (Viewport::Numbers).
RAYGRAPH_API bool IsMeasured(View view);

// Names what is compared with the path-traced picture.
//   Raster:   the raster view
//   RealTime: the filtered picture of the real-time view. It is filtered on in every frame, and never blended
//             with the path-traced picture, which would hide its error
#define RAYGRAPH_VIEWPORT_COMPARED(X, Of) \
    X(Of, Raster, 0, "raster", "")        \
    X(Of, RealTime, 1, "real-time", "")
RAYGRAPH_CHOICE(Compared, RAYGRAPH_VIEWPORT_COMPARED)

// Tells how the picture is shown. No setting here ever restarts accumulation.
struct ShowSettings {
    View view = View::PathTraced;
    Compared compared = Compared::Raster;
    // View::PathTraced shows a denoised picture once there are some samples (passes/denoise.h), and updates
    // it as they get more (Viewport::Progress). The samples stay as they are, and so do views that compare
    // them.
    bool isDenoised = false;
    float wipePosition = 0.5f;  // fraction of the width that is path-traced; clamped to [0, 1]
    // The picture is opaque, but where PathSettings::isEnvironmentHidden, with isUnassociated.
    passes::TonemapSettings tonemap{};
    // It is shown behind the scene with PathSettings::isEnvironmentHidden, in path-traced and raster
    // pictures. The real-time view has no alpha: it is replaced by the denoised path-traced one then, and
    // comparisons are with the raster view.
    std::optional<passes::BackdropSettings> backdrop = {};
    passes::View surface = passes::View::Normals;  // for View::Surface; not a view of light
    float maxError = 1.0f;                         // relative error at the end of the color map; above 0
    float pixelsPerDegree = 67.0206433f;           // the screen as seen by the user, for View::Flip; 1 to 400

    bool operator==(const ShowSettings&) const = default;
};

RAYGRAPH_API bool ShowsRaster(const ShowSettings& show);
RAYGRAPH_API bool ComparesRealTime(const ShowSettings& show);

// Styles the outline of the selection (Viewport::DeclareOutline).
struct OutlineSettings {
    glm::vec3 color{1.0f, 0.62f, 0.2f};  // display values
    float width = 2.0f;                  // pixels, above 0, at most 8

    bool operator==(const OutlineSettings&) const = default;
};

using passes::LensSettings;
using passes::PathSettings;  // a change restarts accumulation, with ResetCause::Settings

// Selects what is shown instead of the path-traced picture while something changes.
//   Auto:       raster, where pixels of kCoarsestMotion are known to exceed the limit. The first picture
//               after the change has at least that resolution, unless that takes longer than four frames
//   PathTraced: none; it is as fine as the limit allows
//   Raster:     raster while the camera moves
#define RAYGRAPH_MOTION_VIEWS(X, Of)        \
    X(Of, Auto, 0, "automatic", "")         \
    X(Of, PathTraced, 1, "path-traced", "") \
    X(Of, Raster, 2, "raster", "")
RAYGRAPH_CHOICE(MotionView, RAYGRAPH_MOTION_VIEWS)
inline constexpr uint32_t kCoarsestMotion = 8;  // pixels of the picture along an edge

// Selects what a frame shows as path-traced while the pipelines for that are made, which may take seconds.
enum class PreparingView : uint8_t {
    PathTraced,  // samples: Renderer::Execute waits for the pipelines
    // Nothing waits. Until the pipelines are ready, the picture stays as it is or becomes a preview: surfaces
    // lit from the camera (passes/trace.h), which counts as no sample (ViewportProgress::isPreview). The
    // program of the frame before stays in use for a scene that needs fewer features.
    Preview,
};

// Limits the work of a frame. A change does not restart accumulation.
struct BudgetSettings {
    // Milliseconds of device time that a frame may take; 0: no limit. With a limit, a sample that takes
    // longer is split into tiles, after coarser pictures that fit. It needs GPU times: without them
    // (RendererDesc::gpuTimes, or a device without timestamps) a frame traces FrameBudget::kFirstPixels
    // pixels.
    double frameMs = 0.0;
    // Most samples of the path-traced view per frame, as the limit allows. 0: with a limit, as many as fit it
    // while nothing changes; else one.
    uint32_t samplesPerFrame = 0;
    uint32_t maxSamples = 0;  // the path-traced view stops there; 0: never
    uint32_t maxRasterSamples =
        64;  // the raster view stops there; 0: never. Its pictures are jittered, which smooths edges
    MotionView whileMoving = MotionView::Auto;
    PreparingView whilePreparing = PreparingView::PathTraced;
    double settleMs = 150.0;  // in milliseconds: after a change, the picture counts as changing for so long

    bool operator==(const BudgetSettings&) const = default;
};

}  // namespace raygraph::viewport

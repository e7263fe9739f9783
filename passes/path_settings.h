// The options from which a viewport and an offline render make the settings of their frames. Threads: plain
// values and pure functions, for any thread.
#pragma once

#include "base/api.h"
#include "passes/trace.h"
#include "renderer/scene/model/camera_view.h"

namespace raygraph::passes {

// A thin lens; radius 0 is a pinhole. Meters. The raster view has none.
struct LensSettings {
    float radius = 0.0f;
    float focusDistance = 1.0f;  // along the view direction to the plane in focus

    bool operator==(const LensSettings&) const = default;
};

// Returns the settings for sample 0 of a whole picture. The aspect ratio is that of the extent, which must
// not be empty, and the camera's own is ignored.
RAYGRAPH_API TraceSettings FrameSettings(Extent2D extent, const scene::CameraView& camera,
                                         const LensSettings& lens, const PathSettings& paths);

}  // namespace raygraph::passes

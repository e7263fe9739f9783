// Limit and LimitPath: the cost of tracing on this device without a path tracer around it. Measured beside
// Trace in one run they turn its time into an efficiency that can be compared between machines. Threads: that
// of the Renderer.
#pragma once

#include "base/api.h"
#include "passes/trace.h"

namespace raygraph::passes {

enum class LimitKind : uint8_t {
    CameraRays,    // Trace's camera rays in the same TLAS, one value written
    Path,          // the same with four cosine bounces, no shading
    SoftwarePath,  // the same by the scene's own trees, which it must have: SceneIds::wideNodes
};

// Returns r32f, whose values have no meaning. `rayCounts` as in Trace.
[[nodiscard]] RAYGRAPH_API TextureId Limit(Renderer& renderer, const SceneIds& scene,
                                           const TraceSettings& settings, LimitKind kind,
                                           TextureId* rayCounts = nullptr);

}  // namespace raygraph::passes

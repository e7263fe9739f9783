// TraceBuffer and TraverseBuffer: the rays of a buffer by the driver and by a compute shader, for
// measuring one against the other. Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "renderer/bvh/traversal_scene.h"

namespace raygraph::passes {

enum class RayQuestion : uint8_t {
    Nearest,  // all of gpu::WideHit
    Any,      // its t alone: negative where nothing is on the ray
};

// `rays` holds `count` gpu::BenchRays; returns as many gpu::WideHits. The passes are called
// "DriverNearest", "DriverAny", "WideNearest" and "WideAny", and are never culled.
[[nodiscard]] RAYGRAPH_API BufferId TraceBuffer(Renderer& renderer, const DriverScene::Ids& scene,
                                                BufferId rays, uint32_t count, RayQuestion question);

struct TraverseSettings {
    RayQuestion question = RayQuestion::Nearest;
    bool hasOneLevel = false;    // the scene is of BuildOneLevel
    BufferId* counts = nullptr;  // set to one of gpu::WideCounts a ray
};
[[nodiscard]] RAYGRAPH_API BufferId TraverseBuffer(Renderer& renderer, const WideDeviceScene::Ids& scene,
                                                   BufferId rays, uint32_t count,
                                                   const TraverseSettings& settings);

}  // namespace raygraph::passes

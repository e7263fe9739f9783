// Reference measurements of tracing: Limit, its cost on this device without a path tracer around it, and
// LambertPath, one plain path traced in two forms. Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "passes/trace.h"
#include "shaders/shared/lambert_path.h"

namespace raygraph::passes {

enum class LimitKind : uint8_t {
    CameraRays,    // Trace's camera rays in the same TLAS, one value written
    Path,          // CameraRays with four cosine bounces, no shading
    SoftwarePath,  // Path by the scene's own trees, which it must have: SceneIds::wideNodes
};

// Measured beside Trace in one run, its time turns that of Trace into an efficiency that can be compared
// between machines. Returns r32f, whose values have no meaning. `rayCounts` as in Trace.
[[nodiscard]] RAYGRAPH_API TextureId Limit(Renderer& renderer, const SceneIds& scene,
                                           const TraceSettings& settings, LimitKind kind,
                                           TextureId* rayCounts = nullptr);

// --- LambertPath ---
// One plain path is traced in two forms, to measure what a loop in ray generation saves compared with
// recursion from the closest hit. Both give the same picture, to rounding.

enum class PathForm : uint8_t {
    Loop,       // in ray generation, with the hit and miss shaders of Trace
    Recursive,  // each closest hit traces the next ray: a recursion of kLambertRecursion
};

// Returns whether the device traces from closest hits as deep as PathForm::Recursive needs.
[[nodiscard]] RAYGRAPH_API bool CanRecurse(const rhi::Device& device);

// Returns linear radiance, rgba32f, of paths of kLambertBounces bounces: Lambert surfaces of their base color
// with flat normals, emission found by BSDF sampling, alpha taken as opaque, the environment without its map.
// Only extent, camera, sampler, seed and sampleIndex of `settings` are used. Throws Error{Usage} for
// PathForm::Recursive where the device cannot (CanRecurse).
[[nodiscard]] RAYGRAPH_API TextureId LambertPath(Renderer& renderer, const SceneIds& scene,
                                                 const TraceSettings& settings, PathForm form);

}  // namespace raygraph::passes

// Path tracing on the host: the integrator of the device, its shader text compiled as C++, over a copy of the
// scene. A second opinion on the device's numbers, with checked reads, and code that a debugger steps through
// (docs/explain.md). Threads: any.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "editor/session/cpu/scene_copy.h"
#include "passes/trace.h"
#include "shaders/shared/path_record.h"

namespace raygraph::session {

struct CpuPath {
    glm::vec3 value{0.0f};                        // radiance; 0 if it is not finite, as Trace writes it
    std::vector<gpu::PathVertexRecord> vertices;  // as passes::PathOf returns them
};

// Follows the path of sample settings.sampleIndex of a pixel of the picture. Throws Error{BadInput} if the
// shaders read what is not in the scene.
CpuPath TraceOnCpu(const SceneCopy& scene, const passes::TraceSettings& settings, const glm::uvec2& pixel);

}  // namespace raygraph::session

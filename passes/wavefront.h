// Trace as a wavefront: the paths of all pixels, one ray at a time, by kernels that trace or shade. The same
// integrator as the loop (passes/trace.h), and the same bits. Threads: that of the Renderer.
#pragma once

#include "passes/trace.h"

namespace raygraph::passes {

// Whether the form exists for that.
bool HasWavefront(const SceneIds& scene, const TraceSettings& settings, const TraceOutputs& outputs);
// `counts`: zeros, of TraceCounts.
TraceIds TraceWavefront(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                        BufferId counts);

}  // namespace raygraph::passes

// Trace as a wavefront (IntegratorForm). For passes/ alone. Threads: that of the Renderer.
#pragma once

#include "passes/trace.h"

namespace raygraph::passes {

// Adds the passes that fill `ids`, which are declared and not written yet; returns their last versions.
TraceIds TraceWavefront(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                        const TraceOutputs& outputs, const TraceIds& ids);

}  // namespace raygraph::passes

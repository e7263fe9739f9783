// CompileAhead: has the driver compile a pipeline before a frame uses it.
//
// Mesa's CPU driver creates machine code when a pipeline is executed for the first time, in the device's
// queue: no later frame is drawn until that is done, which takes seconds for a path tracer. But it keeps
// machine code in a cache on disk. Hence a second device executes the pipeline first, without any invocation,
// while the caller waits; the first frame of the first device then finds the code in the cache.
//
// Machine code of a ray-tracing pipeline contains the numbers of its shader groups, which the driver counts
// on each device: the second device first creates as many groups as the first had before that pipeline.
#pragma once

#include "base/api.h"
#include "rhi/pipeline.h"

namespace raygraph::rhi {

// Compiles the pipeline `made`, which was created on `device` from `desc`. Returns when the driver has the
// pipeline's machine code, which is at once for drivers that compile in vkCreate*. Never fails: without a
// second device, or without Mesa's cache, the first frame compiles. Threads: any.
RAYGRAPH_API void CompileAhead(const Device& device, const RayTracingPipelineDesc& desc,
                               const RayTracingPipeline& made);
RAYGRAPH_API void CompileAhead(const Device& device, const ComputePipelineDesc& desc,
                               const ComputePipeline& made);

}  // namespace raygraph::rhi

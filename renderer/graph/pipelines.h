// What a program that must not wait for pipelines asks of a Renderer beside Renderer::PreparePipelines.
// Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph {

// As Renderer::PreparePipelines, of the declared passes from `first` on, up to `end` without it, whether the
// open frame will execute them or not: for one that declares both what it would like to show and what it can,
// and uses one of them. Compiles nothing.
RAYGRAPH_API bool PreparePipelines(Renderer& renderer, PassId first, PassId end);

// A pipeline is kept for so many seconds after the last frame that declared a pass for it. One that is needed
// again later is made again.
inline constexpr double kPipelineLifetime = 300.0;
// Between frames: lets go of those that no frame has needed in the last so many seconds of frames. Execute
// does it with kPipelineLifetime. A pipeline that is being made stays.
RAYGRAPH_API void ForgetPipelines(Renderer& renderer, double lifetime);

}  // namespace raygraph

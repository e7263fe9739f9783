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

// Between frames: lets go of the pipelines for which the frames of the last so many seconds have declared no
// pass, culled or not. One that is needed again later is made again; one that is being made stays. Without
// this call all are kept.
RAYGRAPH_API void ForgetPipelines(Renderer& renderer, double lifetime);

}  // namespace raygraph

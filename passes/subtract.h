// Subtract: the difference of two pictures. Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// Computes whole - part in each of the four channels. All three are rgba32f and of one extent; throws
// Error{Usage} for others.
[[nodiscard]] RAYGRAPH_API TextureId Subtract(Renderer& renderer, TextureId whole, TextureId part);

}  // namespace raygraph::passes

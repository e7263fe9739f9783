// Subtract: what one picture has more than another.
#pragma once

#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// whole - part in each of the four channels. All three are rgba32f and of one extent; Error{Usage} for
// others.
[[nodiscard]] TextureId Subtract(Renderer& renderer, TextureId whole, TextureId part);

}  // namespace raygraph::passes

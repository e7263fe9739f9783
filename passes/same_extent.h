// Checks of passes over two pictures. Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// The extent of both. Error{Usage} naming the pass unless both have that format and one extent.
RAYGRAPH_API Extent2D RequireComparable(const Renderer& renderer, const char* pass, TextureId a, TextureId b,
                                        Format format);

}  // namespace raygraph::passes

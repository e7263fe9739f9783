// Overlay: the finished part of a picture, over a coarser one of the same view. Threads: that of
// the Renderer.
#pragma once

#include "base/api.h"
#include "passes/tiles.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// The pixels that `done` has of `fine`, the others from `coarse`, of any extent, scaled bilinearly. All are
// rgba32f; the picture has the extent of `fine`.
[[nodiscard]] RAYGRAPH_API TextureId Overlay(Renderer& renderer, TextureId coarse, TextureId fine,
                                             const TileCursor& done);

// Scales `coarse`, rgba32f, bilinearly to another extent.
[[nodiscard]] RAYGRAPH_API TextureId Upscale(Renderer& renderer, TextureId coarse, Extent2D extent);

}  // namespace raygraph::passes

// Overlay: what there is of a picture that is being made, over a coarser one of the same view.
#pragma once

#include "passes/tiles.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// The pixels that `done` has of `fine`, the others from `coarse`, of any extent, scaled bilinearly. All are
// rgba32f; the picture has the extent of `fine`.
[[nodiscard]] TextureId Overlay(Renderer& renderer, TextureId coarse, TextureId fine, const TileCursor& done);

// `coarse`, rgba32f, scaled bilinearly to another extent.
[[nodiscard]] TextureId Upscale(Renderer& renderer, TextureId coarse, Extent2D extent);

}  // namespace raygraph::passes

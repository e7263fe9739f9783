// Draws the scene by compute shaders: the nearest surface of a pixel is the maximum of 64-bit keys. For
// passes/ alone.
//
// Why not by the device's rasterizer: coverage is tested as for rays, at the same positions in floating point
// on every device, and not with vertices rounded to 1/256 of a pixel; and on devices with few rasterization
// units (data-center GPUs), all units do the work. Threads: that of the Renderer.
#pragma once

#include "passes/raster_bindings.h"

namespace raygraph::passes {

// Returns whether the device has the required features, the scene's triangles can be numbered, and a buffer
// can hold a key for each pixel.
bool CanRasterize(const Renderer& renderer, const SceneIds& scene, Extent2D extent);

// Clears seen.hits and seen.depth and draws them from its lists, as DrawHits. Call CanRasterize first.
void RasterizeHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                   RasterVisibility& seen, GlassDrawn glass);

}  // namespace raygraph::passes

// Draws the scene by compute shaders: visibility by the greatest of 64-bit keys. For passes/ alone.
//
// Why not by the device's rasterizer: pixels are found as rays find them, by the same places in floating
// point on every device, and not by corners rounded to 1/256 of a pixel; and on devices that have few units
// that can rasterize (data-center GPUs), all units do it. Threads: that of the Renderer.
#pragma once

#include "passes/raster_bindings.h"

namespace raygraph::passes {

// Whether the device has what this takes, the scene's triangles can be numbered, and a buffer can hold a key
// for each pixel.
bool CanRasterize(const Renderer& renderer, const SceneIds& scene, Extent2D extent);

// Draws seen.hits and seen.depth anew from its lists; as DrawHits. CanRasterize comes first.
void RasterizeHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                   RasterVisibility& seen, GlassDrawn glass);

}  // namespace raygraph::passes

// The common declarations of raster passes. For passes/ alone. Threads: that of the Renderer.
#pragma once

#include "passes/draw_list.h"
#include "passes/raster.h"

namespace raygraph::passes {

// Holds the constants of a pass over the pixels, see shaders/raster/pixel.glsl.
struct PixelOptions {
    uint32_t option = 0;
    uint32_t shadowTiles = 0;
};

// Binds the surfaces for a pass over the pixels; the parameters are bound separately.
void BindPixelSurfaces(PassBuilder& pass, const SceneIds& scene, const RasterVisibility& seen,
                       const PixelOptions& options);

// Binds what shaders/raster/visibility.vert and its fragment shaders read, without the constants.
void BindDrawing(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters,
                 const DrawList& list, bool isTested, SamplerKind sampler);
// Binds what shaders/raster/fragment_alpha.glsl reads beside "instances" and the "parameters" of BindDrawing.
void BindAlphaTest(PassBuilder& pass, const SceneIds& scene, SamplerKind sampler);

// Returns a depth buffer that this rasterizer draws.
TextureId DepthTexture(Renderer& renderer, const char* name, Extent2D extent, Rasterizer rasterizer);

enum class GlassDrawn : uint8_t { Yes, No };
// Clears seen.hits and seen.depth and draws them from its lists, by one command a class of triangles. Rays
// find round primitives; seen.depth is another texture then.
void DrawHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
              RasterVisibility& seen, GlassDrawn glass);

}  // namespace raygraph::passes

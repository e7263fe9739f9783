// What raster passes declare alike. For passes/ alone. Threads: that of the Renderer.
#pragma once

#include "passes/draw_list.h"
#include "passes/raster.h"

namespace raygraph::passes {

// What a pass over the pixels is told, see shaders/raster/pixel.glsl.
struct PixelOptions {
    uint32_t option = 0;
    uint32_t shadowTiles = 0;
};

// What a pass over the pixels looks up of surfaces; the parameters come on their own.
void BindPixelSurfaces(PassBuilder& pass, const SceneIds& scene, const RasterVisibility& seen,
                       const PixelOptions& options);

// What shaders/raster/visibility.vert and the fragments of its triangles take, but for the constants.
void BindDrawing(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters,
                 const DrawList& list, bool isTested, SamplerKind sampler);
// What shaders/raster/fragment_alpha.glsl takes beside "instances" and, of BindDrawing, "parameters".
void BindAlphaTest(PassBuilder& pass, const SceneIds& scene, SamplerKind sampler);

enum class GlassDrawn : uint8_t { Yes, No };
// Draws seen.hits and seen.depth anew from its lists, by one command a class of triangles.
void DrawHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
              RasterVisibility& seen, GlassDrawn glass);

}  // namespace raygraph::passes

// What raster passes declare alike. For passes/ alone.
#pragma once

#include "passes/draw_list.h"
#include "passes/raster.h"

namespace raygraph::passes {

// The twin of shaders/raster/pixel.glsl; `view` is a value of View, for the shader that asks for it.
void BindPixels(PassBuilder& pass, const SceneIds& scene, const TraceSettings& settings,
                const RasterVisibility& seen, uint32_t view = 0);

// What shaders/raster/visibility.vert and the fragments of its triangles take, but for the constants.
void BindDrawing(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters,
                 const DrawList& list, bool isTested, SamplerKind sampler);

}  // namespace raygraph::passes

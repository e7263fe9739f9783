// Occlusion: the visible part of the environment at each surface, in screen space, for raster views. Threads:
// that of the Renderer.
#pragma once

#include "base/api.h"
#include "passes/raster.h"

namespace raygraph::passes {

// Returns, r32f, the share of the directions above each surface, weighted by the cosine, that no surface on
// the screen within 0.4 of the picture's height occludes; 1 without a surface. Hidden surfaces and those
// outside of the picture occlude nothing; visible ones occlude as if they were as deep as they look. A few
// directions for each sample (settings.seed, sampleIndex): the noise falls in a mean over samples. Source and
// formulas: shaders/raster/occlusion.comp. `seen` is from DrawVisibility.
[[nodiscard]] RAYGRAPH_API TextureId Occlusion(Renderer& renderer, const SceneIds& scene,
                                               const TraceSettings& settings, const RasterVisibility& seen);

}  // namespace raygraph::passes

// Occlusion: how much of the sky a surface sees, as far as the screen knows, for raster views. Threads:
// that of the Renderer.
#pragma once

#include "base/api.h"
#include "passes/raster.h"

namespace raygraph::passes {

// Returns, r32f, the share of the directions above each surface, weighed by the cosine, that is free of what
// is on the screen within 0.4 of the picture's height; 1 where nothing is. What is hidden or outside of
// the picture stops nothing; what is seen stops light as if it were as deep as it looks. A few directions for
// each sample (settings.seed, sampleIndex): the noise falls in a mean over samples. Source and formulas:
// shaders/raster/occlusion.comp. `seen` is from DrawVisibility.
[[nodiscard]] RAYGRAPH_API TextureId Occlusion(Renderer& renderer, const SceneIds& scene,
                                               const TraceSettings& settings, const RasterVisibility& seen);

}  // namespace raygraph::passes

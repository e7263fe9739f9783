// The picture behind glass, for raster views: drawn without the glass, and blurred. Threads: that of
// the Renderer.
#pragma once

#include "base/api.h"
#include "passes/raster.h"

namespace raygraph::passes {

// Draws `seen` without its transmissive surfaces, from its lists: the nearest surface behind them in each
// pixel.
[[nodiscard]] RAYGRAPH_API RasterVisibility DrawBehindGlass(Renderer& renderer, const SceneIds& scene,
                                                            const TraceSettings& settings,
                                                            const RasterVisibility& seen);

// Makes blurred copies of an rgba32f picture, rgba32f, color multiplied by alpha: the levels of
// shaders/shared/blur_levels.h, level i for footprints of 2^i pixels.
[[nodiscard]] RAYGRAPH_API TextureId BlurLevels(Renderer& renderer, TextureId picture);

}  // namespace raygraph::passes

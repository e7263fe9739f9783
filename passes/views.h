// Views of the scene other than its light: surface properties and rendering cost.
//
//   RasterVisibility seen = DrawVisibility(renderer, scene, settings, FilmPosition::Center);
//   renderer.Present(PaintView(renderer, SurfaceView(renderer, scene, settings, seen, View::Roughness),
//                              View::Roughness));
//
// Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "passes/raster.h"
#include "shaders/shared/choice.h"

namespace raygraph::passes {

inline constexpr size_t kViewCount = Texts(View{}).size();

RAYGRAPH_API bool ShowsLight(View view);     // radiance, for Tonemap; the others are values, for PaintView
RAYGRAPH_API bool ShowsSurface(View view);   // made by SurfaceView
RAYGRAPH_API bool CountsPaths(View view);    // made by Trace, of the paths that the picture has
RAYGRAPH_API bool IsAverageable(View view);  // over samples: false for ids and distances

// Returns the view's values, rgba32f: one number three times, a color or a vector (shaders/shared/choice.h).
// Alpha is 1 on a surface; all channels are 0 where there is none. A mean over jittered samples keeps that
// meaning: alpha becomes coverage. `seen` is from DrawVisibility or TraceVisibility. One pipeline serves all
// views. Error{Usage} for a view for which ShowsSurface is false.
[[nodiscard]] RAYGRAPH_API TextureId SurfaceView(Renderer& renderer, const SceneIds& scene,
                                                 const TraceSettings& settings, const RasterVisibility& seen,
                                                 View view);

// Returns how many surfaces are drawn in each pixel, including hidden ones and the visible one: rgba32f, the
// count three times and 1. Back faces and transparency as in DrawVisibility. Up to 2048; errors as there.
[[nodiscard]] RAYGRAPH_API TextureId Overdraw(Renderer& renderer, const SceneIds& scene,
                                              const TraceSettings& settings, FilmPosition film);

// Converts TraceIds::rayCounts or bounces, or another texture of one count a pixel, as values that Accumulate
// and PaintView take: rgba32f, the count three times and 1.
[[nodiscard]] RAYGRAPH_API TextureId SpreadCounts(Renderer& renderer, TextureId counts);

// The method that finds the surfaces of a view. Where several coincide, either may be visible.
enum class SurfaceSource : uint8_t {
    Rays,     // as those of the path-traced picture
    Drawing,  // AnyVisibility: fast
};

// The values of a view that shows no light, by the pass that makes them: Trace, Overdraw or SurfaceView.
// Error{Usage} for a view of light.
[[nodiscard]] RAYGRAPH_API TextureId ViewValues(Renderer& renderer, const SceneIds& scene,
                                                const TraceSettings& settings, View view, FilmPosition film,
                                                SurfaceSource surfaces);

// Maps values to display colors: rgba8, opaque, sRGB.
//   Albedo, Emissive       sRGB-encoded, cut at 1
//   Normals                [-1, 1] as [0, 1]
//   Roughness, Metallic    as gray, not encoded
//   Depth                  white at the nearest surface down to dark gray at the farthest, in equal steps
//   Instance, Material     a color for each, the same in every picture
//   Wireframe              edges over gray
//   Overdraw, RayCost, PathLength
//                          a heat map: HeatColor (shaders/core/ramp.glsl) of log2(1 + count) / 5 for
//                          overdraw and bounces, 31 at the top, and / 10 for rays, 1023 at the top
// Black where there is no surface. Error{Usage} for a view of light.
[[nodiscard]] RAYGRAPH_API TextureId PaintView(Renderer& renderer, TextureId values, View view);

}  // namespace raygraph::passes

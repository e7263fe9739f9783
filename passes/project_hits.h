// Where surfaces that were seen in another frame are on the picture, for motion vectors.
//
//   const auto hits = [&] { return renderer.Persist("hits", {extent, Format::Rgba32Uint}); };
//   renderer.Present(TraceHits(renderer, scene, settings, hits()));
//   ...in another frame, after the scene and the camera have moved...
//   TextureId places = ProjectHits(renderer, scene, movedSettings, hits(), settings.camera);
//
// Threads: that of the Renderer.
#pragma once

#include <glm/glm.hpp>

#include "base/api.h"
#include "passes/trace.h"

namespace raygraph::passes {

// Writes the hits of the rays through one point of each pixel, its center say, into `hits`, rgba32ui of the
// size of settings.region: triangles or capsules and places on them (shaders/raster/visibility.glsl), which
// hold for the same scene in any pose. The camera has no lens here. BLEND surfaces are met with their chance.
// Returns the new version.
[[nodiscard]] RAYGRAPH_API TextureId TraceHits(Renderer& renderer, const SceneIds& scene,
                                               const TraceSettings& settings, TextureId hits,
                                               glm::vec2 filmOffset = glm::vec2(0.5f));

// Projects these hits as they are now to the camera of `settings`. rgba32f: x and y in pixels from the
// picture's upper left corner, then 1 for what is behind the camera, which has no place, else 0. Where a
// pixel saw nothing, the place of its direction, through the pixel's center, from `seenBy`, the camera that
// saw it; before an orthographic camera, its own.
[[nodiscard]] RAYGRAPH_API TextureId ProjectHits(Renderer& renderer, const SceneIds& scene,
                                                 const TraceSettings& settings, TextureId hits,
                                                 const gpu::CameraRecord& seenBy);

}  // namespace raygraph::passes

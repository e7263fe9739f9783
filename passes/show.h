// Passes for windows: Show draws a picture into a texture of another format or size, such as an image of a
// host or of a swapchain; Preview is a picture for the time before the first sample. Threads: that of the
// Renderer.
#pragma once

#include <functional>

#include "base/api.h"
#include "passes/trace.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// Draws `picture`, rgba8 and display-encoded, over all of `target`, a color target, and returns its new
// version. A picture of another extent is scaled, bilinearly. Into an sRGB format it is decoded first, so
// that it looks the same. `onSubmitted` as in TonemapInto.
[[nodiscard]] RAYGRAPH_API TextureId Show(Renderer& renderer, TextureId picture, TextureId target,
                                          std::function<void()> onSubmitted = {});

// Returns a picture of the scene's surfaces that needs a small program only, for a viewport that has nothing
// better yet: the base colors of what the camera sees, lit from the camera, times `gain`; dark gray where it
// sees no surface. rgba32f of the settings' region. It has no light, no shadow and no refraction; its
// programs depend only on whether the scene has alpha tests and round primitives, and on the sampler.
[[nodiscard]] RAYGRAPH_API TextureId Preview(Renderer& renderer, const SceneIds& scene,
                                             const TraceSettings& settings, float gain = 1.0f);

}  // namespace raygraph::passes

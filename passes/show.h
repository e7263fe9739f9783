// Show: a picture drawn into a texture of another format or size, such as an image of a host or of a
// swapchain. Threads: that of the Renderer.
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

// Preview: a picture of the scene's surfaces that needs a small program only. Threads: that of the Renderer.

// The base colors of what the camera sees, lit from the camera, times `gain`; dark gray where it sees no
// surface. rgba32f of the settings' region. No light, no shadow and no refraction is in it; its programs
// depend on whether the scene has alpha tests and round primitives, and on the sampler, on nothing else. For
// a viewport that has nothing better yet.
[[nodiscard]] RAYGRAPH_API TextureId Preview(Renderer& renderer, const SceneIds& scene,
                                             const TraceSettings& settings, float gain = 1.0f);

}  // namespace raygraph::passes

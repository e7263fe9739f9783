// Show draws a picture into a texture of another format or size, such as an image of a host or of a
// swapchain. Threads: that of the Renderer.
#pragma once

#include <functional>

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// Draws `picture`, rgba8 and display-encoded, over all of `target`, a color target, and returns its new
// version. A picture of another extent is scaled, bilinearly. Into an sRGB format it is decoded first, so
// that it looks the same. `onSubmitted` as in TonemapInto.
[[nodiscard]] RAYGRAPH_API TextureId Show(Renderer& renderer, TextureId picture, TextureId target,
                                          std::function<void()> onSubmitted = {});

}  // namespace raygraph::passes

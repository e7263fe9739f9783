// Show: a picture drawn into a texture of another format, such as an image of a host or of a swapchain.
#pragma once

#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// Draws `picture`, rgba8 and display-encoded, over all of `target`, a colour target of the same extent, and
// returns what that is then. Into an sRGB format it is decoded first, so that it looks the same. Error{Usage}
// for pictures of another extent.
[[nodiscard]] TextureId Show(Renderer& renderer, TextureId picture, TextureId target);

}  // namespace raygraph::passes

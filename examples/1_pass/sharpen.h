// Threads: that of the Renderer.
#pragma once

#include "renderer/graph/renderer.h"

// Sharpens rgba32f: moves each luminance away from the mean of its four neighbors by `amount` of the
// difference; colors and alpha stay.
[[nodiscard]] raygraph::TextureId Sharpen(raygraph::Renderer& renderer, raygraph::TextureId picture,
                                          float amount);

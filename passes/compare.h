// Combines two pictures of one scene into one, for comparison in a viewport. Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// Both take rgba8 of one extent, display values as Tonemap gives them, and return the same. Error{Usage} for
// other formats, and for pictures of two extents.

// Shows `left` in the columns before position * width, `right` in those from there on, a line between them.
// `position` is clamped to [0, 1]; at either end only one picture is shown, without a line.
[[nodiscard]] RAYGRAPH_API TextureId Wipe(Renderer& renderer, TextureId left, TextureId right,
                                          float position);

// Shows all of both pictures at half the size, as means of 2 x 2 pixels, each in the middle of its half.
[[nodiscard]] RAYGRAPH_API TextureId SideBySide(Renderer& renderer, TextureId left, TextureId right);

}  // namespace raygraph::passes

// Converts the radiance by group of lights: one texture of tiles on the device, pictures in a file. See
// passes/trace.h.
#pragma once

#include <vector>

#include "editor/session/file/render_file.h"
#include "passes/trace.h"

namespace raygraph::session {

// Return a picture, or the sums of one, for each group of the tiles.
std::vector<Texels> FromTiles(const Texels& tiles, Extent2D size, uint32_t groupCount);
std::vector<passes::ExactSums> FromTiles(const passes::ExactSums& tiles, Extent2D size, uint32_t groupCount);

// Converts pictures to tiles; unused tiles are black. Squares have no tiles.
passes::ExactSums ToTiles(const std::vector<passes::ExactSums>& pictures, Extent2D size);

}  // namespace raygraph::session

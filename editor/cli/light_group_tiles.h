// The radiance by group of lights: one texture of tiles on the device, pictures in a file. See
// passes/trace.h.
#pragma once

#include <vector>

#include "editor/cli/render_file.h"
#include "passes/trace.h"

namespace raygraph::cli {

// One picture for each group, out of the tiles' texels.
std::vector<Texels> FromTiles(const Texels& tiles, ImageSize size, uint32_t groupCount);

// The other way; tiles that are left over are black.
Texels ToTiles(const std::vector<Texels>& pictures, ImageSize size);

}  // namespace raygraph::cli

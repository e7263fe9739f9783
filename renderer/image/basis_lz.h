// ETC1S with BasisLZ, the small encoding of KHR_texture_basisu: blocks that share a palette of colors and one
// of patterns. Private to renderer/image. Threads: any.
#pragma once

#include "renderer/image/ktx2_header.h"

namespace raygraph::image {

// Returns the RGB of the first slice, and the alpha of the second one or 255, exact to the bit. Frames that
// refer to others are refused: a texture has none.
Image8 DecodeBasisLz(const Ktx2Header& header, std::string_view name);

}  // namespace raygraph::image

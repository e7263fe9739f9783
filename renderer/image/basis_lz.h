// ETC1S with BasisLZ, what KHR_texture_basisu stores of small size: blocks that share a palette of colors and
// one of patterns. Private to renderer/image. Threads: any.
#pragma once

#include "renderer/image/ktx2_header.h"

namespace raygraph::image {

// RGB of the first slice, and alpha of the second one or 255, exact, bit for bit. Frames that refer to others
// are refused: a texture has none.
Image8 DecodeBasisLz(const Ktx2Header& header, std::string_view name);

}  // namespace raygraph::image

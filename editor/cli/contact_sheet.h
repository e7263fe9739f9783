// Puts pictures side by side, for `render --contact-sheet`.
#pragma once

#include <span>

#include "renderer/image/image.h"

namespace raygraph::cli {

// Returns the pictures, at least one and all of one size, row by row, in as many columns as rows or one more.
// Places that are left over are transparent.
image::Image8 ContactSheet(std::span<const image::Image8> pictures);

}  // namespace raygraph::cli

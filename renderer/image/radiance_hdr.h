// Reads the header of a Radiance HDR. Threads: any.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "base/api.h"

namespace raygraph::image {

// Returns by what the values of the file have been multiplied (the product of EXPOSURE=); 1 if it does not
// say. Throws Error{BadInput} as decoding does.
RAYGRAPH_API float HdrExposure(std::span<const std::byte> bytes, std::string_view name);

}  // namespace raygraph::image

// Inside renderer/image: a look at an OpenEXR header before the library sees it.
#pragma once

#include <span>
#include <string_view>

#include "renderer/image/image.h"

namespace raygraph::image {

// OpenEXR allocates what a header asks for: attributes, tables of chunks, buffers for lines and tiles. This
// refuses (Error{BadInput}) every file whose header asks for more than the file can hold or the limits allow,
// and what we do not read: multi-part, deep and subsampled pictures. A file that passes may still be corrupt
// further on.
void CheckExrHeader(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);

}  // namespace raygraph::image

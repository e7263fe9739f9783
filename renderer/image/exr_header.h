// Private to renderer/image: checks an OpenEXR header before the library reads it.
#pragma once

#include <span>
#include <string_view>

#include "renderer/image/image.h"

namespace raygraph::image {

// OpenEXR allocates by the sizes in a header: attributes, tables of chunks, buffers for lines and tiles. This
// refuses (Error{BadInput}) every file whose header requests more than the file can hold or the limits allow,
// and unsupported pictures: multi-part, deep and subsampled ones. A file that passes may still be corrupt
// further on.
void CheckExrHeader(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);

}  // namespace raygraph::image

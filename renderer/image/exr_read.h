// Parts of the OpenEXR reader: the check of a header before the library reads it, and the attributes of the
// format. Private to renderer/image. Threads: any.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "renderer/image/image.h"

namespace raygraph::image {

// OpenEXR allocates by the sizes in a header: attributes, tables of chunks, buffers for lines and tiles. This
// refuses (Error{BadInput}) every file whose header requests more than the file can hold or the limits allow,
// and unsupported pictures: multi-part, deep and subsampled ones. A file that passes may still be corrupt
// further on.
void CheckExrHeader(std::span<const std::byte> bytes, std::string_view name, const DecodeLimits& limits);

// Returns whether the format itself defines the attribute: it is never written as an attribute of a render,
// and is not metadata when read.
inline bool IsFormatAttribute(std::string_view name) {
    constexpr std::array<std::string_view, 16> kNames = {
        "channels",           "chunkCount", "compression",       "dataWindow", "displayWindow", "envmap",
        "lineOrder",          "name",       "pixelAspectRatio",  "preview",    "tiles",         "type",
        "screenWindowCenter", "version",    "screenWindowWidth", "view"};
    return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

}  // namespace raygraph::image

// Private to renderer/image: names for reading and writing OpenEXR.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace raygraph::image {

// Attributes that the format itself defines: never written as attributes of a render, and not metadata
// when read.
inline bool IsFormatAttribute(std::string_view name) {
    constexpr std::array<std::string_view, 16> kNames = {
        "channels",           "chunkCount", "compression",       "dataWindow", "displayWindow", "envmap",
        "lineOrder",          "name",       "pixelAspectRatio",  "preview",    "tiles",         "type",
        "screenWindowCenter", "version",    "screenWindowWidth", "view"};
    return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

}  // namespace raygraph::image

// Inside renderer/image: names that reading and writing OpenEXR share.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace raygraph::image {

// Attributes that the format itself defines: not ours to write, no metadata when read.
inline bool IsFormatAttribute(std::string_view name) {
    constexpr std::array<std::string_view, 16> kNames = {
        "channels",           "chunkCount", "compression",       "dataWindow", "displayWindow", "envmap",
        "lineOrder",          "name",       "pixelAspectRatio",  "preview",    "tiles",         "type",
        "screenWindowCenter", "version",    "screenWindowWidth", "view"};
    return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

}  // namespace raygraph::image

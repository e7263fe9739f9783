// The glTF extensions that are known here: the one list of those that are read, and of others with the
// reason. One that is not listed is unknown, which is treated as one that is not read. Threads: constants.
#pragma once

#include <span>
#include <string_view>

#include "base/api.h"

namespace raygraph::scene {

struct GltfExtension {
    std::string_view name;
    bool isRead = false;
    std::string_view note;  // how it is applied, or why it is not read
};

// Returns all known extensions, sorted by name.
RAYGRAPH_API std::span<const GltfExtension> KnownExtensions();

}  // namespace raygraph::scene

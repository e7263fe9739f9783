// The version of the library: semantic, docs/embed.md says what it promises. Threads: any.
#pragma once

#include <compare>

#include "base/api.h"

// These numbers are the version of these headers; the build reads them from here.
#define RAYGRAPH_VERSION_MAJOR 0
#define RAYGRAPH_VERSION_MINOR 2
#define RAYGRAPH_VERSION_PATCH 0

namespace raygraph {

struct Version {
    int major = 0;
    int minor = 0;
    int patch = 0;

    auto operator<=>(const Version&) const = default;
};

inline constexpr Version kHeaderVersion{RAYGRAPH_VERSION_MAJOR, RAYGRAPH_VERSION_MINOR,
                                        RAYGRAPH_VERSION_PATCH};

// Returns the version of the library that the program runs with. It may be later than that of the headers
// with which the program was compiled.
RAYGRAPH_API Version LibraryVersion();

}  // namespace raygraph

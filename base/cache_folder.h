// The folder in which programs of this user keep data that can be made again. Threads: any.
#pragma once

#include <filesystem>

#include "base/api.h"

namespace raygraph {

// $XDG_CACHE_HOME/raygraph, else ~/.cache/raygraph; empty if there is neither. It may not exist yet.
RAYGRAPH_API std::filesystem::path CacheFolder();

}  // namespace raygraph

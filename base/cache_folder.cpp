#include "base/cache_folder.h"

#include <cstdlib>

namespace raygraph {

std::filesystem::path CacheFolder() {
    // The XDG specification: a relative path in the variable counts as unset.
    const char* cache = std::getenv("XDG_CACHE_HOME");
    if (cache && std::filesystem::path(cache).is_absolute()) return std::filesystem::path(cache) / "raygraph";
    const char* home = std::getenv("HOME");
    if (home && *home) return std::filesystem::path(home) / ".cache" / "raygraph";
    return {};
}

}  // namespace raygraph

// A whole file in memory. Threads: any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/api.h"

namespace raygraph {

// Reads a regular file (links are followed; folders, devices and pipes are refused) of at most
// `maxBytes` bytes. Error{Io} naming the path and the system's reason; Error{BadInput} for a longer
// file; Error{OutOfMemory}.
RAYGRAPH_API std::vector<std::byte> ReadFile(const std::filesystem::path& path,
                                             uint64_t maxBytes = uint64_t{1} << 32);

}  // namespace raygraph

// Memory pages of the operating system. Threads: any.
#pragma once

#include <cstddef>

#include "base/api.h"

namespace raygraph::os {

inline constexpr size_t kLargePageBytes = size_t{2} << 20;

// Returns new memory, filled with zeros, in large pages if the system has them and aligned to one. Null if
// there is none left.
RAYGRAPH_API void* AllocateLargePages(size_t bytes) noexcept;
// Frees what AllocateLargePages returned for the same number of bytes.
RAYGRAPH_API void FreeLargePages(void* memory, size_t bytes) noexcept;

}  // namespace raygraph::os

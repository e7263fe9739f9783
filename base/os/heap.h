// The process's memory allocator. Threads: before others are started.
#pragma once

#include "base/api.h"

namespace raygraph::os {

// Large blocks get pages of their own, which go back to the system with each, where the allocator can. Else,
// a program that has loaded a scene may at any time give back hundreds of megabytes at once, for which a
// thread that allocates waits. For programs, not for libraries.
RAYGRAPH_API void KeepLargeBlocksApart() noexcept;

}  // namespace raygraph::os

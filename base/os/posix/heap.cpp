#include "base/os/heap.h"

#if defined(__GLIBC__) || __has_include(<malloc.h>)
#include <malloc.h>
#endif

namespace raygraph::os {

void KeepLargeBlocksApart() noexcept {
#ifdef M_MMAP_THRESHOLD
    // What is set does not grow with the blocks that are freed
    mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

}  // namespace raygraph::os

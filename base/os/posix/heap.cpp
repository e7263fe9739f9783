#include "base/os/heap.h"

#if defined(__GLIBC__) || __has_include(<malloc.h>)
#include <malloc.h>
#endif

namespace raygraph::os {

void KeepLargeBlocksApart() noexcept {
#ifdef M_MMAP_THRESHOLD
    // A threshold that is set explicitly no longer grows with the blocks that are freed.
    mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

}  // namespace raygraph::os

#include "base/os/memory.h"

#include <sys/mman.h>

#include <cstdint>

namespace raygraph::os {
namespace {

constexpr size_t kSmallPageBytes = size_t{64} << 10;  // or less

size_t InPages(size_t bytes) {
    return (bytes + kSmallPageBytes - 1) / kSmallPageBytes * kSmallPageBytes;
}

}  // namespace

void* AllocateLargePages(size_t bytes) noexcept {
    const size_t used = InPages(bytes), all = used + kLargePageBytes;
    if (used < bytes || all < used) return nullptr;
    void* const memory = mmap(nullptr, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return nullptr;
    auto* const first = static_cast<char*>(memory);
    const size_t before =
        (kLargePageBytes - reinterpret_cast<uintptr_t>(first) % kLargePageBytes) % kLargePageBytes;
    if (before > 0) munmap(first, before);
    munmap(first + before + used, all - before - used);
#ifdef MADV_HUGEPAGE
    madvise(first + before, used, MADV_HUGEPAGE);
#endif
    return first + before;
}

void FreeLargePages(void* memory, size_t bytes) noexcept {
    munmap(memory, InPages(bytes));
}

}  // namespace raygraph::os

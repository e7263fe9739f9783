// LargeArray has memory for large arrays that are read at random. With small pages, the processor would have
// to look up the address of nearly every access. Threads: any.
#pragma once

#include <cstddef>
#include <limits>
#include <new>
#include <vector>

#include "base/api.h"

namespace raygraph::os {

inline constexpr size_t kLargePageBytes = size_t{2} << 20;

// Returns new memory, filled with zeros, in large pages if the system has them and aligned to one. Null if
// there is none left.
RAYGRAPH_API void* AllocateLargePages(size_t bytes) noexcept;
// Frees what AllocateLargePages returned for the same number of bytes.
RAYGRAPH_API void FreeLargePages(void* memory, size_t bytes) noexcept;

}  // namespace raygraph::os

namespace raygraph {

// Allocates as the allocators of the standard library do.
template <typename T>
class LargePages {
  public:
    using value_type = T;
    LargePages() = default;
    template <typename U>
    LargePages(const LargePages<U>&) noexcept {}

    T* allocate(size_t count) {
        if (count > std::numeric_limits<size_t>::max() / sizeof(T)) throw std::bad_array_new_length();
        if (!IsLarge(count))
            return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{alignof(T)}));
        if (void* const memory = os::AllocateLargePages(count * sizeof(T))) return static_cast<T*>(memory);
        throw std::bad_alloc();
    }
    void deallocate(T* memory, size_t count) noexcept {
        if (IsLarge(count))
            os::FreeLargePages(memory, count * sizeof(T));
        else
            ::operator delete (memory, std::align_val_t{alignof(T)});
    }
    bool operator==(const LargePages&) const = default;

  private:
    static_assert(alignof(T) <= os::kLargePageBytes);
    static bool IsLarge(size_t count) { return count * sizeof(T) >= os::kLargePageBytes; }
};

template <typename T>
using LargeArray = std::vector<T, LargePages<T>>;

}  // namespace raygraph

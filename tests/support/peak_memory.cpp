#include "tests/support/peak_memory.h"

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<size_t> inUse{0}, peak{0};

void Count(void* memory) {
    const size_t now = inUse += malloc_usable_size(memory);
    for (size_t before = peak; now > before && !peak.compare_exchange_weak(before, now);) {
    }
}

}  // namespace

namespace raygraph::testing {

PeakMemory::PeakMemory() : m_before(inUse) {
    peak = m_before;
}

size_t PeakMemory::Bytes() const {
    return peak - m_before;
}

}  // namespace raygraph::testing

// The other forms of the standard library call these. A sanitizer has its own of those that do not throw.
void* operator new(size_t bytes) {
    void* const memory = std::malloc(bytes == 0 ? 1 : bytes);
    if (!memory) throw std::bad_alloc();
    Count(memory);
    return memory;
}

void* operator new(size_t bytes, const std::nothrow_t&) noexcept try {
    return operator new(bytes);
} catch (const std::bad_alloc&) {
    return nullptr;
}

void operator delete(void* memory) noexcept {
    inUse -= malloc_usable_size(memory);
    std::free(memory);
}

void operator delete(void* memory, size_t) noexcept {
    operator delete(memory);
}

void operator delete(void* memory, const std::nothrow_t&) noexcept {
    operator delete(memory);
}

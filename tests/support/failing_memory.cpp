#include "tests/support/failing_memory.h"

#include <cstdlib>
#include <new>

namespace {

thread_local size_t largestAllocation = ~size_t{0};
thread_local size_t successesLeft = 0;
thread_local size_t allocationCount = 0;

bool Succeeds(size_t bytes) {
    ++allocationCount;
    if (bytes <= largestAllocation) return true;
    if (successesLeft == 0) return false;
    --successesLeft;
    return true;
}

}  // namespace

namespace raygraph::testing {

FailingMemory::FailingMemory(size_t bytes, size_t successes) {
    largestAllocation = bytes;
    successesLeft = successes;
}

FailingMemory::~FailingMemory() {
    largestAllocation = ~size_t{0};
}

size_t AllocationCount() {
    return allocationCount;
}

}  // namespace raygraph::testing

// The other forms of the standard library call these. A sanitizer has its own of those that do not throw.
void* operator new(size_t bytes) {
    if (Succeeds(bytes))
        if (void* memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
    throw std::bad_alloc();
}

void* operator new(size_t bytes, const std::nothrow_t&) noexcept try {
    return operator new(bytes);
} catch (const std::bad_alloc&) {
    return nullptr;
}

void* operator new(size_t bytes, std::align_val_t alignment) {
    const size_t unit = static_cast<size_t>(alignment);
    if (Succeeds(bytes))
        if (void* memory = std::aligned_alloc(unit, (bytes + unit - 1) / unit * unit)) return memory;
    throw std::bad_alloc();
}

void operator delete(void* memory, std::align_val_t) noexcept {
    std::free(memory);
}

void operator delete(void* memory, size_t, std::align_val_t) noexcept {
    std::free(memory);
}

void operator delete(void* memory) noexcept {
    std::free(memory);
}

void operator delete(void* memory, size_t) noexcept {
    std::free(memory);
}

void operator delete(void* memory, const std::nothrow_t&) noexcept {
    operator delete(memory);
}

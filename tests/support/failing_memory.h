// Memory that is spent, and allocations that are counted: by operator new of the program that links this.
#pragma once

#include <cstddef>

namespace raygraph::testing {

// While it lives, this thread's allocations of more than `bytes` throw std::bad_alloc, but for the first
// `successes` of them. One at a time.
class FailingMemory {
  public:
    explicit FailingMemory(size_t bytes, size_t successes = 0);
    ~FailingMemory();
    FailingMemory(const FailingMemory&) = delete;
    FailingMemory& operator=(const FailingMemory&) = delete;
};

// Returns how often this thread has called operator new so far.
size_t AllocationCount();

}  // namespace raygraph::testing

// Memory that is spent: operator new of the program that links this fails on demand.
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

}  // namespace raygraph::testing

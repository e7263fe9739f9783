// How much memory a piece of code takes: operator new of the program that links this counts.
#pragma once

#include <cstddef>

namespace raygraph::testing {

// Of all threads. One at a time.
class PeakMemory {
  public:
    PeakMemory();
    // The most bytes from operator new that were in use at once since it was made, beyond those in use then.
    size_t Bytes() const;

  private:
    size_t m_before;
};

}  // namespace raygraph::testing

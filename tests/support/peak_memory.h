// Measures the peak memory of a piece of code by an operator new that counts in the program that links this.
#pragma once

#include <cstddef>

namespace raygraph::testing {

// Measures all threads. Only one may exist at a time.
class PeakMemory {
  public:
    PeakMemory();
    // The most bytes from operator new that were in use at once since it was made, beyond those in use then.
    size_t Bytes() const;

  private:
    size_t m_before;
};

}  // namespace raygraph::testing

// Stopwatch measures wall time since it was made. Threads: any.
#pragma once

#include <chrono>

#include "base/api.h"

namespace raygraph {

class RAYGRAPH_API Stopwatch {
  public:
    double Seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    }
    double Milliseconds() const { return 1e3 * Seconds(); }

  private:
    std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

}  // namespace raygraph

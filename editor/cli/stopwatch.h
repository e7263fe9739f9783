// Wall-clock time since it was made or restarted.
#pragma once

#include <chrono>

namespace raygraph::cli {

class Stopwatch {
  public:
    double Seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    }
    double Milliseconds() const { return 1e3 * Seconds(); }
    void Restart() { m_start = std::chrono::steady_clock::now(); }

  private:
    std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

}  // namespace raygraph::cli

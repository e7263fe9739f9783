// PassTimes collects GPU times of passes over many frames, as medians. Threads: one at a time.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::session {

struct PassTime {
    std::string name;
    double gpuMsMedian = 0.0;
    double gpuMsTotal = 0.0;
    uint32_t count = 0;
};

// Passes of one name are one entry: their times within a frame are added, and `count` counts frames.
class RAYGRAPH_API PassTimes {
  public:
    void Add(const FrameTiming& frame);
    void Add(std::span<const FrameTiming> frames);
    // Returns the passes in the order in which their names were first seen.
    std::vector<PassTime> Summary() const;
    // Returns 0 for a pass that was not seen.
    double MedianMs(std::string_view name) const;
    double TotalMs(std::string_view name) const;

  private:
    std::vector<std::string> m_order;
    std::map<std::string, std::vector<double>, std::less<>> m_times;
};

}  // namespace raygraph::session

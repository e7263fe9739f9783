// The memory rows of the statistics panel. Pure text.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "rhi/device.h"

namespace raygraph::editor {

struct MemoryRow {
    std::string name, value;
};

// Raygraph's memory, the part of it that was placed in host memory, and for each heap what the process uses
// of its budget.
std::vector<MemoryRow> MemoryRows(const rhi::MemoryStatistics& memory,
                                  std::span<const rhi::MemoryHeap> heaps);

}  // namespace raygraph::editor

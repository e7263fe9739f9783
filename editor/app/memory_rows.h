// Formats the memory rows of the statistics panel. Threads: pure functions.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "rhi/device.h"

namespace raygraph::editor {

struct MemoryRow {
    std::string name, value;
};

// Returns rows for Raygraph's memory, for the part of it that was placed in host memory, and for the
// process's use of each heap's budget.
std::vector<MemoryRow> MemoryRows(const rhi::MemoryStatistics& memory,
                                  std::span<const rhi::MemoryHeap> heaps);

}  // namespace raygraph::editor

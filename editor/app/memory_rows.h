// What the statistics panel says about memory. Pure text.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "rhi/device.h"

namespace raygraph::editor {

struct MemoryRow {
    std::string name, value;
};

// "512.0 MB"
std::string BytesText(uint64_t bytes);

// What we take, what of it had to go into the host's memory, and each heap: what the process has of what it
// can have.
std::vector<MemoryRow> MemoryRows(const rhi::MemoryStatistics& memory,
                                  std::span<const rhi::MemoryHeap> heaps);

}  // namespace raygraph::editor

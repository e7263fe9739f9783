#include "editor/app/memory_rows.h"

#include "base/text.h"

namespace raygraph::editor {

std::vector<MemoryRow> MemoryRows(const rhi::MemoryStatistics& memory,
                                  std::span<const rhi::MemoryHeap> heaps) {
    std::vector<MemoryRow> rows{
        {"memory", BytesText(memory.usedBytes) + ", peak " + BytesText(memory.peakBytes)}};
    if (memory.fallbackBytes > 0)
        rows.push_back({"", BytesText(memory.fallbackBytes) + " in the host's memory: the device's is full"});
    for (const rhi::MemoryHeap& heap : heaps)
        rows.push_back({heap.isDeviceLocal ? "device heap" : "host heap",
                        BytesText(heap.usedBytes) + " of " + BytesText(heap.budgetBytes)});
    return rows;
}

}  // namespace raygraph::editor

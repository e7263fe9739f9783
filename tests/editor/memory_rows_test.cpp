#include "editor/app/memory_rows.h"

#include <gtest/gtest.h>

namespace raygraph::editor {
namespace {

std::string Lines(const std::vector<MemoryRow>& rows) {
    std::string text;
    for (const MemoryRow& row : rows) text += row.name + ": " + row.value + "\n";
    return text;
}

TEST(MemoryRows, SayWhatIsTakenOfWhatThereIs) {
    const std::vector<rhi::MemoryHeap> heaps{
        {true, 8192u << 20ull, uint64_t{6144} << 20, uint64_t{512} << 20},
        {false, 0, uint64_t{1024} << 20, uint64_t{3} << 19}};
    EXPECT_EQ(Lines(MemoryRows({.usedBytes = 5 << 20, .peakBytes = 7 << 20}, heaps)),
              "memory: 5.0 MB, peak 7.0 MB\n"
              "device heap: 512.0 MB of 6144.0 MB\n"
              "host heap: 1.5 MB of 1024.0 MB\n");
}

TEST(MemoryRows, SayWhatIsInTheHostsMemoryForWantOfTheDevices) {
    EXPECT_EQ(Lines(MemoryRows({.usedBytes = 5 << 20, .peakBytes = 5 << 20, .fallbackBytes = 2 << 20}, {})),
              "memory: 5.0 MB, peak 5.0 MB\n"
              ": 2.0 MB in the host's memory: the device's is full\n");
}

}  // namespace
}  // namespace raygraph::editor

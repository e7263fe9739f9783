#include "editor/app/statistics_panel.h"

#include <gtest/gtest.h>

namespace raygraph::editor::memory_rows_test {
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
              "memory: 5 MiB, peak 7 MiB\n"
              "device heap: 512 MiB of 6 GiB\n"
              "host heap: 1.5 MiB of 1 GiB\n");
}

TEST(MemoryRows, SayWhatIsInTheHostsMemoryForWantOfTheDevices) {
    EXPECT_EQ(Lines(MemoryRows({.usedBytes = 5 << 20, .peakBytes = 5 << 20, .fallbackBytes = 2 << 20}, {})),
              "memory: 5 MiB, peak 5 MiB\n"
              ": 2 MiB in the host's memory: the device's is full\n");
}

}  // namespace
}  // namespace raygraph::editor::memory_rows_test

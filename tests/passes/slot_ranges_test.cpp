// Slots of a growing table: never taken twice, taken again when they are free, against a list of flags.
#include "renderer/gpu_scene/slot_ranges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/failing_memory.h"

namespace raygraph::testing::slot_ranges_test {
namespace {

// The same by flags, and what has to hold after each call.
struct Model {
    void Allocate(uint32_t count) {
        const uint32_t endBefore = End();
        const bool hasRoom = HasRoom(count);
        const uint32_t first = ranges.Allocate(count);
        taken.resize(std::max<size_t>(taken.size(), first + count));
        for (uint32_t i = first; i < first + count; ++i) {
            ASSERT_FALSE(taken[i]) << "slot " << i << " is taken";
            taken[i] = 1;
        }
        allocated.emplace_back(first, count);
        if (hasRoom)
            ASSERT_LE(first + count, endBefore) << "grew, and there was room for " << count;
        else
            ASSERT_EQ(first, endBefore);
        Check();
    }
    void Free(uint32_t first, uint32_t count) {
        ranges.Free(first, count);
        for (uint32_t i = first; i < first + count; ++i) taken[i] = 0;
        Check();
    }
    uint32_t End() const {
        const auto last = std::find(taken.rbegin(), taken.rend(), 1);
        return static_cast<uint32_t>(taken.rend() - last);
    }
    bool HasRoom(uint32_t count) const {
        uint32_t free = 0;
        for (uint32_t i = 0; i < End(); ++i) {
            free = taken[i] ? 0 : free + 1;
            if (free == count) return true;
        }
        return false;
    }
    void Check() const {
        ASSERT_EQ(ranges.End(), End());
        ASSERT_EQ(ranges.TakenCount(), std::ranges::count(taken, 1));
    }

    SlotRanges ranges;
    std::vector<char> taken;
    std::vector<std::pair<uint32_t, uint32_t>> allocated;
};

}  // namespace

TEST(SlotRanges, AreTakenOnceAndAgainWhenTheyAreFree) {
    for (const uint32_t largest : {1u, 3u, 12u, 100u}) {
        SCOPED_TRACE(largest);
        std::mt19937 engine(largest);
        Model model;
        for (int step = 0; step < 2000 && !::testing::Test::HasFatalFailure(); ++step) {
            const bool grows = step / 200 % 2 == 0;
            if (model.allocated.empty() || engine() % 10 < (grows ? 6 : 3)) {
                model.Allocate(1 + static_cast<uint32_t>(engine()) % largest);
                continue;
            }
            std::swap(model.allocated[engine() % model.allocated.size()], model.allocated.back());
            auto& [first, count] = model.allocated.back();
            const uint32_t part = engine() % 4 ? count : 1;  // of those that were taken together, some
            model.Free(first, part);
            first += part;
            count -= part;
            if (count == 0) model.allocated.pop_back();
        }
        for (const auto& [first, count] : model.allocated) model.Free(first, count);
        EXPECT_EQ(model.ranges.End(), 0u);
    }
}

TEST(SlotRanges, NeighborsThatAreFreeBecomeOneRange) {
    SlotRanges ranges;
    EXPECT_EQ(ranges.Allocate(0), 0u);
    EXPECT_EQ(ranges.Allocate(10), 0u);
    ranges.Free(2, 2);
    ranges.Free(6, 2);
    ranges.Free(4, 2);
    EXPECT_EQ(ranges.End(), 10u);
    EXPECT_EQ(ranges.Allocate(7), 10u);
    EXPECT_EQ(ranges.Allocate(6), 2u);
    ranges.Free(0, 17);
    EXPECT_EQ(ranges.End(), 0u);
    EXPECT_EQ(ranges.Allocate(17), 0u) << "as if new";
}

TEST(SlotRanges, WithoutMemoryNothingIsTaken) {
    SlotRanges ranges;
    ranges.Allocate(100);
    ranges.Free(10, 5);
    {
        const FailingMemory failing(0);
        EXPECT_THROW(ranges.Allocate(1000), std::bad_alloc);
        EXPECT_EQ(ranges.Allocate(5), 10u) << "needs none";
        ranges.Free(40, 2);
    }
    EXPECT_THROW(ranges.Allocate(~0u), std::length_error);
    EXPECT_EQ(ranges.End(), 100u);
    EXPECT_EQ(ranges.TakenCount(), 98u);
    EXPECT_EQ(ranges.Allocate(1000), 100u);
}

}  // namespace raygraph::testing::slot_ranges_test

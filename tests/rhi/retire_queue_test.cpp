// Tests when a retired object may be destroyed: the timeline and the lists that are being recorded decide. It
// needs no device.
#include "rhi/retire_queue.h"

#include <gtest/gtest.h>

namespace raygraph::rhi::retire_queue_test {
namespace {

struct RetireQueueTest : ::testing::Test {
    RetireQueue queue;
    std::vector<int> destroyed;
    RetireQueue::Destroy Mark(int id) {
        return [this, id] { destroyed.push_back(id); };
    }
};

using Ids = std::vector<int>;

TEST_F(RetireQueueTest, IdleDevice_DestroysAtOnce) {
    queue.Retire(Mark(1), 0);
    EXPECT_EQ(destroyed, Ids{1});
    EXPECT_EQ(queue.PendingCount(), 0u);
}

TEST_F(RetireQueueTest, SubmittedWork_IsWaitedFor) {
    queue.CloseList(queue.OpenList(), 3);
    queue.Retire(Mark(1), 2);
    queue.Collect(2);
    EXPECT_EQ(destroyed, Ids{});
    queue.Collect(3);
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, ListBeingRecorded_IsWaitedForUntilItsOwnSubmissionHasCompleted) {
    const uint64_t list = queue.OpenList();
    queue.Retire(Mark(1), 0);
    queue.Collect(100);
    EXPECT_EQ(destroyed, Ids{}) << "the list may still mention the object";
    queue.CloseList(list, 101);
    queue.Collect(100);
    EXPECT_EQ(destroyed, Ids{});
    queue.Collect(101);
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, ListSubmittedFirst_DoesNotStandForOneThatIsStillOpen) {
    const uint64_t early = queue.OpenList();
    const uint64_t late = queue.OpenList();
    queue.Retire(Mark(1), 0);
    queue.CloseList(late, 1);
    queue.Collect(1);
    EXPECT_EQ(destroyed, Ids{}) << "the first list is still being recorded";
    queue.CloseList(early, 2);
    queue.Collect(1);
    EXPECT_EQ(destroyed, Ids{});
    queue.Collect(2);
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, ListOpenedLater_IsNotWaitedFor) {
    const uint64_t first = queue.OpenList();
    queue.Retire(Mark(1), 0);
    const uint64_t second = queue.OpenList();
    queue.CloseList(first, 1);
    queue.Collect(1);
    EXPECT_EQ(destroyed, Ids{1});
    queue.CloseList(second, 2);
}

TEST_F(RetireQueueTest, DroppedList_HoldsNothingBack) {
    const uint64_t list = queue.OpenList();
    queue.Retire(Mark(1), 0);
    queue.CloseList(list, 0);
    queue.Collect(0);
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, OrderOfRetiring_IsKept) {
    queue.CloseList(queue.OpenList(), 1);
    queue.Retire(Mark(1), 0);
    const uint64_t list = queue.OpenList();
    queue.Retire(Mark(2), 0);
    queue.CloseList(list, 2);
    queue.Retire(Mark(3), 0);
    queue.Collect(2);
    EXPECT_EQ(destroyed, (Ids{1, 2, 3}));
}

// The timeline may have passed queued objects before anybody has collected them.
TEST_F(RetireQueueTest, OrderOfRetiring_IsKeptWithoutACollection) {
    queue.CloseList(queue.OpenList(), 1);
    queue.Retire(Mark(1), 0);
    queue.Retire(Mark(2), 1);
    EXPECT_EQ(destroyed, Ids{});
    queue.Collect(1);
    EXPECT_EQ(destroyed, (Ids{1, 2}));
}

TEST_F(RetireQueueTest, DestroyingMayRetireMore) {
    queue.CloseList(queue.OpenList(), 1);
    queue.Retire([this] { queue.Retire(Mark(1), 1); }, 0);
    queue.Collect(1);
    EXPECT_EQ(destroyed, Ids{1});
}

TEST_F(RetireQueueTest, CollectAll_RunsWhatIsLeftEvenForOpenLists) {
    queue.OpenList();
    queue.Retire(Mark(1), 0);
    queue.Retire([this] { queue.Retire(Mark(2), 0); }, 0);
    queue.CollectAll();
    EXPECT_EQ(destroyed, (Ids{1, 2}));
}

}  // namespace
}  // namespace raygraph::rhi::retire_queue_test

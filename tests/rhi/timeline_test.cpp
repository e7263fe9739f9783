// Tests the timeline: submissions, waiting, command lists, deferred destruction.
#include <gmock/gmock.h>

#include <thread>

#include "rhi/command_list.h"
#include "rhi/readback.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::timeline_test {
namespace {

using rhi::BufferUsage;
using rhi::SemaphoreUse;
using ::testing::HasSubstr;

using TimelineTest = VulkanTest;

TEST_F(TimelineTest, SubmissionsCountUp) {
    const uint64_t first = Device().Submit(Device().BeginCommands("a"));
    const uint64_t second = Device().Submit(Device().BeginCommands("b"));
    EXPECT_EQ(second, first + 1);
    EXPECT_EQ(Device().LastSubmittedValue(), second);
    Device().WaitFor(second);
    EXPECT_EQ(Device().CompletedValue(), second);
}

TEST_F(TimelineTest, OutcomeOfAList_IsTold) {
    std::string told;
    const auto note = [&](rhi::CommandList& commands, const std::string& name) {
        commands.OnSubmitted([&told, name] { told += name + " runs, "; });
        commands.OnDropped([&told, name] { told += name + " is undone, "; });
    };
    rhi::CommandList submitted = Device().BeginCommands("submitted");
    note(submitted, "a");
    note(submitted, "b");
    EXPECT_EQ(told, "") << "not before it is known";
    Device().Submit(std::move(submitted));
    EXPECT_EQ(told, "a runs, b runs, ");
    told.clear();
    {
        rhi::CommandList dropped = Device().BeginCommands("dropped");
        note(dropped, "a");
        note(dropped, "b");
        const rhi::CommandList moved = std::move(dropped);
    }
    EXPECT_EQ(told, "b is undone, a is undone, ") << "backwards, and once";
}

TEST_F(TimelineTest, WaitingForTheFuture_IsRefused) {
    const uint64_t next = Device().LastSubmittedValue() + 1;
    EXPECT_EQ(ErrorOf([&] { Device().WaitFor(next); }).Kind(), ErrorKind::Usage);
}

TEST_F(TimelineTest, SubmitWaitsForAndSignalsSemaphores) {
    Gate before(Device()), after(Device());
    const SemaphoreUse wait = before.At(1), signal = after.At(5);
    const uint64_t value = Device().Submit(Device().BeginCommands("gated"), {&wait, 1}, {&signal, 1});
    EXPECT_LT(Device().CompletedValue(), value);
    EXPECT_EQ(after.Value(), 0u);
    before.Open();
    Device().WaitFor(value);
    EXPECT_EQ(after.Value(), 5u);
}

TEST_F(TimelineTest, EmptyOrForeignList_IsRefused) {
    EXPECT_EQ(ErrorOf([] { Device().Submit(rhi::CommandList()); }).Kind(), ErrorKind::Usage);
    const std::unique_ptr<rhi::Device> other = rhi::Device::Create({.savePipelineCache = false});
    EXPECT_EQ(ErrorOf([&] { Device().Submit(other->BeginCommands("other")); }).Kind(), ErrorKind::Usage);
}

TEST_F(TimelineTest, CommandBuffersAreRecycledOnceCompleted) {
    Device().WaitIdle();
    Gate gate(Device());
    const SemaphoreUse wait = gate.At(1);
    rhi::CommandList list = Device().BeginCommands("pending");
    const VkCommandBuffer pending = list.Handle();
    Device().Submit(std::move(list), {&wait, 1});
    EXPECT_NE(Device().BeginCommands("meanwhile").Handle(), pending);
    gate.Open();
    Device().WaitIdle();
    // All buffers are free now: as many lists as there are buffers reuse the one
    std::vector<rhi::CommandList> lists;
    bool isFound = false;
    for (int i = 0; i < 64 && !isFound; ++i) {
        lists.push_back(Device().BeginCommands("again"));
        isFound = lists.back().Handle() == pending;
    }
    EXPECT_TRUE(isFound);
}

TEST_F(TimelineTest, BufferDestroyedWhilePending_IsFreedOnlyWhenItsWorkIsDone) {
    Device().WaitIdle();
    const uint64_t used = Device().Memory().usedBytes;
    Gate gate(Device());
    const SemaphoreUse wait = gate.At(1);
    rhi::Buffer buffer = Device().CreateBuffer(
        {.name = "short-lived", .size = 1 << 16, .usage = BufferUsage::CopyDestination});
    const uint64_t with = Device().Memory().usedBytes;
    ASSERT_GT(with, used);
    rhi::CommandList commands = Device().BeginCommands("uses the buffer");
    commands.Fill(buffer, 1);
    const uint64_t value = Device().Submit(std::move(commands), {&wait, 1});
    buffer = {};
    Device().CollectGarbage();
    EXPECT_EQ(Device().Memory().usedBytes, with) << "the fill has not run yet";
    gate.Open();
    Device().WaitFor(value);
    EXPECT_EQ(Device().Memory().usedBytes, used);
}

TEST_F(TimelineTest, BufferDestroyedWhileItsListIsRecorded_IsFreedAfterThatList) {
    Device().WaitIdle();
    const uint64_t used = Device().Memory().usedBytes;
    uint64_t value = 0;
    {
        rhi::CommandList commands = Device().BeginCommands("uses the buffer");
        {
            const rhi::Buffer buffer =
                Device().CreateBuffer({.size = 1 << 16, .usage = BufferUsage::CopyDestination});
            commands.Fill(buffer, 1);
        }
        // Other work completes in between: it says nothing about the list.
        Device().WaitFor(Device().Submit(Device().BeginCommands("other")));
        EXPECT_GT(Device().Memory().usedBytes, used);
        value = Device().Submit(std::move(commands));
    }
    Device().WaitFor(value);
    EXPECT_EQ(Device().Memory().usedBytes, used);
}

TEST_F(TimelineTest, DroppedList_FreesWhatItMentioned) {
    Device().WaitIdle();
    const uint64_t used = Device().Memory().usedBytes;
    {
        rhi::CommandList commands = Device().BeginCommands("dropped");
        const rhi::Buffer buffer =
            Device().CreateBuffer({.size = 4096, .usage = BufferUsage::CopyDestination});
        commands.Fill(buffer, 1);
    }
    EXPECT_EQ(Device().Memory().usedBytes, used) << "no submission is needed for it";
}

TEST_F(TimelineTest, ThreadsSubmitAndDestroyAtTheSameTime) {
    constexpr int kThreads = 4, kRounds = 25;
    Device().WaitIdle();
    const uint64_t used = Device().Memory().usedBytes;
    const uint64_t first = Device().LastSubmittedValue();
    std::vector<std::thread> threads;
    std::atomic<int> wrong{0};
    for (int t = 0; t < kThreads; ++t)
        threads.emplace_back([t, &wrong] {
            for (int i = 0; i < kRounds; ++i) {
                const rhi::Buffer buffer = Device().CreateBuffer(
                    {.size = 256, .usage = BufferUsage::CopySource | BufferUsage::CopyDestination});
                rhi::CommandList commands = Device().BeginCommands("thread");
                const auto value = static_cast<uint32_t>(t * 1000 + i);
                commands.Fill(buffer, value);
                Device().Submit(std::move(commands));
                if (As<uint32_t>(rhi::ReadBuffer(Device(), buffer)) != std::vector<uint32_t>(64, value))
                    ++wrong;
            }
        });
    for (std::thread& thread : threads) thread.join();
    Device().WaitIdle();
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(Device().LastSubmittedValue(), first + 2 * kThreads * kRounds);
    EXPECT_EQ(Device().Memory().usedBytes, used);
}

}  // namespace
}  // namespace raygraph::testing::timeline_test

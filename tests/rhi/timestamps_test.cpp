// Tests GPU timestamps: in order, in nanoseconds, without waiting.
#include "rhi/timestamps.h"

#include <chrono>

#include "rhi/device.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::timestamps_test {
namespace {

using rhi::BufferUsage;

struct TimestampsTest : VulkanTest {
    // Runs a frame of `count` fills with a timestamp around each.
    uint64_t Frame(uint32_t count) {
        rhi::CommandList commands = Device().BeginCommands("timed");
        pool.BeginFrame(commands);
        EXPECT_EQ(pool.Write(commands), 0u);
        for (uint32_t i = 0; i < count; ++i) {
            commands.FullBarrier();
            commands.Fill(target, i);
            EXPECT_EQ(pool.Write(commands), i + 1);
        }
        const uint64_t value = Device().Submit(std::move(commands));
        pool.EndFrame(value);
        return value;
    }
    rhi::TimestampPool pool{Device(), "times", 16};
    rhi::Buffer target = Device().CreateBuffer({.size = 8 << 20, .usage = BufferUsage::CopyDestination});
};

TEST_F(TimestampsTest, AreMonotoneAndNoLongerThanTheWallTime) {
    const auto start = std::chrono::steady_clock::now();
    const uint64_t value = Frame(8);
    Device().WaitFor(value);
    const double wall =
        std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
    const std::optional<rhi::TimestampFrame> frame = pool.Poll();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->submitted, value);
    ASSERT_EQ(frame->nanoseconds.size(), 9u);
    EXPECT_EQ(frame->nanoseconds[0], 0.0);
    for (size_t i = 1; i < 9; ++i) EXPECT_GE(frame->nanoseconds[i], frame->nanoseconds[i - 1]);
    EXPECT_GT(frame->nanoseconds.back(), 0.0) << "64 MiB are not written in no time";
    EXPECT_LE(frame->nanoseconds.back(), wall);
    EXPECT_FALSE(pool.Poll());
}

TEST_F(TimestampsTest, EveryFrameIsReturnedOnceInOrder) {
    std::vector<uint64_t> submitted, returned;
    for (uint32_t i = 0; i < 10; ++i) {
        submitted.push_back(Frame(i % 3));
        while (const std::optional<rhi::TimestampFrame> frame = pool.Poll()) {
            EXPECT_EQ(frame->nanoseconds.size(), returned.size() % 3 + 1);
            returned.push_back(frame->submitted);
        }
        Device().WaitFor(submitted.back());
    }
    while (const std::optional<rhi::TimestampFrame> frame = pool.Poll()) returned.push_back(frame->submitted);
    EXPECT_EQ(returned, submitted);
    EXPECT_EQ(pool.LostFrameCount(), 0u);
}

TEST_F(TimestampsTest, UnreadFrames_AreLostAndCounted) {
    const uint32_t ranges = Device().FramesInFlight() + 1;
    for (uint32_t i = 0; i < ranges + 2; ++i) Frame(1);
    Device().WaitIdle();
    EXPECT_EQ(pool.LostFrameCount(), 2u);
    uint32_t count = 0;
    while (pool.Poll()) ++count;
    EXPECT_EQ(count, ranges);
}

TEST_F(TimestampsTest, MoreThanThereIsRoomFor_AreLeftOut) {
    rhi::TimestampPool small(Device(), "small", 2);
    rhi::CommandList commands = Device().BeginCommands("timed");
    EXPECT_FALSE(small.Write(commands)) << "outside of a frame";
    small.BeginFrame(commands);
    EXPECT_TRUE(small.Write(commands));
    EXPECT_TRUE(small.Write(commands));
    EXPECT_FALSE(small.Write(commands));
    small.EndFrame(Device().Submit(std::move(commands)));
    Device().WaitIdle();
    EXPECT_EQ(small.Poll()->nanoseconds.size(), 2u);
}

TEST_F(TimestampsTest, FrameThatWasNeverSubmitted_IsGivenUp) {
    {
        rhi::CommandList dropped = Device().BeginCommands("dropped");
        pool.BeginFrame(dropped);
        pool.Write(dropped);
    }
    const uint64_t value = Frame(1);
    Device().WaitFor(value);
    const std::optional<rhi::TimestampFrame> frame = pool.Poll();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->submitted, value);
    EXPECT_EQ(pool.LostFrameCount(), 0u);
}

TEST_F(TimestampsTest, EmptyPool_IsRefused) {
    EXPECT_EQ(ErrorOf([] { rhi::TimestampPool(Device(), "none", 0); }).Kind(), ErrorKind::Usage);
}

}  // namespace
}  // namespace raygraph::testing::timestamps_test

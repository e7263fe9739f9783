// Tests which samples are dealt to which worker.
#include "editor/session/group/block_queue.h"

#include <bit>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "tests/cli/cli_test.h"

namespace raygraph::session::block_dealer_test {

namespace {

// Simulates workers of these speeds until everything is dealt; returns the time at which each ends.
std::vector<double> Simulate(SampleRange samples, const std::vector<double>& speeds, double blockSeconds,
                             std::vector<SampleRange>& blocks) {
    BlockDealer dealer(samples, static_cast<uint32_t>(speeds.size()), blockSeconds);
    std::vector<double> busyUntil(speeds.size(), 0.0);
    std::vector<bool> isMeasured(speeds.size(), false), isOver(speeds.size(), false);
    while (true) {
        size_t next = speeds.size();
        for (size_t i = 0; i < speeds.size(); ++i)
            if (!isOver[i] && (next == speeds.size() || busyUntil[i] < busyUntil[next])) next = i;
        if (next == speeds.size()) return busyUntil;
        const auto block = dealer.Next(static_cast<uint32_t>(next), isMeasured[next] ? speeds[next] : 0.0);
        isMeasured[next] = true;
        if (!block) {
            isOver[next] = true;
            continue;
        }
        blocks.push_back(*block);
        busyUntil[next] += block->count / speeds[next];
    }
}

}  // namespace

TEST(BlockDealer, BlocksAreAlignedAndCoverTheSamplesOnce) {
    for (const SampleRange samples : {SampleRange{0, 1000}, {37, 555}, {0xFFFFFF00u, 256}, {5, 1}}) {
        std::vector<SampleRange> blocks;
        Simulate(samples, {90.0, 10.0, 33.0}, 1.0, blocks);
        uint64_t next = samples.first;
        for (const SampleRange& block : blocks) {
            EXPECT_EQ(block.first, next) << "dealt in order";
            EXPECT_TRUE(std::has_single_bit(block.count));
            EXPECT_EQ(block.first % block.count, 0u);
            next = block.End();
        }
        EXPECT_EQ(next, samples.End());
    }
}

// One worker would need a hundred seconds. One that is ten times as fast gets ten times as much, and none
// waits for long.
TEST(BlockDealer, WorkersOfAnySpeedEndTogether) {
    std::vector<SampleRange> blocks;
    const std::vector<double> ends = Simulate({0, 11100}, {100.0, 10.0, 1.0}, 1.0, blocks);
    for (const double end : ends) EXPECT_NEAR(end, 100.0, 2.0);
    EXPECT_LT(blocks.size(), 1200u) << "of 11100 samples";
}

TEST(BlockDealer, LoneWorkerGetsSampleBySample) {
    BlockDealer dealer({8, 3}, 1, 1e9);
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(dealer.Next(0, 1e6), (SampleRange{8 + i, 1}));
    EXPECT_FALSE(dealer.Next(0, 1e6));
}

TEST(BlockDealer, BlocksHaveTheSamplesThatADeviceRendersAtOnce) {
    for (const uint32_t workers : {1u, 3u}) {
        BlockDealer dealer({0, 100}, workers, 1.0, 8);
        std::vector<uint32_t> counts;
        while (const auto block = dealer.Next(0, counts.empty() ? 0.0 : 10.0)) counts.push_back(block->count);
        EXPECT_EQ(counts, (std::vector<uint32_t>{1, 1, 2, 4, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 4})) << workers;
    }
}

// Otherwise a request to stop would wait for minutes.
TEST(BlockDealer, SlowWorkersGetFewerSamplesThanADeviceRendersAtOnce) {
    for (const uint32_t workers : {1u, 2u}) {
        BlockDealer dealer({0, 1000}, workers, 1.0, 64);
        EXPECT_EQ(dealer.Next(0, 0.5)->count, 1u);
        EXPECT_EQ(dealer.Next(0, 3.0)->count, 1u) << "aligned";
        EXPECT_EQ(dealer.Next(0, 3.0)->count, 2u);
        EXPECT_EQ(dealer.Next(0, 5.0)->count, 4u);
    }
}

TEST(BlockDealer, StoppedOneDealsTheFirstBlockAndNoMore) {
    BlockDealer dealer({0, 100}, 2, 1.0);
    dealer.Stop();
    EXPECT_TRUE(dealer.Next(0, 0.0));
    EXPECT_FALSE(dealer.Next(1, 0.0));
    EXPECT_EQ(dealer.DealtCount(), 1u);
}

TEST(BlockDealer, CountsAsDoneWhatItsWorkerHasAskedAfter) {
    BlockDealer dealer({0, 100}, 2, 1.0);
    dealer.Next(0, 0.0);
    dealer.Next(1, 0.0);
    EXPECT_EQ(dealer.DealtCount(), 2u);
    EXPECT_EQ(dealer.DoneCount(), 0u);
    const auto block = dealer.Next(0, 16.0);
    ASSERT_TRUE(block);
    EXPECT_EQ(dealer.DoneCount(), 1u);
    EXPECT_EQ(dealer.DealtCount(), 2u + block->count);
}

TEST(BlockQueue, AnswersEveryDeviceAndRethrowsTheErrorOfOne) {
    BlockQueue queue(2);
    std::vector<SampleRange> got;
    std::jthread works([&] {
        while (const auto block = queue.Next(0, 1.0)) got.push_back(*block);
    });
    std::jthread fails([&] { queue.Fail(1, std::make_exception_ptr(std::runtime_error("lost"))); });
    uint32_t answered = 0;
    while (!queue.IsOver()) {
        const auto request = queue.TakeRequest(std::chrono::milliseconds(10));
        if (!request) continue;
        EXPECT_EQ(request->device, 0u);
        if (answered < 3)
            queue.Answer(0, SampleRange{answered++, 1});
        else
            queue.Answer(0, std::nullopt);
    }
    works.join();
    EXPECT_EQ(got, (std::vector<SampleRange>{{0, 1}, {1, 1}, {2, 1}}));
    EXPECT_TRUE(queue.HasFailed());
    EXPECT_THROW(queue.RethrowError(), std::runtime_error);
}

TEST(BlockQueue, ClosedOneLetsWaitingDevicesGo) {
    BlockQueue queue(1);
    std::optional<SampleRange> answer{SampleRange{1, 1}};
    std::jthread waits([&] { answer = queue.Next(0, 1.0); });
    ASSERT_TRUE(queue.TakeRequest(std::chrono::seconds(10)));  // it waits now
    queue.Close();
    waits.join();
    EXPECT_FALSE(answer);
    EXPECT_TRUE(queue.IsOver());
}

}  // namespace raygraph::session::block_dealer_test

// When frames would wait, and what they say of their times.
#include "tests/graph/graph_test.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"

namespace raygraph::frame_timing_test {
namespace {

constexpr Extent2D kExtent{37, 19};

class FrameTimingTest : public GraphTest {};

TEST_F(FrameTimingTest, WouldWait_SaysWhenAllFramesInFlightArePending) {
    EXPECT_FALSE(m_renderer.WouldBlock());
    testing::Gate gate(Device());
    for (uint32_t frame = 0; frame < Device().FramesInFlight(); ++frame) {
        EXPECT_FALSE(m_renderer.WouldBlock()) << "before frame " << frame;
        m_renderer.BeginFrame();
        m_renderer.WaitSemaphore(gate.At(1));
        m_renderer.Present(Fill(m_renderer, "a", kExtent, 1.0f));
        m_renderer.Execute();
    }
    EXPECT_TRUE(m_renderer.WouldBlock());
    gate.Open();
    Device().WaitIdle();
    EXPECT_FALSE(m_renderer.WouldBlock());
}

TEST_F(FrameTimingTest, NextPass_IsTheIdInTheTimings) {
    m_renderer.BeginFrame();
    EXPECT_EQ(m_renderer.NextPass().index, 0u);
    Fill(m_renderer, "unused", kExtent, 1.0f);
    const PassId first = m_renderer.NextPass();
    m_renderer.Present(Scale(m_renderer, "b", Fill(m_renderer, "a", kExtent, 1.0f), 2.0f));
    const PassId end = m_renderer.NextPass();
    EXPECT_EQ(first.index, 1u);
    EXPECT_EQ(end.index, 3u);
    m_renderer.Execute();
    Device().WaitIdle();
    const std::vector<FrameTiming> timings = m_renderer.TakeTimings();
    ASSERT_EQ(timings.size(), 1u);
    ASSERT_EQ(timings[0].passes.size(), 2u);
    EXPECT_EQ(timings[0].passes[0].id.index, 1u);
    EXPECT_EQ(timings[0].passes[1].id.index, 2u);
    EXPECT_NE(testing::ErrorTextOf([&] { m_renderer.NextPass(); }), "accepted") << "no frame is open";
}

TEST_F(FrameTimingTest, Timings_ArriveForEveryFrameInOrder) {
    constexpr uint64_t kFrames = 7;
    std::vector<FrameTiming> timings;
    for (uint64_t frame = 0; frame < kFrames; ++frame) {
        m_renderer.BeginFrame();
        m_renderer.Present(Scale(m_renderer, "b", Fill(m_renderer, "a", {512, 512}, 1.0f), 2.0f));
        m_renderer.Execute();
        for (FrameTiming& timing : m_renderer.TakeTimings()) timings.push_back(std::move(timing));
    }
    Device().WaitIdle();
    for (FrameTiming& timing : m_renderer.TakeTimings()) timings.push_back(std::move(timing));
    ASSERT_EQ(timings.size(), kFrames);
    for (uint64_t frame = 0; frame < kFrames; ++frame) {
        EXPECT_EQ(timings[frame].frame, frame + 1);
        ASSERT_EQ(timings[frame].passes.size(), 2u);
        EXPECT_EQ(timings[frame].passes[0].name, "Fill a");
        EXPECT_EQ(timings[frame].passes[1].name, "Scale b");
        for (const PassTiming& pass : timings[frame].passes) {
            EXPECT_GT(pass.gpuMs, 0.0);
            EXPECT_GT(pass.cpuMs, 0.0);
        }
        EXPECT_GT(timings[frame].declareMs, 0.0);
        EXPECT_GT(timings[frame].compileMs, 0.0);
        EXPECT_GT(timings[frame].recordMs, 0.0);
    }
    EXPECT_EQ(m_renderer.Timing().frame, kFrames);
}

}  // namespace
}  // namespace raygraph::frame_timing_test

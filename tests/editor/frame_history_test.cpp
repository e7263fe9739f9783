// Tests what is stored of the last frames.
#include "editor/app/statistics_panel.h"

#include <gtest/gtest.h>

namespace raygraph::editor::frame_history_test {

namespace {

FrameTiming Timing(std::vector<PassTiming> passes) {
    FrameTiming timing;
    timing.declareMs = timing.compileMs = timing.recordMs = timing.submitMs = 0.25;
    timing.passes = std::move(passes);
    return timing;
}

}  // namespace

TEST(FrameHistory, PassesOfANameAreOneAndTheLongestComesFirst) {
    FrameHistory history;
    history.Add(Timing({{"Trace", 0.0, 4.0}, {"Tonemap", 0.0, 1.0}, {"Trace", 0.0, 2.0}}));
    history.Add(Timing({{"Tonemap", 0.0, 3.0}, {"Idle", 0.0, 0.0}}));
    EXPECT_EQ(history.Gpu(), (std::vector<float>{7.0f, 3.0f}));
    EXPECT_EQ(history.Cpu(), (std::vector<float>{1.0f, 1.0f}));
    const std::vector<FrameHistory::Pass> passes = history.Passes();
    ASSERT_EQ(passes.size(), 2u);
    EXPECT_EQ(passes[0].name, "Trace");
    EXPECT_EQ(passes[0].ms, (std::vector<float>{6.0f, 0.0f}));
    EXPECT_EQ(passes[0].mean, 3.0f);
    EXPECT_EQ(passes[1].ms, (std::vector<float>{1.0f, 3.0f}));
}

TEST(FrameHistory, ForgetsTheOldest) {
    FrameHistory history;
    for (size_t i = 0; i < FrameHistory::kLength + 5; ++i)
        history.Add(Timing({{"Pass", 0.0, static_cast<double>(i)}}));
    EXPECT_EQ(history.Count(), FrameHistory::kLength);
    EXPECT_EQ(history.Gpu().front(), 5.0f);
    EXPECT_EQ(history.Passes()[0].ms.size(), FrameHistory::kLength);
}

TEST(SampleRate, IsThatOfTheLastSeconds) {
    SampleRate rate;
    EXPECT_FALSE(rate.PerSecond());
    for (int i = 0; i <= 100; ++i) rate.Note(0.1 * i, 0.5 * i);  // 5 per second
    EXPECT_NEAR(*rate.PerSecond(), 5.0, 1e-9);
    for (int i = 1; i <= 100; ++i) rate.Note(10.0 + 0.1 * i, 50.0 + 2.0 * i);  // then 20 per second
    EXPECT_NEAR(*rate.PerSecond(), 20.0, 1e-6) << "what was before is forgotten";
    rate.Note(20.1, 0.0);
    EXPECT_FALSE(rate.PerSecond()) << "accumulation restarted";
}

TEST(TimeLeft, FallsWithTheSquareOfTheError) {
    EXPECT_NEAR(SecondsLeft(0.02, 0.01, 100.0, 10.0), 30.0, 1e-9) << "400 samples are needed";
    EXPECT_EQ(SecondsLeft(0.005, 0.01, 100.0, 10.0), 0.0);
}

}  // namespace raygraph::editor::frame_history_test

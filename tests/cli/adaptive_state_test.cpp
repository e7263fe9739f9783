// Tests which states of adaptive renders a file may have, and that every valid one continues.
#include "editor/session/frames/adaptive_frames.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/cli/adaptive_picture.h"
#include "tests/cli/cli_test.h"

namespace raygraph::session::adaptive_state_test {

using namespace adaptive_picture;

namespace {

// Returns the state that a file stores at this average.
AdaptiveState StateAt(uint32_t average) {
    AdaptiveCounts counts(kPicture);
    RunTo(counts, average, 1000, Noted());
    AdaptiveState state = counts.State();
    for (uint32_t base = counts.FirstBaseNeeded(); base < std::ranges::max(state.counts); base *= 2)
        state.noted[base] = {std::vector<float>(kPixels, 1.0f), std::vector<float>(kPixels, 1.0f)};
    return state;
}

}  // namespace

TEST(AdaptiveState, FlawsAreNamed) {
    const AdaptiveState good = StateAt(100);
    for (const uint32_t average : {1u, 15u, 16u, 17u, 64u, 100u, 128u, 129u, 200u, 256u, 700u})
        EXPECT_EQ(FlawOf(StateAt(average), kPicture), "") << average;
    ASSERT_FALSE(good.noted.empty());
    const auto expectFlaw = [&](const char* part, auto&& change) {
        AdaptiveState bad = good;
        change(bad);
        const std::string flaw = FlawOf(bad, kPicture);
        EXPECT_NE(flaw.find(part), std::string::npos) << part << ": " << flaw;
    };
    expectFlaw("counts", [](AdaptiveState& s) { s.counts.pop_back(); });
    expectFlaw("without a sample", [](AdaptiveState& s) { s.counts[5] = 0; });
    expectFlaw("fewer samples than a stage of 128 begins with", [](AdaptiveState& s) { s.counts[5] = 3; });
    expectFlaw("wanted", [](AdaptiveState& s) { s.wanted.pop_back(); });
    expectFlaw("more samples than it is to have", [](AdaptiveState& s) { s.wanted[5] = s.counts[5] - 1; });
    expectFlaw("gives no pixel as many", [](AdaptiveState& s) { s.wanted[5] = 0xFFFFFFFFu; });
    expectFlaw("gives no pixel as many", [](AdaptiveState& s) { s.counts[5] = s.wanted[5] = 17; });
    expectFlaw("stage of 96", [](AdaptiveState& s) { s.stages[1] = 96; });
    expectFlaw("stage of 0", [](AdaptiveState& s) { s.stages[0] = 0; });
    expectFlaw("stage of 2147483648", [](AdaptiveState& s) { s.stages[0] = 1u << 31; });
    expectFlaw("not of one time", [](AdaptiveState& s) { s.stages[0] = 512; });
    expectFlaw("not of one time", [](AdaptiveState& s) { s.stages[1] = 16; });
    expectFlaw("before their first stage", [](AdaptiveState& s) { s.stages = {16, 16}; });
    // One color alone has too many
    expectFlaw("samples on average", [](AdaptiveState& s) {
        ForPixelsOfColor(kPicture, 1, [&](size_t i) { s.wanted[i] = std::max(s.counts[i], 32u); });
    });
    expectFlaw("samples on average",
               [](AdaptiveState& s) { ForPixelsOfColor(kPicture, 0, [&](size_t i) { s.wanted[i] = 300; }); });
    expectFlaw("no variance of", [](AdaptiveState& s) { s.noted.clear(); });
    expectFlaw("not of its pixels", [](AdaptiveState& s) { s.noted.begin()->second.variance.pop_back(); });
    expectFlaw("not of its pixels", [](AdaptiveState& s) { s.noted.begin()->second.mean.pop_back(); });
    expectFlaw("is no number", [](AdaptiveState& s) { s.noted.begin()->second.variance[1] = -1.0f; });
    expectFlaw("is no number", [](AdaptiveState& s) { s.noted.begin()->second.mean[1] = INFINITY; });
    // Every pixel has as many times the average as one pixel may have
    expectFlaw("samples on average", [](AdaptiveState& s) {
        s.counts.assign(kPixels, 1088);
        s.wanted = s.counts;
        s.stages = {128, 128};
        for (uint32_t base = 32; base <= 1024; base *= 2) s.noted[base] = s.noted.begin()->second;
    });
    // A file without sums cannot continue, which is no flaw
    const AdaptiveState ended{.counts = good.counts, .wanted = {}, .noted = {}};
    EXPECT_EQ(FlawOf(ended, kPicture), "");
}

// These states include those that no render has written.
TEST(AdaptiveState, AnyStateWithoutFlawGoesOnAndEnds) {
    std::mt19937 random(5);
    uint32_t gone = 0;
    for (int turn = 0; turn < 200; ++turn) {
        AdaptiveState state = StateAt(150);
        const uint32_t stage = 128u << random() % 3;
        state.stages = {stage, random() % 2 == 0 ? stage : 2 * stage};
        for (const uint32_t color : {0u, 1u})
            ForPixelsOfColor(kPicture, color, [&](size_t i) {
                const uint32_t own = state.stages[color];
                state.wanted[i] = own + static_cast<uint32_t>(random() % own);
                state.counts[i] = own / 8 + static_cast<uint32_t>(random() % (state.wanted[i] - own / 8 + 1));
                if (turn % 3 == 0) state.counts[i] = state.wanted[i];
            });
        for (uint32_t base = 16; base <= 4096; base *= 2) state.noted[base] = AnyNoted(1);
        ASSERT_EQ(FlawOf(state, kPicture), "");
        AdaptiveCounts counts(kPicture, state);
        const uint32_t average = counts.Average() + 300;
        RunTo(counts, average, 1u << 20, AnyNoted(2));
        EXPECT_GE(counts.Average(), average);
        ++gone;
    }
    EXPECT_EQ(gone, 200u);
}

TEST(AdaptiveState, ThereIsALastStage) {
    constexpr rhi::Extent2D kTwo{2, 1};
    AdaptiveState state{.counts = {kLastStage, kLastStage},
                        .wanted = {kLastStage, kLastStage},
                        .stages = {kLastStage, kLastStage}};
    EXPECT_EQ(FlawOf(state, kTwo).find("no variance of"), 7u) << FlawOf(state, kTwo);
    for (uint32_t base = kLastStage / 4; base < kLastStage; base *= 2)
        state.noted[base] = {{1.0f, 1.0f}, {1.0f, 1.0f}};
    ASSERT_EQ(FlawOf(state, kTwo), "");
    AdaptiveCounts counts(kTwo, state);
    const AdaptiveCounts::Next next = counts.NextTo(kLastStage + 1);
    ASSERT_EQ(next.kind, AdaptiveCounts::Next::Kind::Decision);
    test::ExpectError(
        ErrorKind::Usage,
        [&] {
            counts.Decide(next.color, {{1.0f, 1.0f}, {1.0f, 1.0f}});
        },
        "the most samples");
}

}  // namespace raygraph::session::adaptive_state_test

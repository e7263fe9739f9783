#include <gmock/gmock.h>

#include "renderer/graph/pass_series.h"
#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"

// Passes that are executed over several frames, with times of passes that the tests make up.
namespace raygraph::pass_series_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr Extent2D kExtent{37, 1203};  // 151 workgroups, more than parts

class PassSeriesTest : public GraphTest {
  protected:
    // Declares three passes as a series with `milliseconds`. Returns the product if it is complete.
    std::optional<Readback> Declare(PassSeries& series, double milliseconds, float value) {
        m_renderer.BeginSeries(series, milliseconds);
        const TextureId a = Fill(m_renderer, "a", kExtent, value);
        const TextureId c = Scale(m_renderer, "c", Scale(m_renderer, "b", a, 2.0f), 5.0f);
        if (!m_renderer.EndSeries()) return {};
        return m_renderer.ReadBack(c);
    }
    std::optional<Readback> Frame(double milliseconds, float value = 1.0f) {
        m_renderer.BeginFrame();
        const PassId first = m_renderer.NextPass();
        const std::optional<Readback> readback = Declare(m_series, milliseconds, value);
        m_renderer.Execute();
        m_executed.clear();
        for (uint32_t i = 0; i < 3; ++i)
            if (m_renderer.WasExecuted({first.index + i})) m_executed.push_back(i);
        return readback;
    }
    uint64_t UsedBytes() {
        Device().WaitIdle();
        Device().CollectGarbage();
        return Device().Memory().usedBytes;
    }
    // Reports that each pass of the last frame took so long.
    void AddTimings(double milliseconds) {
        FrameTiming timing{.frame = m_renderer.FrameNumber()};
        for (const uint32_t pass : m_executed) timing.passes.push_back({.gpuMs = milliseconds, .id = {pass}});
        m_series.AddTimings(timing);
    }

    PassSeries m_series{"series"};
    std::vector<uint32_t> m_executed;  // numbers in the series
};

TEST_F(PassSeriesTest, WithoutALimit_IsCompleteInOneFrame) {
    const std::optional<Readback> readback = Frame(0.0);
    ASSERT_TRUE(readback);
    EXPECT_TRUE(IsRamp(Read(*readback), 1.0f, 10.0f));
    EXPECT_THAT(m_renderer.DescribePlan(), HasSubstr("saved by sharing"));
}

// The first frame knows nothing and executes a 64th of the first pass, which takes 1 ms: 64 ms for all.
TEST_F(PassSeriesTest, WithALimit_GivesTheSameOverManyFrames) {
    std::optional<Readback> readback = Frame(20.0);
    EXPECT_FALSE(readback);
    EXPECT_TRUE(m_series.IsBegun());
    EXPECT_EQ(m_executed, std::vector{0u});
    AddTimings(1.0);
    // 20 of 64 ms, then the rest of the first pass: 44 ms are left
    EXPECT_FALSE(Frame(20.0));
    EXPECT_EQ(m_executed, std::vector{0u});
    EXPECT_FALSE(Frame(20.0));
    EXPECT_EQ(m_executed, std::vector{0u});
    EXPECT_THAT(m_renderer.DescribePlan(), HasSubstr("its series goes on with it in another frame"));
    EXPECT_FALSE(Frame(20.0));
    // 3 parts of the first pass, and 17 of the second, which counts as the longest known one
    EXPECT_FALSE(Frame(20.0));
    EXPECT_EQ(m_executed, (std::vector{0u, 1u}));
    AddTimings(0.05);
    for (int frame = 0; !readback; ++frame) {
        ASSERT_LT(frame, 20);
        readback = Frame(20.0);
    }
    EXPECT_FALSE(m_series.IsBegun());
    EXPECT_TRUE(IsRamp(Read(*readback), 1.0f, 10.0f));
}

TEST_F(PassSeriesTest, RestOfAPass_KeepsWhatItsFirstPartsWrote) {
    EXPECT_FALSE(Frame(20.0));
    EXPECT_THAT(m_renderer.DescribePlan(), HasSubstr("Undefined"));
    AddTimings(1.0);
    EXPECT_FALSE(Frame(20.0));
    EXPECT_THAT(m_renderer.DescribePlan(), Not(HasSubstr("Undefined"))) << m_renderer.DescribePlan();
}

TEST_F(PassSeriesTest, CompleteSeries_KeepsNoMemory) {
    while (!Frame(20.0)) AddTimings(1.0);
    const uint64_t before = UsedBytes();
    EXPECT_FALSE(Frame(20.0));
    EXPECT_GT(UsedBytes(), before);
    for (int frame = 0; frame < 100 && m_series.IsBegun(); ++frame) Frame(20.0);
    EXPECT_FALSE(m_series.IsBegun());
    EXPECT_LE(UsedBytes(), before);
}

TEST_F(PassSeriesTest, SeriesThatAreCompleteInOneFrame_KeepNoMemory) {
    PassSeries other("other");
    while (!Frame(20.0)) AddTimings(1.0);
    const uint64_t before = UsedBytes();
    const auto frame = [&](double milliseconds) {
        m_renderer.BeginFrame();
        const auto product = Declare(m_series, milliseconds, 1.0f);
        const auto otherProduct = Declare(other, milliseconds, 2.0f);
        m_renderer.Execute();
        return std::pair(product, otherProduct);
    };
    frame(20.0);
    EXPECT_TRUE(m_series.IsBegun() && other.IsBegun());
    const auto [product, otherProduct] = frame(0.0);
    EXPECT_TRUE(IsRamp(Read(product.value()), 1.0f, 10.0f));
    EXPECT_TRUE(IsRamp(Read(otherProduct.value()), 2.0f, 10.0f));
    // Two readbacks of a frame take one buffer more than one
    const uint64_t texture = uint64_t{kExtent.width} * kExtent.height * sizeof(float);
    EXPECT_LT(UsedBytes(), before + 2 * texture);
}

TEST_F(PassSeriesTest, ReleasedSeries_StartsWithItsFirstPass) {
    EXPECT_FALSE(Frame(20.0, 7.0f));
    AddTimings(0.5);
    EXPECT_FALSE(Frame(20.0, 7.0f));
    m_renderer.Release(m_series);
    EXPECT_FALSE(m_series.IsBegun());
    std::optional<Readback> readback;
    while (!readback) readback = Frame(20.0, 3.0f);
    EXPECT_TRUE(IsRamp(Read(*readback), 3.0f, 10.0f));
}

TEST_F(PassSeriesTest, BegunSeriesWithoutALimit_ExecutesTheRest) {
    EXPECT_FALSE(Frame(20.0, 7.0f));
    const std::optional<Readback> readback = Frame(0.0, 7.0f);
    ASSERT_TRUE(readback);
    EXPECT_TRUE(IsRamp(Read(*readback), 7.0f, 10.0f));
}

TEST_F(PassSeriesTest, DroppedFrame_IsDoneAgain) {
    EXPECT_FALSE(Frame(20.0));
    AddTimings(0.001);
    m_renderer.BeginFrame();
    m_renderer.BeginSeries(m_series, 20.0);
    const TextureId a = Fill(m_renderer, "a", kExtent, 1.0f);
    static_cast<void>(Scale(m_renderer, "c", Scale(m_renderer, "b", a, 2.0f), 5.0f));
    EXPECT_TRUE(m_renderer.EndSeries());
    m_renderer.DropFrame();
    EXPECT_TRUE(m_series.IsBegun());
    const std::optional<Readback> readback = Frame(20.0);
    ASSERT_TRUE(readback);
    EXPECT_TRUE(IsRamp(Read(*readback), 1.0f, 10.0f));
}

TEST_F(PassSeriesTest, PassThatWritesOtherResources_RunsInEveryFrame) {
    Readback sum;
    for (int frame = 0; frame < 3; ++frame) {
        m_renderer.BeginFrame();
        const TextureId one = Fill(m_renderer, "one", kExtent, 1.0f);
        m_renderer.BeginSeries(m_series, 1.0);
        const TextureId added = AddTo(m_renderer, "sum", one);
        static_cast<void>(Fill(m_renderer, "a", kExtent, 1.0f));
        EXPECT_FALSE(m_renderer.EndSeries());
        sum = m_renderer.ReadBack(added);
        m_renderer.Execute();
    }
    EXPECT_TRUE(IsRamp(Read(sum), 1.0f, 3.0f));
    m_renderer.Release(m_series);
}

TEST_F(PassSeriesTest, NestedOrMissingSeries_IsRefused) {
    m_renderer.BeginFrame();
    EXPECT_THAT(testing::ErrorTextOf([&] { static_cast<void>(m_renderer.EndSeries()); }),
                HasSubstr("EndSeries: no series is open"));
    m_renderer.BeginSeries(m_series, 1.0);
    EXPECT_THAT(testing::ErrorTextOf([&] { m_renderer.BeginSeries(m_series, 1.0); }),
                HasSubstr("BeginSeries: a series is open"));
    m_renderer.DropFrame();
}

}  // namespace
}  // namespace raygraph::pass_series_test

#include <cmath>

#include "base/median.h"
#include "editor/session/file/image_statistics.h"
#include "editor/session/frames/pass_times.h"
#include "tests/cli/cli_test.h"

namespace raygraph::session::statistics_test {
namespace {

TEST(ImageStatistics, RelativeErrorIsTheStandardErrorOverTheMean) {
    // Two pixels have the mean 2 and the sample variance 9, so that 9 samples make a standard error of 1
    const std::vector<float> mean{1, 2, 3, 1, 1, 2, 3, 1}, variance{9, 9, 9, 0, 9, 9, 9, 0};
    const ImageStatistics statistics = Measure(mean, variance, 9);
    EXPECT_EQ(statistics.mean, (std::array<double, 3>{1, 2, 3}));
    ASSERT_TRUE(statistics.relativeError);
    EXPECT_DOUBLE_EQ(*statistics.relativeError, 0.5);
}

TEST(ImageStatistics, EachPixelMayHaveAsManySamplesAsItLikes) {
    // The variances of the means are 1 and 3, so 2 on average
    const std::vector<float> mean{1, 2, 3, 1, 1, 2, 3, 1}, variance{9, 9, 9, 0, 9, 9, 9, 0};
    EXPECT_DOUBLE_EQ(Measure(mean, variance, std::vector<uint32_t>{9, 3}).relativeError.value_or(0.0),
                     std::sqrt(2.0) / 2.0);
    EXPECT_FALSE(Measure(mean, variance, std::vector<uint32_t>{1, 1}).relativeError);
}

TEST(ImageStatistics, NoErrorWithoutTwoSamplesVarianceOrLight) {
    const std::vector<float> light{1, 1, 1, 1}, black{0, 0, 0, 1};
    EXPECT_FALSE(Measure(light, light, 1).relativeError);
    EXPECT_FALSE(Measure(light, {}, 8).relativeError);
    EXPECT_FALSE(Measure(black, black, 8).relativeError);
    EXPECT_FALSE(Measure({}, {}, 8).relativeError);
}

TEST(Median, IsTheMiddleOrTheMeanOfTheTwo) {
    EXPECT_EQ(Median({}), 0.0);
    EXPECT_EQ(Median({3, 1, 2}), 2.0);
    EXPECT_EQ(Median({4, 1, 3, 2}), 2.5);
}

TEST(PassTimes, PassesOfOneNameInAFrameAddUp) {
    PassTimes times;
    const auto frame = [](double trace) {
        FrameTiming timing;
        timing.passes = {{"Trace", 0.0, trace}, {"Accumulate", 0.0, 1.0}, {"Accumulate", 0.0, 2.0}};
        return timing;
    };
    times.Add(std::vector<FrameTiming>{frame(10), frame(30), frame(11)});
    const std::vector<PassTime> summary = times.Summary();
    ASSERT_EQ(summary.size(), 2u);
    EXPECT_EQ(summary[0].name, "Trace");
    EXPECT_EQ(summary[0].gpuMsMedian, 11.0);
    EXPECT_EQ(summary[0].gpuMsTotal, 51.0);
    EXPECT_EQ(summary[0].count, 3u);
    EXPECT_EQ(summary[1].gpuMsMedian, 3.0);
    EXPECT_EQ(times.MedianMs("Tonemap"), 0.0);
}

}  // namespace
}  // namespace raygraph::session::statistics_test

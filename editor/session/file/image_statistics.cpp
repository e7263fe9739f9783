#include "editor/session/file/image_statistics.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace raygraph::session {

namespace {

// The variance of the mean of pixel i is its variance divided by sampleCount * samplesOf(i). `hasError` is
// true if some pixel has two samples.
template <typename SamplesOf>
ImageStatistics MeasureWith(std::span<const float> mean, std::span<const float> variance, bool hasError,
                            uint32_t sampleCount, SamplesOf&& samplesOf) {
    if (!variance.empty()) RG_CHECK_EQ(mean.size(), variance.size());
    ImageStatistics statistics;
    std::array<double, 3> sum{};
    double varianceSum = 0.0;
    if (mean.empty()) return statistics;
    for (size_t i = 0; i + 3 < mean.size(); i += 4) {
        for (size_t c = 0; c < 3; ++c) {
            sum[c] += mean[i + c];
            if (!variance.empty()) varianceSum += variance[i + c] / samplesOf(i / 4);
        }
    }
    const double pixels = 0.25 * static_cast<double>(mean.size());
    for (size_t c = 0; c < 3; ++c) statistics.mean[c] = sum[c] / pixels;
    const double meanOfAll = (sum[0] + sum[1] + sum[2]) / (3.0 * pixels);
    if (!variance.empty() && hasError && meanOfAll > 0.0)
        statistics.relativeError = std::sqrt(varianceSum / (3.0 * pixels * sampleCount)) / meanOfAll;
    return statistics;
}

}  // namespace

ImageStatistics Measure(std::span<const float> mean, std::span<const float> variance, uint32_t sampleCount) {
    return MeasureWith(mean, variance, sampleCount > 1, sampleCount, [](size_t) { return 1.0; });
}

ImageStatistics Measure(std::span<const float> mean, std::span<const float> variance,
                        std::span<const uint32_t> sampleCounts) {
    RG_CHECK_EQ(mean.size(), 4 * sampleCounts.size());
    const bool hasError = std::ranges::any_of(sampleCounts, [](uint32_t count) { return count > 1; });
    return MeasureWith(mean, variance, hasError, 1,
                       [&](size_t i) { return static_cast<double>(sampleCounts[i]); });
}

}  // namespace raygraph::session

#include "editor/session/image_statistics.h"

#include <cmath>

#include "base/check.h"

namespace raygraph::session {

ImageStatistics Measure(std::span<const float> mean, std::span<const float> variance, uint32_t sampleCount) {
    if (!variance.empty()) RG_CHECK_EQ(mean.size(), variance.size());
    ImageStatistics statistics;
    std::array<double, 3> sum{};
    double varianceSum = 0.0;
    if (mean.empty()) return statistics;
    for (size_t i = 0; i + 3 < mean.size(); i += 4) {
        for (size_t c = 0; c < 3; ++c) {
            sum[c] += mean[i + c];
            if (!variance.empty()) varianceSum += variance[i + c];
        }
    }
    const double pixels = 0.25 * static_cast<double>(mean.size());
    for (size_t c = 0; c < 3; ++c) statistics.mean[c] = sum[c] / pixels;
    const double meanOfAll = (sum[0] + sum[1] + sum[2]) / (3.0 * pixels);
    if (!variance.empty() && sampleCount > 1 && meanOfAll > 0.0)
        statistics.relativeError = std::sqrt(varianceSum / (3.0 * pixels * sampleCount)) / meanOfAll;
    return statistics;
}

}  // namespace raygraph::session

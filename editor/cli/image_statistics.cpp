#include "editor/cli/image_statistics.h"

#include <cmath>

#include "base/check.h"

namespace raygraph::cli {

ImageStatistics Measure(std::span<const float> mean, std::span<const float> variance, uint32_t sampleCount) {
    if (!variance.empty()) RG_CHECK_EQ(mean.size(), variance.size());
    ImageStatistics statistics;
    std::array<double, 3> sum{};
    double varianceSum = 0.0;
    uint64_t finitePixels = 0;
    for (size_t i = 0; i + 3 < mean.size(); i += 4) {
        if (!std::isfinite(mean[i]) || !std::isfinite(mean[i + 1]) || !std::isfinite(mean[i + 2])) {
            statistics.nonFinitePixels++;
            continue;
        }
        finitePixels++;
        for (size_t c = 0; c < 3; c++) {
            sum[c] += mean[i + c];
            if (!variance.empty() && std::isfinite(variance[i + c])) varianceSum += variance[i + c];
        }
    }
    if (finitePixels == 0) return statistics;
    const double pixels = static_cast<double>(finitePixels);
    for (size_t c = 0; c < 3; c++) statistics.mean[c] = sum[c] / pixels;
    const double meanOfAll = (sum[0] + sum[1] + sum[2]) / (3.0 * pixels);
    if (!variance.empty() && sampleCount > 1 && meanOfAll > 0.0)
        statistics.relativeError = std::sqrt(varianceSum / (3.0 * pixels * sampleCount)) / meanOfAll;
    return statistics;
}

}  // namespace raygraph::cli

// Statistics of a finished picture: its mean and its remaining noise. Threads: pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "base/api.h"

namespace raygraph::session {

struct ImageStatistics {
    std::array<double, 3> mean{};  // linear
    // Holds the standard error of a pixel relative to the picture's mean: sqrt(mean(variance / n)) / mean,
    // with means over the pixels and R, G and B. It is none below two samples, without variance, and for
    // black.
    std::optional<double> relativeError;
};

// Holds a picture's relative error at a number of samples.
struct MeasuredError {
    uint32_t samples = 0;
    std::optional<double> relativeError;  // see ImageStatistics

    bool operator==(const MeasuredError&) const = default;
};

// Takes RGBA texels: the mean of `sampleCount` samples, and the variance of one sample (may be empty).
RAYGRAPH_API ImageStatistics Measure(std::span<const float> mean, std::span<const float> variance,
                                     uint32_t sampleCount);
// Does so for pixels with numbers of samples of their own.
RAYGRAPH_API ImageStatistics Measure(std::span<const float> mean, std::span<const float> variance,
                                     std::span<const uint32_t> sampleCounts);

}  // namespace raygraph::session

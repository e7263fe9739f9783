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
    // The standard error of a pixel relative to the picture's mean: sqrt(mean(variance / n)) / mean, both
    // means over the pixels and R, G and B. None below two samples, without variance, or for black.
    std::optional<double> relativeError;
};

// The relative error that a picture had with so many samples.
struct MeasuredError {
    uint32_t samples = 0;
    std::optional<double> relativeError;  // as of ImageStatistics

    bool operator==(const MeasuredError&) const = default;
};

// RGBA texels of the mean of `sampleCount` samples and of the variance of one sample (may be empty).
RAYGRAPH_API ImageStatistics Measure(std::span<const float> mean, std::span<const float> variance,
                                     uint32_t sampleCount);
// The same where each pixel has a number of samples of its own.
RAYGRAPH_API ImageStatistics Measure(std::span<const float> mean, std::span<const float> variance,
                                     std::span<const uint32_t> sampleCounts);

}  // namespace raygraph::session

// What is said about a finished picture: its mean, its broken pixels and how noisy it still is.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace raygraph::cli {

struct ImageStatistics {
    std::array<double, 3> mean{};  // linear, over the finite pixels
    uint64_t nonFinitePixels = 0;  // NaN or infinity in R, G or B
    // The standard error of a pixel as a part of the picture's mean: sqrt(mean(variance / n)) / mean, both
    // means over the finite pixels and R, G and B. None below two samples, without variance, or for black.
    std::optional<double> relativeError;
};

// RGBA texels of the mean of `sampleCount` samples and of the variance of one sample (may be empty).
ImageStatistics Measure(std::span<const float> mean, std::span<const float> variance, uint32_t sampleCount);

}  // namespace raygraph::cli

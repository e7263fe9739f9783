// AdaptiveState is the part of an adaptive render that is needed to resume it: how many samples each pixel
// has, and is to have. Threads: plain values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/api.h"
#include "rhi/format.h"

namespace raygraph::session {

// Pixels are colored like a chessboard: `color` 0 is white, the first pixel's, and 1 is black.
inline constexpr uint32_t kColors = 2;

inline uint64_t PixelsOfColor(rhi::Extent2D picture, uint32_t color) {
    return (uint64_t{picture.width} * picture.height + (color == 0 ? 1 : 0)) / 2;
}

// Visits the pixels in rows from the top.
template <typename Visit>
void ForPixelsOfColor(rhi::Extent2D picture, uint32_t color, Visit&& visit) {
    for (uint32_t y = 0; y < picture.height; ++y)
        for (uint32_t x = (y + color) % 2; x < picture.width; x += 2) visit(size_t{y} * picture.width + x);
}

// At first all pixels get kFirstBase samples. A stage's number is the average count of a color's pixels at
// its end: 128, 256, 512, ....
inline constexpr uint32_t kFirstBase = 16, kLastStage = 1u << 26;
// The first samples of each pixel, the base, decide a stage: this part of the average. No pixel is wanted to
// have more than kMostTimes the average, or barely more.
inline constexpr uint32_t kBasePart = 8, kMostTimes = 16;

// Returns the base by which the stage after this one is decided.
inline uint32_t BaseAfter(uint32_t stage) {
    return stage == kFirstBase ? kFirstBase : stage / (kBasePart / 2);
}

// Sums of R, G and B of each pixel's variance and mean, after its first samples.
struct PixelVariances {
    std::vector<float> variance, mean;
    bool operator==(const PixelVariances&) const = default;
};

// Is stored in a render's file, in rows from the top.
struct RAYGRAPH_API AdaptiveState {
    std::vector<uint32_t> counts;  // samples that each pixel has, at least 1
    std::vector<uint32_t> wanted;  // samples that it gets in this stage; empty: cannot be resumed
    std::array<uint32_t, kColors> stages{kFirstBase, kFirstBase};  // by color
    // By the base of a later stage: the pixels that already have more samples; 0 for the others.
    std::map<uint32_t, PixelVariances> noted;

    bool operator==(const AdaptiveState&) const = default;
    uint64_t Total() const;
    uint32_t Average() const;  // rounded down
};

// Returns the first base whose samples are still to decide about pixels of the other color.
inline uint32_t FirstBaseToKeep(const AdaptiveState& state, uint32_t color) {
    return BaseAfter(state.stages[1 - color]);
}

// Returns why it is no valid state of such a picture, as in "its pixel 3 has no sample"; empty if it is
// valid.
RAYGRAPH_API std::string FlawOf(const AdaptiveState& state, rhi::Extent2D picture);

}  // namespace raygraph::session

// Simulates a small picture with made-up noise, whose pixels get samples without a device.
#pragma once

#include <algorithm>
#include <random>

#include "editor/session/frames/adaptive_frames.h"

namespace raygraph::session::adaptive_picture {
inline constexpr rhi::Extent2D kPicture{24, 17};
inline constexpr size_t kPixels = size_t{24} * 17;

// Returns noise that is ten times as strong on the left as on the right, and absent on the lower rows; the
// brightness is uniform.
inline PixelVariances Noted() {
    PixelVariances noted{std::vector<float>(kPixels), std::vector<float>(kPixels, 1.0f)};
    for (size_t i = 0; i < kPixels; ++i) noted.variance[i] = i / 24 > 11 ? 0.0f : i % 24 < 12 ? 1.0f : 0.01f;
    return noted;
}

inline PixelVariances AnyNoted(uint32_t seed) {
    std::mt19937 random(seed);
    std::lognormal_distribution<float> any(0.0f, 2.0f);
    PixelVariances noted;
    for (size_t i = 0; i < kPixels; ++i) {
        noted.variance.push_back(any(random));
        noted.mean.push_back(any(random));
    }
    return noted;
}

// Advances until each color has the average, with at most `atOnce` samples per step.
inline void RunTo(AdaptiveCounts& counts, uint32_t average, uint32_t atOnce, const PixelVariances& noted) {
    using Kind = AdaptiveCounts::Next::Kind;
    while (true) {
        const AdaptiveCounts::Next next = counts.NextTo(average);
        if (next.kind == Kind::Nothing) return;
        if (next.kind == Kind::Decision)
            counts.Decide(next.color, noted);
        else
            counts.Advance(next, std::min(next.length, atOnce));
    }
}

}  // namespace raygraph::session::adaptive_picture

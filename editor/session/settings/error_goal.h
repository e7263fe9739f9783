// ErrorTarget determines after how many samples a picture has the wanted error. For editor/session/ alone.
// Threads: one at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "editor/session/file/image_statistics.h"

namespace raygraph::session {

// Measures RGBA texels as Measure does; 0 for a picture that is black without any variance. `counts` holds
// the samples of each pixel of an adaptive picture; empty: all have equally many.
MeasuredError MeasureError(std::span<const float> mean, std::span<const float> variance, uint32_t sampleCount,
                           std::span<const uint32_t> counts = {});

// Measures at 64, 128, 256, ... samples, and predicts from each measurement how many are needed. So the
// number depends on the samples alone, and neither on time nor on who renders them. It depends on their own
// variance, which biases the picture by an amount that falls with their number, so no render stops before
// kMin.
class ErrorTarget {
  public:
    // `wanted` is relative; none: there is no goal, and nothing to stop for.
    explicit ErrorTarget(const std::optional<double>& wanted) : m_wanted(wanted) {}

    void Measured(const MeasuredError& error);
    // Returns the next count above `samples` at which to measure or to end.
    std::optional<uint32_t> NextStop(uint32_t samples) const;
    bool IsReachedAt(uint32_t samples) const { return m_needed > 0 && samples >= m_needed; }
    bool IsMeasuringAt(uint32_t samples) const;

  private:
    static constexpr uint32_t kMin = 64;
    std::optional<double> m_wanted;
    uint32_t m_needed = 0;  // 0: unknown
};

}  // namespace raygraph::session

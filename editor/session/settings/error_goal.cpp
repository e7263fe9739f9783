#include "editor/session/settings/error_goal.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace raygraph::session {

namespace {

bool IsBlack(std::span<const float> texels) {
    for (size_t i = 0; i < texels.size(); ++i)
        if (i % 4 != 3 && texels[i] != 0.0f) return false;
    return true;
}

}  // namespace

MeasuredError MeasureError(std::span<const float> mean, std::span<const float> variance, uint32_t sampleCount,
                           std::span<const uint32_t> counts) {
    MeasuredError error{sampleCount, counts.empty() ? Measure(mean, variance, sampleCount).relativeError
                                                    : Measure(mean, variance, counts).relativeError};
    // Nothing indicates that there is light to be found
    if (IsBlack(mean) && IsBlack(variance)) error.relativeError = 0.0;
    return error;
}

void ErrorTarget::Measured(const MeasuredError& error) {
    if (!m_wanted || !error.relativeError) return;
    const double ratio = *error.relativeError / *m_wanted;
    const double needed = std::ceil(error.samples * ratio * ratio);
    m_needed = static_cast<uint32_t>(std::clamp(needed, double{kMin}, 4294967294.0));
}

bool ErrorTarget::IsMeasuringAt(uint32_t samples) const {
    return m_wanted && samples >= kMin && std::has_single_bit(samples);
}

std::optional<uint32_t> ErrorTarget::NextStop(uint32_t samples) const {
    if (!m_wanted) return std::nullopt;
    const uint64_t next = std::bit_ceil(std::max<uint64_t>(uint64_t{samples} + 1, kMin));
    const uint64_t end = m_needed > 0 ? std::max<uint64_t>(m_needed, uint64_t{samples} + 1) : next;
    return static_cast<uint32_t>(std::min<uint64_t>({next, end, 0xFFFFFFFFu}));
}

}  // namespace raygraph::session

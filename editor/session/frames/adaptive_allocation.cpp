#include "editor/session/frames/adaptive_allocation.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace raygraph::session {

namespace {

constexpr int kReach = 3;  // pixels around one, to each side
// Relative to the picture's mean: pixels that are darker than this need no smaller an error for it.
constexpr double kDark = 0.5;
// Pixels around which nothing varies count as much as this part of the average pixel.
constexpr double kLeastWeight = 0.02;

// The variance of pixels of the color that was noted, relative to the square of how bright they are.
std::vector<double> RelativeVariances(rhi::Extent2D picture, uint32_t color, const PixelVariances& noted) {
    double sum = 0.0;
    ForPixelsOfColor(picture, color, [&](size_t i) { sum += std::max(0.0f, noted.mean[i]); });
    const double dark =
        kDark * sum / static_cast<double>(std::max<uint64_t>(PixelsOfColor(picture, color), 1));
    std::vector<double> variances(noted.variance.size());
    ForPixelsOfColor(picture, color, [&](size_t i) {
        const double mean = noted.mean[i], brightness = mean * mean + dark * dark;
        if (brightness > 0.0) variances[i] = noted.variance[i] / brightness;
    });
    return variances;
}

// Returns for each pixel of `color` the root mean square of the relative deviations of the other color's
// pixels around it, weighted by nearness.
std::vector<double> WeightsOf(rhi::Extent2D picture, uint32_t color, const PixelVariances& noted) {
    const std::vector<double> variances = RelativeVariances(picture, 1 - color, noted);
    const int64_t width = picture.width, height = picture.height;
    std::vector<double> weights;
    weights.reserve(PixelsOfColor(picture, color));
    double total = 0.0;
    ForPixelsOfColor(picture, color, [&](size_t pixel) {
        const int64_t x = static_cast<int64_t>(pixel) % width, y = static_cast<int64_t>(pixel) / width;
        double sum = 0.0, shares = 0.0;
        for (int64_t dy = std::max<int64_t>(-kReach, -y); dy <= std::min<int64_t>(kReach, height - 1 - y);
             ++dy) {
            // The other color: dx + dy is odd
            for (int64_t dx = (dy % 2 == 0) ? -kReach : 1 - kReach; dx <= kReach; dx += 2) {
                if (x + dx < 0 || x + dx >= width) continue;
                const double share = 1.0 / static_cast<double>(dx * dx + dy * dy);
                sum += share * variances[static_cast<size_t>((y + dy) * width + x + dx)];
                shares += share;
            }
        }
        weights.push_back(shares > 0.0 ? std::sqrt(sum / shares) : 0.0);
        total += weights.back();
    });
    const double floor = kLeastWeight * total / static_cast<double>(std::max<size_t>(weights.size(), 1));
    for (double& weight : weights) weight = floor > 0.0 ? std::max(weight, floor) : 1.0;
    return weights;
}

// Pixels of one color, by their place in the rows of that color.
class Allocation {
  public:
    Allocation(std::vector<double> weights, std::vector<uint32_t> least, uint32_t average)
        : m_weights(std::move(weights)),
          m_least(std::move(least)),
          m_most(static_cast<double>(average) * kMostTimes),
          m_wanted(static_cast<double>(average) * static_cast<double>(m_weights.size())) {}

    // Powers of two, where `least` are: of Sobol points the first ones of such a number are spread best, and
    // of few different counts each is that of many pixels, which take their steps together. What a pixel is
    // rounded down by, the next ones get.
    std::vector<uint32_t> Counts() const {
        const double factor = Factor();
        std::vector<uint32_t> counts(m_least);
        double total = 0.0, owed = 0.0;
        for (size_t i = 0; i < counts.size(); ++i) {
            const double count = std::min(factor * m_weights[i], m_most);
            if (count > m_least[i]) {
                const uint32_t power = std::bit_floor(static_cast<uint32_t>(count));
                const uint32_t low = std::max(m_least[i], power), high = 2 * power;
                owed += count - low;
                counts[i] = owed >= 0.5 * (high - low) ? high : low;
                owed -= counts[i] - low;
            }
            total += counts[i];
        }
        // Never less than the average, so that each color's stage ends for itself
        while (total < m_wanted) {
            for (size_t i = 0; i < counts.size() && total < m_wanted; ++i) {
                if (2.0 * counts[i] > m_most) continue;
                total += counts[i];
                counts[i] *= 2;
            }
        }
        return counts;
    }

  private:
    static double Sum(const std::vector<double>& values) {
        double sum = 0.0;
        for (const double value : values) sum += value;
        return sum;
    }
    std::pair<double, double> SamplesAt(double factor) const {
        double samples = 0.0, slope = 0.0;
        for (size_t i = 0; i < m_weights.size(); ++i) {
            const double count = factor * m_weights[i];
            samples += std::clamp(count, static_cast<double>(m_least[i]), m_most);
            if (count > m_least[i] && count < m_most) slope += m_weights[i];
        }
        return {samples, slope};
    }

    // The factor of the weights that gives as many samples as are wanted, as if there were parts of samples.
    double Factor() const {
        double low = 0.0, high = 0.0;  // too few, enough
        for (const double weight : m_weights) high = std::max(high, m_most / weight);
        // Newton's steps, each with the pixels between their bounds; within the bracket
        double factor = m_wanted / Sum(m_weights);
        for (int step = 0; step < 32 && high - low > 1e-9 * high; ++step) {
            const auto [samples, slope] = SamplesAt(factor);
            (samples < m_wanted ? low : high) = factor;
            factor += slope > 0.0 ? (m_wanted - samples) / slope : 0.0;
            if (!(factor > low && factor < high)) factor = 0.5 * (low + high);
        }
        return high;
    }
    std::vector<double> m_weights;
    std::vector<uint32_t> m_least;
    double m_most, m_wanted;
};

}  // namespace

void AllocateSamples(rhi::Extent2D picture, uint32_t color, const PixelVariances& noted,
                     std::span<const uint32_t> least, uint32_t average, std::span<uint32_t> wanted) {
    std::vector<uint32_t> leastOfColor;
    ForPixelsOfColor(picture, color, [&](size_t pixel) { leastOfColor.push_back(least[pixel]); });
    if (leastOfColor.empty()) return;
    const std::vector<uint32_t> counts =
        Allocation(WeightsOf(picture, color, noted), std::move(leastOfColor), average).Counts();
    size_t next = 0;
    ForPixelsOfColor(picture, color, [&](size_t pixel) { wanted[pixel] = counts[next++]; });
}

}  // namespace raygraph::session

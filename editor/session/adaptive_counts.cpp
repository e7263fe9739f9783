#include "editor/session/adaptive_counts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/check.h"
#include "base/text.h"
#include "shaders/shared/mix_bits.h"

namespace raygraph::session {

namespace {

// A stage's extra samples come in so many rounds, so that a render which ends within it has some everywhere.
constexpr uint32_t kTurns = 2;
constexpr uint32_t kFirstBase = kFirstStage / kBasePart;
constexpr int kReach = 3;  // of the pixels around one, to each side

uint32_t RoundedUp(uint64_t count, uint32_t unit) {
    return static_cast<uint32_t>((count + unit - 1) / unit * unit);
}

// The next number of samples at which a variance is noted.
uint32_t NextBase(uint32_t count) {
    return std::max(std::bit_ceil(count + 1), kFirstBase);
}

// Mean standard deviation of the other color's pixels around each one, near ones weighing more. 0 of a
// picture of one pixel.
std::vector<double> DeviationsAround(rhi::Extent2D picture, std::span<const float> variance) {
    const auto width = static_cast<int>(picture.width), height = static_cast<int>(picture.height);
    std::vector<double> deviation(variance.size()), around(variance.size());
    for (size_t i = 0; i < variance.size(); ++i) deviation[i] = std::sqrt(double{variance[i]});
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            double sum = 0.0, weights = 0.0;
            for (int dy = std::max(-kReach, -y); dy <= std::min(kReach, height - 1 - y); ++dy) {
                // The other color: dx + dy is odd
                for (int dx = (dy % 2 == 0) ? -kReach : 1 - kReach; dx <= kReach; dx += 2) {
                    if (x + dx < 0 || x + dx >= width) continue;
                    const double weight = 1.0 / (dx * dx + dy * dy);
                    sum += weight * deviation[static_cast<size_t>(y + dy) * picture.width + (x + dx)];
                    weights += weight;
                }
            }
            around[static_cast<size_t>(y) * picture.width + x] = weights > 0.0 ? sum / weights : 0.0;
        }
    }
    return around;
}

// One color's share.
class Allocation {
  public:
    Allocation(std::span<const double> deviation, std::span<const uint32_t> least, uint32_t average,
               uint32_t unit, std::vector<size_t> pixels)
        : m_deviation(deviation),
          m_least(least),
          m_unit(unit),
          m_most(uint64_t{average} * kMostTimes),
          m_wanted(uint64_t{average} * pixels.size()),
          m_pixels(std::move(pixels)) {}

    void Fill(std::vector<uint32_t>& wanted) const {
        double greatest = 0.0;
        for (const size_t i : m_pixels) greatest = std::max(greatest, m_deviation[i]);
        double low = 0.0, high = greatest > 0.0 ? 2.0 * static_cast<double>(m_most) / greatest : 0.0;
        while (greatest > 0.0 && TotalOf(high) < m_wanted && high < kEndless) high *= 16.0;
        for (int step = 0; step < 48; ++step) {
            const double middle = 0.5 * (low + high);
            (TotalOf(middle) < m_wanted ? low : high) = middle;
        }
        uint64_t total = 0;
        for (const size_t i : m_pixels) total += wanted[i] = CountOf(i, high);
        if (total < m_wanted) Spread(wanted, total);
    }

  private:
    static constexpr double kEndless = 1e200;
    // Up or down by a chance that is the pixel's own. Large ones to an eighth: the fewer different counts
    // there are, the more pixels take the next step together.
    uint32_t Rounded(size_t pixel, double count) const {
        const uint32_t bits = gpu::MixBits(static_cast<uint32_t>(pixel) ^ 0x5bd1e995u);
        uint32_t unit = m_unit;
        while (16.0 * unit <= count) unit *= 2;
        return unit * static_cast<uint32_t>(count / unit + (bits >> 8u) * 0x1p-24);
    }
    uint32_t CountOf(size_t pixel, double factor) const {
        return std::max(m_least[pixel],
                        Rounded(pixel, std::min(factor * m_deviation[pixel], static_cast<double>(m_most))));
    }
    uint64_t TotalOf(double factor) const {
        uint64_t total = 0;
        for (const size_t i : m_pixels) total += CountOf(i, factor);
        return total;
    }
    // Where few pixels vary at all, the others get what is left.
    void Spread(std::vector<uint32_t>& wanted, uint64_t total) const {
        std::vector<size_t> still;
        for (const size_t i : m_pixels)
            if (m_deviation[i] == 0.0) still.push_back(i);
        if (still.empty()) still = m_pixels;
        std::ranges::stable_sort(still, {}, [&](size_t i) { return wanted[i]; });
        // Up to the level that takes all of it
        uint64_t left = m_wanted - total, below = 0;
        for (size_t n = 1; n <= still.size(); ++n) {
            below += wanted[still[n - 1]];
            const uint64_t level = (left + below + n - 1) / n;
            if (n < still.size() && level > wanted[still[n]]) continue;
            for (size_t k = 0; k < n; ++k)
                wanted[still[k]] = std::max(wanted[still[k]], Rounded(still[k], static_cast<double>(level)));
            return;
        }
    }

    std::span<const double> m_deviation;
    std::span<const uint32_t> m_least;
    uint32_t m_unit;
    uint64_t m_most, m_wanted;
    std::vector<size_t> m_pixels;
};

}  // namespace

uint64_t AdaptiveState::Total() const {
    return std::accumulate(counts.begin(), counts.end(), uint64_t{0});
}

uint32_t AdaptiveState::Average() const {
    return counts.empty() ? 0 : static_cast<uint32_t>(Total() / counts.size());
}

std::string FlawOf(const AdaptiveState& state, uint64_t pixelCount) {
    if (state.counts.size() != pixelCount) return "its counts of samples are not of its pixels";
    if (std::ranges::find(state.counts, 0u) != state.counts.end()) return "it has a pixel without a sample";
    if (state.wanted.empty()) return {};
    if (state.wanted.size() != pixelCount) return "its wanted counts of samples are not of its pixels";
    if (!std::has_single_bit(state.stage) || state.stage < kFirstStage || state.stage > (1u << 26))
        return Text("its stage of {} samples is none", state.stage);
    uint32_t most = 0;
    for (size_t i = 0; i < pixelCount; ++i) {
        if (state.counts[i] > state.wanted[i]) return "it has a pixel with more samples than it is to have";
        most = std::max(most, state.counts[i]);
    }
    if (std::ranges::max(state.wanted) > uint64_t{state.stage} * (kMostTimes + 1))
        return "it has a pixel that is to have more samples than its stage gives";
    const uint32_t base = state.stage / kBasePart;
    for (uint32_t next = state.isDecided ? 2 * base : base; next < most; next *= 2) {
        const auto noted = state.variances.find(next);
        if (noted == state.variances.end()) return Text("it has no variance of {} samples", next);
    }
    for (const auto& [samples, variance] : state.variances) {
        if (!std::has_single_bit(samples) || variance.size() != pixelCount)
            return Text("its variance of {} samples is not of its pixels", samples);
        for (const float value : variance)
            if (!(value >= 0.0f) || std::isinf(value))
                return Text("its variance of {} samples is no number", samples);
    }
    return {};
}

std::vector<uint32_t> AllocateSamples(rhi::Extent2D picture, std::span<const float> variance,
                                      std::span<const uint32_t> least, uint32_t average, uint32_t unit) {
    const std::vector<double> deviation = DeviationsAround(picture, variance);
    std::vector<uint32_t> wanted(variance.size());
    for (uint32_t color = 0; color < 2; ++color) {
        std::vector<size_t> pixels;
        for (uint32_t y = 0; y < picture.height; ++y)
            for (uint32_t x = (y + color) % 2; x < picture.width; x += 2)
                pixels.push_back(size_t{y} * picture.width + x);
        if (!pixels.empty()) Allocation(deviation, least, average, unit, std::move(pixels)).Fill(wanted);
    }
    return wanted;
}

AdaptiveCounts::AdaptiveCounts(rhi::Extent2D picture) : m_picture(picture) {
    const size_t pixels = size_t{picture.width} * picture.height;
    m_state.counts.assign(pixels, 0);
    m_state.stage = kFirstStage;
    m_state.wanted.assign(pixels, kFirstBase);
    FindMembers();
}

AdaptiveCounts::AdaptiveCounts(rhi::Extent2D picture, AdaptiveState state)
    : m_picture(picture), m_state(std::move(state)) {
    m_state.variances.clear();
    m_total = m_state.Total();
    FindMembers();
}

// What a pixel is to have after a turn.
uint32_t AdaptiveCounts::Target(size_t pixel, uint32_t turn) const {
    const uint32_t wanted = m_state.wanted[pixel], unit = Base() / 8;
    const uint64_t part = uint64_t{wanted} * turn / (uint64_t{kTurns} * unit) * unit;
    return static_cast<uint32_t>(std::min<uint64_t>(wanted, std::max<uint64_t>(Base(), part)));
}

void AdaptiveCounts::FindMembers() {
    m_members.clear();
    m_least = std::ranges::min(m_state.counts);
    while (true) {
        for (uint32_t turn = 1; turn <= kTurns; ++turn) {
            m_stepLength = std::numeric_limits<uint32_t>::max();
            for (size_t i = 0; i < m_state.counts.size(); ++i) {
                const uint32_t count = m_state.counts[i], target = Target(i, turn);
                if (count >= target) continue;
                m_members.push_back(static_cast<uint32_t>(i));
                m_stepLength = std::min({m_stepLength, target - count, NextBase(count) - count});
            }
            if (!m_members.empty()) return;
        }
        if (!m_state.isDecided) return;
        m_state.stage *= 2;
        m_state.isDecided = false;
        for (size_t i = 0; i < m_state.counts.size(); ++i)
            m_state.wanted[i] = std::max(m_state.counts[i], Base());
    }
}

void AdaptiveCounts::Decide(std::span<const float> variance) {
    RG_CHECK(NeedsDecision());
    RG_CHECK_EQ(variance.size(), m_state.counts.size());
    const uint32_t unit = Base() / 4;
    std::vector<uint32_t> least(m_state.counts.size());
    for (size_t i = 0; i < least.size(); ++i) least[i] = RoundedUp(std::max(m_state.counts[i], Base()), unit);
    m_state.wanted = AllocateSamples(m_picture, variance, least, m_state.stage, unit);
    m_state.isDecided = true;
    FindMembers();
}

bool AdaptiveCounts::Advance(uint32_t samples) {
    RG_CHECK(samples > 0 && samples <= m_stepLength);
    for (const uint32_t i : m_members) m_state.counts[i] += samples;
    m_total += uint64_t{samples} * m_members.size();
    m_stepLength -= samples;
    if (m_stepLength > 0) {
        m_least = std::ranges::min(m_state.counts);
        return false;
    }
    FindMembers();
    return true;
}

std::vector<uint32_t> AdaptiveCounts::BasesToNote() const {
    const uint32_t decided = m_state.isDecided ? Base() : Base() / 2;
    std::vector<uint32_t> bases;
    for (const uint32_t i : m_members) {
        const uint32_t count = m_state.counts[i];
        if (count > decided && count >= kFirstBase && std::has_single_bit(count) &&
            std::ranges::find(bases, count) == bases.end())
            bases.push_back(count);
    }
    return bases;
}

}  // namespace raygraph::session

#include "editor/session/frames/adaptive_frames.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::session {

namespace {

// Rounds down, so that frames have few different sizes.
uint32_t RoundedDown(uint32_t samples) {
    const uint32_t unit = std::max(std::bit_floor(samples) / 4, 1u);
    return samples / unit * unit;
}

std::string VarianceName(uint32_t base) {
    return "adaptive.variance" + std::to_string(base);
}
std::string MeanName(uint32_t base) {
    return "adaptive.mean" + std::to_string(base);
}

}  // namespace

AdaptiveFrames::AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample)
    : m_renderer(renderer),
      m_size(size),
      m_firstSample(firstSample),
      m_counts(size),
      m_lists{ColorList{passes::PixelList(renderer.Device(), size)},
              ColorList{passes::PixelList(renderer.Device(), size)}} {
    ReleaseBelow(kLastStage);  // bases of an earlier picture
}

AdaptiveFrames::AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample,
                               const AdaptiveState& state)
    : m_renderer(renderer),
      m_size(size),
      m_firstSample(firstSample),
      m_counts(size, state),
      m_lists{ColorList{passes::PixelList(renderer.Device(), size)},
              ColorList{passes::PixelList(renderer.Device(), size)}} {
    ReleaseBelow(kLastStage);
    for (const auto& [base, noted] : state.noted) {
        const passes::VarianceIds ids = Noted(base);
        passes::UploadTexels(renderer, std::as_bytes(std::span(noted.variance)), ids.variance);
        passes::UploadTexels(renderer, std::as_bytes(std::span(noted.mean)), ids.mean);
    }
}

passes::VarianceIds AdaptiveFrames::Noted(uint32_t base) const {
    return {m_renderer.Persist(VarianceName(base), {m_size, Format::R32Float}),
            m_renderer.Persist(MeanName(base), {m_size, Format::R32Float})};
}

void AdaptiveFrames::ReleaseBelow(uint32_t base) {
    for (uint32_t of = kFirstBase; of < base; of *= 2) {
        m_renderer.Release(VarianceName(of));
        m_renderer.Release(MeanName(of));
    }
}

void AdaptiveFrames::SetList(const AdaptiveCounts::Next& next) {
    const std::vector<AdaptiveCounts::WalkPixel>& walk = m_counts.WalkPixels(next.color);
    std::vector<gpu::ListedPixel> pixels(walk.size());
    std::ranges::transform(walk, pixels.begin(), [&](const AdaptiveCounts::WalkPixel& at) {
        return gpu::ListedPixel{at.pixel % m_size.width | at.pixel / m_size.width << 16u,
                                m_firstSample + at.count};
    });
    ColorList& list = m_lists[next.color];
    list.list.Set(pixels);
    list.listed = m_counts.WalkId(next.color);
}

bool AdaptiveFrames::PrepareFor(uint32_t average, const passes::Accumulation& radiance) {
    using Kind = AdaptiveCounts::Next::Kind;
    AdaptiveCounts::Next next = m_counts.NextTo(average);
    for (; next.kind == Kind::Decision; next = m_counts.NextTo(average)) AllocateStage(next.color, radiance);
    return next.kind == Kind::Samples;
}

void AdaptiveFrames::AllocateStage(uint32_t color, const passes::Accumulation& radiance) {
    const AdaptiveState state = m_counts.State();
    const uint32_t base = BaseAfter(state.stages[color]);
    if (PixelsOfColor(m_size, 1 - color) == 0) {
        const std::vector<float> none(state.counts.size(), 0.0f);
        return m_counts.AllocateStage(color, {none, none});
    }
    // The variances of the other pixels were recorded before these got more samples
    std::vector<gpu::ListedPixel> pixels;
    ForPixelsOfColor(m_size, 1 - color, [&](size_t i) {
        const auto pixel = static_cast<uint32_t>(i);
        if (state.counts[i] == base)
            pixels.push_back({pixel % m_size.width | pixel / m_size.width << 16u, base});
    });
    m_renderer.BeginFrame();
    passes::VarianceIds noted = Noted(base);
    if (!pixels.empty()) {
        ColorList& list = m_lists[1 - color];
        list.list.Set(pixels);
        list.listed = 0;
        noted = passes::RecordVariance(m_renderer, radiance,
                                       list.list.Declare(m_renderer, static_cast<uint32_t>(pixels.size())),
                                       base, base, noted);
    }
    const VarianceReadback readback = ReadBackVariances(noted);
    m_renderer.Execute();
    m_counts.AllocateStage(color,
                           {WaitForValues<float>(readback.variance), WaitForValues<float>(readback.mean)});
    ReleaseBelow(m_counts.FirstBaseNeeded());
}

AdaptiveFrames::Samples AdaptiveFrames::Take(const passes::Accumulation& radiance, uint32_t average,
                                             uint64_t mostTexels, uint32_t mostRows) {
    const AdaptiveCounts::Next next = m_counts.NextTo(average);
    ColorList& list = m_lists[next.color];
    if (list.listed != m_counts.WalkId(next.color)) SetList(next);
    const passes::ListedPixels pixels = list.list.Declare(m_renderer, next.pixels);
    if (const uint32_t base = m_counts.BaseToRecord(next.color); base > 0)
        std::ignore =
            passes::RecordVariance(m_renderer, radiance, pixels, m_firstSample + base, base, Noted(base));
    const uint64_t most = std::min(
        {uint64_t{next.length}, mostTexels / pixels.count, uint64_t{mostRows / pixels.extent.height}});
    const Samples samples{pixels, next.taken,
                          RoundedDown(static_cast<uint32_t>(std::max<uint64_t>(most, 1)))};
    m_counts.Advance(next, samples.count);
    return samples;
}

TextureId AdaptiveFrames::CountsTexture() const {
    return passes::UploadCounts(m_renderer, m_counts.State().counts, m_size);
}

AdaptiveFrames::VarianceReadback AdaptiveFrames::ReadBackVariances(const passes::VarianceIds& noted) {
    return {m_renderer.ReadBack(noted.variance), m_renderer.ReadBack(noted.mean)};
}

void AdaptiveFrames::ReadBack() {
    m_noted.clear();
    const AdaptiveState state = m_counts.State();
    uint32_t most[kColors] = {};
    for (uint32_t color = 0; color < kColors; ++color) {
        ForPixelsOfColor(m_size, color,
                         [&](size_t i) { most[color] = std::max(most[color], state.counts[i]); });
        for (uint32_t base = FirstBaseToKeep(state, color); base < most[color]; base *= 2)
            if (!m_noted.contains(base)) m_noted[base] = ReadBackVariances(Noted(base));
    }
}

AdaptiveState AdaptiveFrames::Take() const {
    AdaptiveState state = m_counts.State();
    for (const auto& [base, readback] : m_noted) {
        PixelVariances& noted = state.noted[base];
        noted = {WaitForValues<float>(readback.variance), WaitForValues<float>(readback.mean)};
        for (uint32_t color = 0; color < kColors; ++color)
            ForPixelsOfColor(m_size, color, [&, base = base](size_t i) {
                if (state.counts[i] > base && base >= FirstBaseToKeep(state, color)) return;
                noted.variance[i] = noted.mean[i] = 0.0f;
            });
    }
    return state;
}

// --- Allocation of samples ---

namespace {

constexpr int kReach = 3;  // pixels around one, to each side
// Pixels that are darker than this, relative to the picture's mean, need no smaller an error for it.
constexpr double kDark = 0.5;
// Pixels around which nothing varies weigh as much as this part of the average pixel.
constexpr double kLeastWeight = 0.02;

// Returns the recorded variances of the pixels of one color, relative to the squares of their brightness.
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
            // A pixel has the other color where dx + dy is odd
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

// Allocates samples to the pixels of one color, by their index in the rows of that color.
class Allocation {
  public:
    Allocation(std::vector<double> weights, std::vector<uint32_t> least, uint32_t average)
        : m_weights(std::move(weights)),
          m_least(std::move(least)),
          m_most(static_cast<double>(average) * kMostTimes),
          m_wanted(static_cast<double>(average) * static_cast<double>(m_weights.size())) {}

    // Returns powers of two, if `least` are: the first Sobol points of such a number are distributed best,
    // and each of few different counts belongs to many pixels, which take their steps together. What rounding
    // takes from a pixel goes to the next ones.
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
        // The total is never below the average, so that each color's stage ends independently of the other
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

    // Returns the factor of the weights that gives the wanted number of samples, before counts are rounded.
    double Factor() const {
        double low = 0.0, high = 0.0;  // give too few samples, and enough
        for (const double weight : m_weights) high = std::max(high, m_most / weight);
        // Newton's method, where only pixels between their bounds have a slope; bisection keeps it within the
        // bracket
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

// --- AdaptiveCounts ---

namespace {

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
// A stage's extra samples come in turns, half of them in each, so that a render which ends within it has some
// everywhere. The last one starts with those that pixels need for the base of the next stage: long before a
// color has the stage's average, so that the other one can decide by them when it has it.
constexpr uint32_t kTurns = 2;

// Returns the next number of samples at which variances are recorded.
uint32_t NextBase(uint32_t count) {
    return std::max(std::bit_ceil(count + 1), kFirstBase);
}

}  // namespace

AdaptiveCounts::AdaptiveCounts(rhi::Extent2D picture) : m_picture(picture) {
    const size_t pixels = size_t{picture.width} * picture.height;
    m_state.counts.assign(pixels, 0);
    m_state.wanted.assign(pixels, kFirstBase);
    FindWalk(0);
}

AdaptiveCounts::AdaptiveCounts(rhi::Extent2D picture, AdaptiveState state)
    : m_picture(picture), m_state(std::move(state)) {
    m_state.noted.clear();
    for (uint32_t color = 0; color < kColors; ++color) {
        ForPixelsOfColor(picture, color, [&](size_t i) { m_walks[color].total += m_state.counts[i]; });
        if (color == 0 || !IsFirstStage()) FindWalk(color);
    }
}

AdaptiveState AdaptiveCounts::State() const {
    AdaptiveState state = m_state;
    for (const Walk& walk : m_walks) Settle(walk, state.counts);
    return state;
}

uint32_t AdaptiveCounts::MinimumCount() const {
    return IsFirstStage() ? LeastOf(0) : std::min(LeastOf(0), LeastOf(1));
}

uint32_t AdaptiveCounts::LeastOf(uint32_t color) const {
    const Walk& walk = m_walks[color];
    if (walk.pixels.empty()) return walk.leastOfOthers;
    const uint32_t first = walk.inFlight > 0 ? walk.leastOfFirst[walk.inFlight] + walk.taken : kNone;
    return std::min({first, walk.leastOfLast[walk.inFlight], walk.leastOfOthers});
}

uint64_t AdaptiveCounts::Missing(uint32_t color, uint32_t average) const {
    const uint64_t wanted = PixelsOfColor(m_picture, color) * average;
    return wanted > m_walks[color].total ? wanted - m_walks[color].total : 0;
}

bool AdaptiveCounts::CanDecide(uint32_t color) const {
    if (!m_walks[color].pixels.empty()) return false;
    if (IsFirstStage() || PixelsOfColor(m_picture, 1 - color) == 0) return true;
    return LeastOf(1 - color) >= BaseAfter(m_state.stages[color]);
}

AdaptiveCounts::Next AdaptiveCounts::NextTo(uint32_t average) const {
    const std::array<uint64_t, kColors> missing{Missing(0, average), Missing(1, average)};
    const auto samples = [&](uint32_t color) {
        const Walk& walk = m_walks[color];
        const uint64_t left = IsFirstStage() ? missing[0] + missing[1] : missing[color];
        const uint64_t needed = std::max<uint64_t>((left + walk.inFlight - 1) / walk.inFlight, 1);
        const uint64_t most = walk.pixels[walk.inFlight - 1].missing - walk.taken;
        return Next{Next::Kind::Samples, color, walk.inFlight, walk.taken,
                    static_cast<uint32_t>(std::min(needed, most))};
    };
    const auto isWalking = [&](uint32_t color) { return !m_walks[color].pixels.empty(); };
    if (missing[0] + missing[1] == 0) return {};
    if (IsFirstStage() && isWalking(0)) return samples(0);
    const uint32_t behind = m_state.stages[1] < m_state.stages[0] ? 1 : 0;
    if (m_state.stages[behind] == kFirstBase && PixelsOfColor(m_picture, behind) > 0)
        return {Next::Kind::Decision, behind};
    for (uint32_t color = 0; color < kColors; ++color)
        if (missing[color] > 0 && isWalking(color)) return samples(color);
    for (const uint32_t color : {behind, 1 - behind})
        if (missing[color] > 0 && CanDecide(color)) return {Next::Kind::Decision, color};
    // In a file that was not written by a render, the color that decides may be behind
    for (const uint32_t color : {behind, 1 - behind})
        if (isWalking(color)) return samples(color);
    for (const uint32_t color : {behind, 1 - behind})
        if (PixelsOfColor(m_picture, color) > 0 && CanDecide(color)) return {Next::Kind::Decision, color};
    RG_CHECK(false);
    return {};
}

void AdaptiveCounts::Advance(const Next& next, uint32_t samples) {
    Walk& walk = m_walks[next.color];
    RG_CHECK(next.kind == Next::Kind::Samples && next.taken == walk.taken && samples > 0 &&
             samples <= next.length);
    walk.taken += samples;
    if (IsFirstStage()) {
        for (uint32_t color = 0; color < kColors; ++color)
            m_walks[color].total += samples * PixelsOfColor(m_picture, color);
    } else {
        walk.total += uint64_t{samples} * walk.inFlight;
    }
    while (walk.inFlight > 0 && walk.pixels[walk.inFlight - 1].missing == walk.taken) --walk.inFlight;
    if (walk.inFlight > 0) return;
    Settle(walk, m_state.counts);
    FindWalk(next.color);
}

void AdaptiveCounts::Settle(const Walk& walk, std::vector<uint32_t>& counts) const {
    for (const WalkPixel& at : walk.pixels) counts[at.pixel] = at.count + std::min(walk.taken, at.missing);
}

// Returns the count that a pixel will have after a turn of a stage.
uint32_t AdaptiveCounts::Target(size_t pixel, uint32_t stage, uint32_t turn) const {
    const uint32_t wanted = m_state.wanted[pixel], base = stage / kBasePart;
    if (turn == kTurns) return wanted;
    return std::max(wanted / 2, base);
}

void AdaptiveCounts::FindWalk(uint32_t color) {
    const std::vector<uint32_t>& counts = m_state.counts;
    if (IsFirstStage()) {
        std::vector<WalkPixel> pixels;
        for (uint32_t i = 0; i < counts.size() && counts[i] < kFirstBase; ++i)
            pixels.push_back({i, counts[i], kFirstBase - counts[i]});
        Take(color, std::move(pixels), counts[0] < kFirstBase ? kNone : counts[0]);
        return;
    }
    const uint32_t stage = m_state.stages[color];
    uint32_t leastOfOthers = kNone;
    // Pixels with the same number of missing samples take their steps together
    std::map<uint32_t, std::vector<WalkPixel>, std::greater<>> byMissing;
    for (uint32_t turn = 1; turn <= kTurns && byMissing.empty(); ++turn) {
        // Stop at the first base that one of the pixels reaches
        uint32_t level = kNone;
        ForPixelsOfColor(m_picture, color, [&](size_t i) {
            if (counts[i] < Target(i, stage, turn)) level = std::min(level, NextBase(counts[i]));
        });
        leastOfOthers = kNone;
        ForPixelsOfColor(m_picture, color, [&](size_t i) {
            const uint32_t goal = std::min(Target(i, stage, turn), level);
            if (counts[i] < goal && level != kNone)
                byMissing[goal - counts[i]].push_back(
                    {static_cast<uint32_t>(i), counts[i], goal - counts[i]});
            else
                leastOfOthers = std::min(leastOfOthers, counts[i]);
        });
    }
    std::vector<WalkPixel> pixels;
    for (const auto& [missing, those] : byMissing) pixels.insert(pixels.end(), those.begin(), those.end());
    Take(color, std::move(pixels), leastOfOthers);
}

void AdaptiveCounts::Take(uint32_t color, std::vector<WalkPixel> pixels, uint32_t leastOfOthers) {
    Walk& walk = m_walks[color];
    walk.pixels = std::move(pixels);
    walk.inFlight = static_cast<uint32_t>(walk.pixels.size());
    walk.taken = 0;
    walk.leastOfOthers = leastOfOthers;
    walk.id = ++m_lastId;
    walk.leastOfFirst.assign(walk.pixels.size() + 1, kNone);
    walk.leastOfLast.assign(walk.pixels.size() + 1, kNone);
    for (size_t n = 0; n < walk.pixels.size(); ++n)
        walk.leastOfFirst[n + 1] = std::min(walk.leastOfFirst[n], walk.pixels[n].count);
    for (size_t n = walk.pixels.size(); n > 0; --n)
        walk.leastOfLast[n - 1] =
            std::min(walk.leastOfLast[n], walk.pixels[n - 1].count + walk.pixels[n - 1].missing);
}

uint32_t AdaptiveCounts::BaseToRecord(uint32_t color) const {
    const Walk& walk = m_walks[color];
    if (IsFirstStage() || walk.taken > 0 || walk.pixels.empty()) return 0;
    const uint32_t base = NextBase(walk.pixels.front().count) / 2;
    const bool isNeeded = base >= FirstBaseToKeep(m_state, color);
    return isNeeded && std::ranges::find(walk.pixels, base, &WalkPixel::count) != walk.pixels.end() ? base
                                                                                                    : 0;
}

uint32_t AdaptiveCounts::FirstBaseNeeded() const {
    return std::min(FirstBaseToKeep(m_state, 0), FirstBaseToKeep(m_state, 1));
}

void AdaptiveCounts::AllocateStage(uint32_t color, const PixelVariances& noted) {
    RG_CHECK(m_walks[color].pixels.empty());
    RG_CHECK_EQ(noted.variance.size(), m_state.counts.size());
    RG_CHECK_EQ(noted.mean.size(), m_state.counts.size());
    const uint32_t base = BaseAfter(m_state.stages[color]);
    if (base > kLastStage / kBasePart)
        throw MakeError(ErrorKind::Usage, "adaptive: it has the most samples that it can have, {} on average",
                        kLastStage);
    const uint32_t stage = kBasePart * base;
    std::vector<uint32_t> least(m_state.counts.size());
    ForPixelsOfColor(m_picture, color, [&](size_t i) { least[i] = std::max(m_state.counts[i], 2 * base); });
    AllocateSamples(m_picture, color, noted, least, stage, m_state.wanted);
    m_state.stages[color] = stage;
    if (PixelsOfColor(m_picture, 1 - color) == 0) m_state.stages[1 - color] = stage;
    FindWalk(color);
}

// --- AdaptiveState ---

namespace {

std::string FlawOfStages(const AdaptiveState& state) {
    for (const uint32_t stage : state.stages)
        if (stage != kFirstBase &&
            (!std::has_single_bit(stage) || stage < kBasePart * kFirstBase || stage > kLastStage))
            return Text("its stage of {} samples is none", stage);
    const auto [least, most] = std::ranges::minmax(state.stages);
    if ((least == kFirstBase) != (most == kFirstBase) || most > 2 * least)
        return Text("its stages of {} and {} samples are not of one time", least, most);
    return {};
}

// Before the first decision, all pixels have equally many samples.
std::string FlawOfFirstStage(const AdaptiveState& state) {
    for (size_t i = 0; i < state.counts.size(); ++i)
        if (state.counts[i] != state.counts[0] || state.wanted[i] != kFirstBase)
            return "it has pixels that differ in their number of samples before their first stage";
    return {};
}

std::string FlawOfColor(const AdaptiveState& state, rhi::Extent2D picture, uint32_t color) {
    const uint32_t stage = state.stages[color], base = stage / kBasePart;
    uint64_t wanted = 0;
    std::string flaw;
    uint32_t most = 0;
    ForPixelsOfColor(picture, color, [&](size_t i) {
        wanted += state.wanted[i];
        most = std::max(most, state.counts[i]);
        if (state.counts[i] < base)
            flaw = Text("it has a pixel with fewer samples than a stage of {} begins with", stage);
        if (state.wanted[i] < 2 * base || state.wanted[i] > uint64_t{stage} * (kMostTimes + 1))
            flaw = Text("it has a pixel that is to have {} samples, and a stage of {} gives no pixel as many",
                        state.wanted[i], stage);
    });
    if (!flaw.empty()) return flaw;
    const uint64_t average = uint64_t{stage} * PixelsOfColor(picture, color);
    if (wanted < average || wanted > 2 * average)
        return Text("its pixels are not to have {} samples on average, as in their stage", stage);
    for (uint64_t next = FirstBaseToKeep(state, color); next < most; next *= 2)
        if (!state.noted.contains(static_cast<uint32_t>(next)))
            return Text("it has no variance of {} samples", next);
    return {};
}

}  // namespace

uint64_t AdaptiveState::Total() const {
    return std::accumulate(counts.begin(), counts.end(), uint64_t{0});
}

uint32_t AdaptiveState::Average() const {
    return counts.empty() ? 0 : static_cast<uint32_t>(Total() / counts.size());
}

std::string FlawOf(const AdaptiveState& state, rhi::Extent2D picture) {
    const uint64_t pixels = uint64_t{picture.width} * picture.height;
    if (state.counts.size() != pixels) return "its counts of samples are not of its pixels";
    if (std::ranges::find(state.counts, 0u) != state.counts.end()) return "it has a pixel without a sample";
    if (state.wanted.empty()) return {};
    if (state.wanted.size() != pixels) return "its wanted counts of samples are not of its pixels";
    if (std::string flaw = FlawOfStages(state); !flaw.empty()) return flaw;
    for (size_t i = 0; i < pixels; ++i)
        if (state.counts[i] > state.wanted[i]) return "it has a pixel with more samples than it is to have";
    if (state.stages[0] == kFirstBase) {
        if (std::string flaw = FlawOfFirstStage(state); !flaw.empty()) return flaw;
    } else {
        for (uint32_t color = 0; color < kColors; ++color)
            if (std::string flaw = FlawOfColor(state, picture, color); !flaw.empty()) return flaw;
    }
    for (const auto& [samples, noted] : state.noted) {
        if (!std::has_single_bit(samples) || noted.variance.size() != pixels || noted.mean.size() != pixels)
            return Text("its variance of {} samples is not of its pixels", samples);
        for (size_t i = 0; i < pixels; ++i)
            if (!(noted.variance[i] >= 0.0f) || !std::isfinite(noted.variance[i]) ||
                !std::isfinite(noted.mean[i]))
                return Text("its variance of {} samples is no number", samples);
    }
    return {};
}

}  // namespace raygraph::session

#include "editor/session/frames/adaptive_counts.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <limits>
#include <map>

#include "base/check.h"
#include "base/text.h"
#include "editor/session/frames/adaptive_allocation.h"

namespace raygraph::session {

namespace {

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
// A stage's extra samples come in turns, half of them in each, so that a render which ends within it has some
// everywhere. The last one starts with those that pixels need for the base of the next stage: long before a
// color has the stage's average, so that the other one can decide by them when it has it.
constexpr uint32_t kTurns = 2;

// The next number of samples at which variances are noted.
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

uint32_t AdaptiveCounts::Least() const {
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
    // In a file that no render has written, the color that decides may be behind
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
    // Few pixels miss a number that no other one does
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

void AdaptiveCounts::Decide(uint32_t color, const PixelVariances& noted) {
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

}  // namespace raygraph::session

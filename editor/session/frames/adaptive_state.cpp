#include "editor/session/frames/adaptive_state.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "base/text.h"

namespace raygraph::session {

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

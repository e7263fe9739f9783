#include "editor/viewport/denoised_view.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "editor/viewport/kept_display.h"
#include "passes/denoise.h"

namespace raygraph::viewport {

namespace {

constexpr uint32_t kLeastHalf = 8;  // fewer samples tell nothing about the noise

// Returns a count of samples that is at least `count`; a difference beyond any count is none.
uint32_t Rounded(double count) {
    return static_cast<uint32_t>(std::min(std::ceil(count), 4e9));
}

}  // namespace

uint32_t DenoisedView::First(double cost) {
    constexpr double kLeast = 4.0;
    return Rounded(std::max(kLeast, cost));
}

uint32_t DenoisedView::Next(uint32_t last, double cost) {
    constexpr double kGrowth = 0.25, kCostShare = 3.0;
    return Rounded(last + std::max(kGrowth * last, std::max(kCostShare * cost, 1.0)));
}

DenoisedView::State DenoisedView::StateFor(const passes::Accumulation& samples) const {
    if (m_state.resetCount != samples.ResetCount() || m_state.samples > samples.Declared().sampleCount)
        return {.resetCount = samples.ResetCount()};
    return m_state;
}

uint32_t DenoisedView::Due(const State& state) const {
    return state.samples == 0 ? First(m_cost) : Next(state.samples, m_cost);
}

uint32_t DenoisedView::NextStop(const passes::Accumulation& samples) const {
    const uint32_t count = samples.SampleCount();
    return std::min(std::max(Due(StateFor(samples)), count + 1),
                    std::max(std::bit_ceil(count + 1), kLeastHalf));
}

uint32_t DenoisedView::SampleCount(const passes::Accumulation& samples) const {
    return StateFor(samples).samples;
}

void DenoisedView::AddTiming(double milliseconds, double sampleMs) {
    if (milliseconds > 0.0 && sampleMs > 0.0) m_cost = milliseconds / sampleMs;
}

DenoisedView::State& DenoisedView::StateOf(uint64_t resetCount) {
    if (m_state.resetCount != resetCount) m_state = {.resetCount = resetCount};
    return m_state;
}

TextureId DenoisedView::Half(Renderer& renderer, Extent2D extent, size_t i) const {
    // Nothing that is shown needs it in the frame that keeps it
    return renderer.Persist(HalfName(i), {extent, Format::Rgba32Float}, Persistence::Always);
}

size_t DenoisedView::HalfFor(Renderer& renderer, Extent2D extent, const State& state, uint32_t count) const {
    size_t best = kNoHalf;
    for (size_t i = 0; i < kNoHalf; ++i) {
        const uint64_t samples = state.halves[i];
        const bool isAboutHalf = 3 * samples <= uint64_t{2} * count && 4 * samples >= count;
        if (samples == 0 || !isAboutHalf || renderer.IsFresh(Half(renderer, extent, i))) continue;
        if (best == kNoHalf || samples > state.halves[best]) best = i;
    }
    return best;
}

DenoisedView::Ids DenoisedView::DeclareLast(Renderer& renderer, Extent2D extent,
                                            const passes::Accumulation& samples) {
    const uint32_t count = SampleCount(samples);
    if (count == 0) return {};
    const TextureId kept = renderer.Persist(m_name, {extent, Format::Rgba32Float});
    if (renderer.IsFresh(kept)) return {};
    return {.picture = kept, .samples = count, .version = m_version};
}

DenoisedView::Ids DenoisedView::Declare(Renderer& renderer, const SceneIds& scene,
                                        const passes::TraceSettings& settings,
                                        const passes::Accumulation& samples, bool isWanted, bool mayWait) {
    const Extent2D extent = settings.extent;
    const Ids last = DeclareLast(renderer, extent, samples);
    const uint32_t count = samples.Declared().sampleCount;
    if (count == 0 || !samples.Declared().cursor.IsAtStart()) return last;
    State state = StateFor(samples);
    const uint64_t resets = state.resetCount;
    const bool isHalf = std::has_single_bit(count) && count >= kLeastHalf &&
                        count > std::max(state.halves[0], state.halves[1]);
    const bool isMade = count > last.samples && (isWanted || count >= Due(state));
    if (!isHalf && !isMade) return last;

    const PassId first = renderer.NextPass();
    const passes::AccumulatedIds radiance = passes::Resolve(renderer, samples, extent, true);
    if (isHalf) {
        const size_t i = state.halves[0] < state.halves[1] ? 0 : 1;
        static_cast<void>(Keep(renderer, radiance.mean, Half(renderer, extent, i),
                               [this, resets, i, count] { StateOf(resets).halves[i] = count; }));
        state.halves[i] = count;
    }
    if (!isMade) return last;
    passes::TraceSettings all = settings;
    all.sampleCount = count;
    const passes::GuideIds guides =
        passes::TraceGuides(renderer, scene, all, radiance.mean, radiance.variance);
    passes::DenoiseInputs inputs{.mean = radiance.mean,
                                 .variance = radiance.variance,
                                 .albedo = guides.albedo,
                                 .normal = guides.normal,
                                 .firstHalf = {},
                                 .seen = passes::DenoiseInputs::Seen{guides.seen, guides.seenByAll}};
    passes::DenoiseSettings denoising{.samples = count};
    if (const size_t half = HalfFor(renderer, extent, state, count); half != kNoHalf) {
        inputs.firstHalf = Half(renderer, extent, half);
        denoising.firstSamples = state.halves[half];
    }
    const TextureId denoised = passes::Denoise(renderer, inputs, denoising);
    const PassId end = renderer.NextPass();
    if (!mayWait && !renderer.PreparePipelines(first, end)) return last;
    const uint64_t version = m_version + 1;
    const TextureId kept = renderer.Persist(m_name, {extent, Format::Rgba32Float});
    return {.picture = Keep(renderer, denoised, kept,
                            [this, resets, count, version] {
                                StateOf(resets).samples = count;
                                m_version = version;
                            }),
            .samples = count,
            .version = version,
            .first = first,
            .end = end};
}

void DenoisedView::Release(Renderer& renderer) {
    for (const std::string& name : {m_name, HalfName(0), HalfName(1)}) renderer.Release(name);
}

}  // namespace raygraph::viewport

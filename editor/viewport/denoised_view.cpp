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
    constexpr double kLeast = 4.0, kCostShare = 0.5;
    return Rounded(std::max(kLeast, kCostShare * cost));
}

uint32_t DenoisedView::Next(uint32_t last, double cost) {
    constexpr double kGrowth = 0.25, kCostShare = 3.0;
    return Rounded(last + std::max(kGrowth * last, std::max(kCostShare * cost, 1.0)));
}

bool DenoisedView::IsStale(const passes::Accumulation& samples) const {
    return m_state.resetCount != samples.ResetCount() || m_state.samples > samples.Declared().sampleCount;
}

DenoisedView::State DenoisedView::StateFor(const passes::Accumulation& samples) const {
    return IsStale(samples) ? State{.resetCount = samples.ResetCount()} : m_state;
}

uint32_t DenoisedView::NextUpdate(const State& state) const {
    return state.samples == 0 ? First(m_cost) : Next(state.samples, m_cost);
}

uint32_t DenoisedView::NextStop(const passes::Accumulation& samples) const {
    const uint32_t count = samples.SampleCount();
    const uint32_t half = std::max(std::bit_ceil(count + 1), kLeastHalf);
    const State state = StateFor(samples);
    return state.samplesInProgress > 0 ? half : std::min(std::max(NextUpdate(state), count + 1), half);
}

uint32_t DenoisedView::SampleCount(const passes::Accumulation& samples) const {
    return StateFor(samples).samples;
}

void DenoisedView::AddTimings(const FrameTiming& timing, const Ids& frame, double milliseconds,
                              double sampleMs) {
    m_series.AddTimings(timing);
    if (frame.isBegun) m_spentMs = 0.0;
    m_spentMs += milliseconds;
    if (frame.isComplete && m_spentMs > 0.0 && sampleMs > 0.0) m_cost = m_spentMs / sampleMs;
}

DenoisedView::State& DenoisedView::StateOf(uint64_t resetCount) {
    if (m_state.resetCount != resetCount) m_state = {.resetCount = resetCount};
    return m_state;
}

TextureId DenoisedView::Half(Renderer& renderer, Extent2D extent, size_t i) const {
    // Nothing that is shown needs it in the frame that keeps it
    return renderer.Persist(HalfName(i), {extent, Format::Rgba32Float}, Persistence::Always);
}

TextureId DenoisedView::Input(Renderer& renderer, Extent2D extent, const char* name) const {
    return renderer.Persist(InputName(name), {extent, Format::Rgba32Float}, Persistence::Always);
}

size_t DenoisedView::HalfFor(Renderer& renderer, Extent2D extent, const State& state, uint32_t count) const {
    size_t best = kNoHalf;
    for (size_t i = 0; i < kNoHalf; ++i) {
        const uint64_t samples = state.keptMeans[i];
        const bool isAboutHalf = 3 * samples <= uint64_t{2} * count && 4 * samples >= count;
        if (samples == 0 || !isAboutHalf || renderer.IsFresh(Half(renderer, extent, i))) continue;
        if (best == kNoHalf || samples > state.keptMeans[best]) best = i;
    }
    return best;
}

DenoisedView::Ids DenoisedView::DeclareLast(Renderer& renderer, Extent2D extent,
                                            const passes::Accumulation& samples) {
    if (IsStale(samples)) Release(renderer);
    const uint32_t count = SampleCount(samples);
    if (count == 0) return {};
    const TextureId kept = renderer.Persist(m_name, {extent, Format::Rgba32Float});
    if (renderer.IsFresh(kept)) return {};
    return {.picture = kept, .samples = count, .version = m_version};
}

std::optional<size_t> DenoisedView::KeepHalf(Renderer& renderer, const passes::AccumulatedIds& radiance,
                                             const State& state, uint32_t count) {
    if (!IsHalf(state, count)) return {};
    const size_t i = state.keptMeans[0] < state.keptMeans[1] ? 0 : 1;
    static_cast<void>(
        Keep(renderer, radiance.mean, Half(renderer, renderer.Desc(radiance.mean).extent, i),
             [this, resets = state.resetCount, i, count] { StateOf(resets).keptMeans[i] = count; }));
    return i;
}

bool DenoisedView::IsHalf(const State& state, uint32_t count) {
    return std::has_single_bit(count) && count >= kLeastHalf &&
           count > std::max(state.keptMeans[0], state.keptMeans[1]);
}

// Returns the inputs in textures of their own, which do not change while the picture is made.
DenoisedView::Inputs DenoisedView::KeepInputs(Renderer& renderer, const Inputs& inputs) const {
    const auto keep = [&](TextureId texture, const char* name) {
        return Keep(renderer, texture, Input(renderer, renderer.Desc(texture).extent, name));
    };
    Inputs kept{.mean = keep(inputs.mean, "mean"), .variance = keep(inputs.variance, "variance"), .half = {}};
    if (inputs.half) kept.half = keep(*inputs.half, "half");
    return kept;
}

DenoisedView::Inputs DenoisedView::KeptInputs(Renderer& renderer, Extent2D extent, const State& state) const {
    Inputs kept{
        .mean = Input(renderer, extent, "mean"), .variance = Input(renderer, extent, "variance"), .half = {}};
    if (state.halfInProgress > 0) kept.half = Input(renderer, extent, "half");
    return kept;
}

DenoisedView::Ids DenoisedView::Declare(Renderer& renderer, const SceneIds& scene,
                                        const passes::TraceSettings& settings,
                                        const passes::Accumulation& samples, const Request& request) {
    const Extent2D extent = settings.extent;
    const Ids last = DeclareLast(renderer, extent, samples);
    State state = StateFor(samples);
    if (state.samplesInProgress == 0 || request.isUrgent) {
        ReleaseProgress(renderer);
        state.samplesInProgress = 0;
    }
    const uint32_t count = samples.Declared().cursor.IsAtStart() ? samples.Declared().sampleCount : 0;
    const bool isBegun = state.samplesInProgress == 0 && count > last.samples &&
                         (request.isWanted || request.isUrgent || count >= NextUpdate(state));
    const bool isDivided = state.samplesInProgress > 0 || (request.frameMs > 0.0 && !request.isUrgent);
    const PassId first = renderer.NextPass();
    Inputs inputs;
    if (IsHalf(state, count) || isBegun) {
        const passes::AccumulatedIds radiance = passes::Resolve(renderer, samples, extent, true);
        if (const std::optional<size_t> half = KeepHalf(renderer, radiance, state, count))
            state.keptMeans[*half] = count;
        if (isBegun) {
            inputs = {.mean = radiance.mean, .variance = radiance.variance, .half = {}};
            state.samplesInProgress = count;
            state.halfInProgress = 0;
            if (const size_t half = HalfFor(renderer, extent, state, count); half != kNoHalf) {
                inputs.half = Half(renderer, extent, half);
                state.halfInProgress = state.keptMeans[half];
            }
            if (isDivided) inputs = KeepInputs(renderer, inputs);
        }
    }
    if (state.samplesInProgress == 0) return last;
    if (!isBegun) inputs = KeptInputs(renderer, extent, state);

    renderer.BeginSeries(m_series, isDivided ? request.frameMs : 0.0);
    passes::TraceSettings all = settings;
    all.sampleCount = state.samplesInProgress;
    const passes::GuideIds guides = passes::TraceGuides(renderer, scene, all, inputs.mean, inputs.variance);
    const TextureId denoised = passes::Denoise(
        renderer,
        {.mean = inputs.mean,
         .variance = inputs.variance,
         .albedo = guides.albedo,
         .normal = guides.normal,
         .firstHalf = inputs.half,
         .seen = passes::DenoiseInputs::Seen{guides.seen, guides.seenByAll, guides.seenSquares}},
        {.samples = state.samplesInProgress, .firstSamples = state.halfInProgress});
    const PassId end = renderer.NextPass();
    if (!request.mayWait && !renderer.PreparePipelines(first, end)) {
        renderer.CancelSeries();
        return last;
    }
    const bool isComplete = renderer.EndSeries();
    Ids ids = last;
    ids.first = first;
    ids.end = end;
    ids.isBegun = isBegun;
    ids.isComplete = isComplete;
    if (isComplete) {
        const uint64_t version = m_version + 1;
        ids.picture = Keep(renderer, denoised, renderer.Persist(m_name, {extent, Format::Rgba32Float}),
                           [this, resets = state.resetCount, made = state.samplesInProgress, version] {
                               StateOf(resets).samples = made;
                               StateOf(resets).samplesInProgress = 0;
                               m_version = version;
                           });
        ids.samples = state.samplesInProgress;
        ids.version = version;
    } else if (isBegun) {
        renderer.OnSubmitted([this, begun = state] {
            State& now = StateOf(begun.resetCount);
            now.samplesInProgress = begun.samplesInProgress;
            now.halfInProgress = begun.halfInProgress;
        });
    }
    return ids;
}

void DenoisedView::ReleaseProgress(Renderer& renderer) {
    for (const char* input : {"mean", "variance", "half"}) renderer.Release(InputName(input));
    renderer.Release(m_series);
}

void DenoisedView::Release(Renderer& renderer) {
    for (const std::string& name : {m_name, HalfName(0), HalfName(1)}) renderer.Release(name);
    ReleaseProgress(renderer);
    m_state = {};
}

}  // namespace raygraph::viewport

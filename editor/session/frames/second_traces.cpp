#include "editor/session/frames/second_traces.h"

#include "passes/compare.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::session {

SecondTraces::Kept::Kept(Bias which) : bias(which), accumulation(std::string("removed_") + Name(which)) {}

RetracedBiases BiasesToRetrace(const passes::BiasSettings& biases, const RenderFile* continues) {
    RetracedBiases again{};
    const bool hasCount = continues != nullptr && continues->removedSamples > 0;
    for (const Bias bias : kBiases) {
        const size_t i = static_cast<size_t>(bias);
        again[i] = IsOn(biases, bias) && !(hasCount && continues->sums.removed[i].IsEmpty());
    }
    return again;
}

SecondTraces::SecondTraces(const RetracedBiases& biases) {
    for (const Bias bias : kBiases)
        if (biases[static_cast<size_t>(bias)]) m_kept.emplace_back(bias);
}

void SecondTraces::Restore(Renderer& renderer, const RenderFile& render) {
    const Extent2D extent{render.size.width, render.size.height};
    if (render.removedSamples == 0) return;
    for (Kept& kept : m_kept)
        passes::Restore(renderer, kept.accumulation, extent, render.removedSamples,
                        render.sums.removed[static_cast<size_t>(kept.bias)]);
}

void SecondTraces::Declare(Renderer& renderer, const passes::TraceSettings& settings, TextureId sample,
                           const TraceSample& trace) {
    if (settings.sampleIndex % kSecondTracePeriod != 0) return;
    for (Kept& kept : m_kept) {
        const TextureId again = trace(Without(settings, kept.bias));
        const passes::AccumulatedIds ids =
            passes::Accumulate(renderer, passes::Subtract(renderer, again, sample), kept.accumulation, true);
        renderer.Present(ids.sums[0]);
    }
}

void SecondTraces::ReadBack(Renderer& renderer, Extent2D extent) {
    for (Kept& kept : m_kept) {
        if (kept.accumulation.SampleCount() == 0) continue;
        const passes::AccumulatedIds ids = passes::Resolve(renderer, kept.accumulation, extent, true);
        kept.mean = renderer.ReadBack(ids.mean);
        kept.variance = renderer.ReadBack(ids.variance);
        kept.sums = passes::SumsReadback(renderer, ids);
    }
}

void SecondTraces::Take(RenderFile& render, bool withSums) const {
    for (const Kept& kept : m_kept) {
        const size_t i = static_cast<size_t>(kept.bias);
        render.removedSamples = kept.accumulation.SampleCount();
        if (render.removedSamples == 0) {
            render.removed[i] = render.removedVariance[i] = Texels(4 * PixelCount(render.size), 0.0f);
            if (withSums) render.sums.removed[i] = passes::MakeExactSums(PixelCount(render.size), true);
            continue;
        }
        render.removed[i] = WaitForValues<float>(kept.mean);
        render.removedVariance[i] = WaitForValues<float>(kept.variance);
        if (withSums) render.sums.removed[i] = kept.sums.Values();
    }
}

void SecondTraces::DropReadbacks() {
    for (Kept& kept : m_kept) {
        kept.mean = kept.variance = {};
        kept.sums = {};
    }
}

}  // namespace raygraph::session

#include "editor/session/second_traces.h"

#include "passes/subtract.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::session {

SecondTraces::Kept::Kept(Bias which) : bias(which), accumulation(std::string("removed_") + Name(which)) {}

SecondTraces::SecondTraces(const passes::BiasSettings& biases) {
    for (const Bias bias : kBiases)
        if (IsOn(biases, bias)) m_kept.emplace_back(bias);
}

void SecondTraces::Restore(Renderer& renderer, const RenderFile& render) {
    const Extent2D extent{render.size.width, render.size.height};
    for (Kept& kept : m_kept)
        if (const passes::ExactSums& sums = render.sums.removed[static_cast<size_t>(kept.bias)];
            render.removedSamples > 0 && !sums.IsEmpty())
            passes::Restore(renderer, kept.accumulation, extent, render.removedSamples, sums);
}

void SecondTraces::Declare(Renderer& renderer, const passes::TraceSettings& settings, TextureId sample,
                           bool isLast, const TraceSample& trace) {
    const bool isDue = settings.sampleIndex % kSecondTracePeriod == 0;
    for (Kept& kept : m_kept) {
        passes::AccumulatedIds ids;
        if (isDue) {
            const TextureId again = trace(Without(settings, kept.bias));
            ids = passes::Accumulate(renderer, passes::Subtract(renderer, again, sample), kept.accumulation,
                                     true);
            renderer.Present(ids.mean);  // the last sample may have no second traces
        } else if (isLast && kept.accumulation.SampleCount() > 0) {
            ids = passes::Kept(renderer, kept.accumulation, settings.extent, true);
        } else {
            continue;
        }
        if (!isLast) continue;
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

}  // namespace raygraph::session

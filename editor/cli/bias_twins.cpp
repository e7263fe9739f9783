#include "editor/cli/bias_twins.h"

#include "editor/cli/texel_readback.h"
#include "passes/subtract.h"

namespace raygraph::cli {

BiasTwins::Kept::Kept(Bias which) : bias(which), accumulation(std::string("removed_") + Name(which)) {}

BiasTwins::BiasTwins(const passes::BiasSettings& biases) {
    for (const Bias bias : kBiases)
        if (IsOn(biases, bias)) m_kept.emplace_back(bias);
}

void BiasTwins::Restore(Renderer& renderer, const RenderFile& render) {
    const Extent2D extent{render.size.width, render.size.height};
    for (Kept& kept : m_kept) {
        const size_t i = static_cast<size_t>(kept.bias);
        if (!render.removed[i].empty())
            passes::Restore(renderer, kept.accumulation, extent, render.removedSamples, render.removed[i],
                            render.removedVariance[i]);
    }
}

void BiasTwins::Declare(Renderer& renderer, const passes::TraceSettings& settings, TextureId sample,
                        uint32_t samplesBefore, bool isLast, const TraceSample& trace) {
    const bool isDue = samplesBefore % kTwinPeriod == 0;
    for (Kept& kept : m_kept) {
        passes::AccumulatedIds sums;
        if (isDue) {
            const TextureId twin = trace(Without(settings, kept.bias));
            sums = passes::Accumulate(renderer, passes::Subtract(renderer, twin, sample), kept.accumulation,
                                      true);
            renderer.Present(sums.mean);
        } else if (isLast && kept.accumulation.SampleCount() > 0) {
            const GraphTextureDesc desc{settings.extent, Format::Rgba32Float};
            sums.mean = renderer.Persist(kept.accumulation.Name() + ".mean", desc);
            sums.variance = renderer.Persist(kept.accumulation.Name() + ".variance", desc);
        } else {
            continue;
        }
        if (!isLast) continue;
        kept.mean = renderer.ReadBack(sums.mean);
        kept.variance = renderer.ReadBack(sums.variance);
    }
}

void BiasTwins::Take(RenderFile& render) const {
    for (const Kept& kept : m_kept) {
        if (kept.accumulation.SampleCount() == 0) continue;
        const size_t i = static_cast<size_t>(kept.bias);
        render.removed[i] = ValuesOf<float>(kept.mean);
        render.removedVariance[i] = ValuesOf<float>(kept.variance);
        render.removedSamples = kept.accumulation.SampleCount();
    }
}

}  // namespace raygraph::cli

#include "editor/session/file/render_sums.h"

#include <utility>

namespace raygraph::session {

namespace {

void Add(passes::ExactSums& sums, passes::ExactSums&& others) {
    if (sums.IsEmpty())
        sums = std::move(others);
    else if (!others.IsEmpty())
        passes::AddSums(sums, others);
}

}  // namespace

void Add(RenderSums& sums, RenderSums&& others) {
    Add(sums.radiance, std::move(others.radiance));
    for (const Aov aov : kAovs)
        if (passes::ExactSums* of = SumsOf(sums, aov)) Add(*of, std::move(*SumsOf(others, aov)));
    for (size_t i = 0; i < sums.lightGroups.size(); ++i)
        Add(sums.lightGroups[i], std::move(others.lightGroups[i]));
}

void TakeMeans(RenderFile& render) {
    const auto count = static_cast<uint32_t>(SampleCount(render.samples));
    render.radiance = passes::MeanOf(render.sums.radiance, count);
    if (render.sums.radiance.HasSquares()) render.variance = passes::VarianceOf(render.sums.radiance, count);
    for (const Aov aov : kAovs) {
        const passes::ExactSums* sums = SumsOf(render.sums, aov);
        if (sums != nullptr && !sums->IsEmpty() && aov < Aov::RemovedMaxDepth)
            *MeanOf(render, aov) = passes::MeanOf(*sums, count);
    }
    for (size_t i = 0; i < kBiasCount; ++i) {
        const passes::ExactSums& sums = render.sums.removed[i];
        if (sums.IsEmpty() || render.removedSamples == 0) continue;
        render.removed[i] = passes::MeanOf(sums, render.removedSamples);
        render.removedVariance[i] = passes::VarianceOf(sums, render.removedSamples);
    }
    for (size_t i = 0; i < render.lightGroups.size(); ++i)
        render.lightGroups[i] = passes::MeanOf(render.sums.lightGroups[i], count);
}

std::vector<passes::ExactSums*> AllOf(RenderSums& sums) {
    std::vector<passes::ExactSums*> all{&sums.radiance, &sums.albedo, &sums.normal};
    for (passes::ExactSums& part : sums.parts) all.push_back(&part);
    for (passes::ExactSums& removed : sums.removed) all.push_back(&removed);
    for (passes::ExactSums& group : sums.lightGroups) all.push_back(&group);
    return all;
}

}  // namespace raygraph::session

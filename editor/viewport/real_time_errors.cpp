#include "editor/viewport/real_time_errors.h"

#include <algorithm>
#include <cmath>

#include "passes/compare.h"
#include "passes/flip.h"

namespace raygraph::viewport {

namespace {

constexpr double kFlickerSeconds = 1.0;

}  // namespace

void RealTimeErrorRequests::Declare(Renderer& renderer, const Shown& shown) {
    const uint32_t samples = shown.progress.sampleCount;
    if (!m_requests.HasUnanswered() || samples == 0) return;
    const Extent2D extent = renderer.Desc(shown.picture).extent;
    const auto sumsOf = [&](TextureId map) { return renderer.ReadBack(passes::ReduceBlocks(renderer, map)); };

    const TextureId moments = renderer.Persist(MomentsName(), {extent, Format::Rg32Float});
    const uint32_t before = renderer.IsFresh(moments) ? 0 : m_momentFrames;
    const double passed = shown.seconds - m_momentSeconds;
    const double weight = std::max(1.0 / (before + 1.0), 1.0 - std::exp(-passed / kFlickerSeconds));
    const TextureId flickerMap =
        passes::Flicker(renderer, shown.picture, moments, before > 0 ? static_cast<float>(weight) : 1.0f);

    const passes::SquaredErrorIds squared =
        passes::RelativeSquaredError(renderer, shown.picture, shown.samples, shown.progress);
    const TextureId flipMap = passes::Flip(renderer, shown.referenceDisplay, shown.display,
                                           {.pixelsPerDegree = shown.pixelsPerDegree});
    const Readback error = sumsOf(squared.error), noise = sumsOf(squared.noise), flip = sumsOf(flipMap),
                   flicker = sumsOf(flickerMap);
    renderer.OnSubmitted([this, before, seconds = shown.seconds] {
        m_momentFrames = before + 1;
        m_momentSeconds = seconds;
    });
    m_requests.DeclareReplies(renderer, [&](std::monostate) -> decltype(m_requests)::Reply {
        return {{error, noise, flip, flicker}, [=] {
                    const auto mean = [&](const Readback& sums) {
                        return passes::StatisticsOf(sums, extent).mean;
                    };
                    RealTimeErrors errors{.referenceSamples = samples,
                                          .relativeSquaredError = mean(error),
                                          .referenceNoise = {},
                                          .flip = mean(flip),
                                          .flicker = {}};
                    if (samples > 1) errors.referenceNoise = mean(noise);
                    if (before > 0) errors.flicker = mean(flicker);
                    return errors;
                }};
    });
}

}  // namespace raygraph::viewport

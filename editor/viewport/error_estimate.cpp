#include "editor/viewport/error_estimate.h"

#include <algorithm>
#include <cmath>

#include "passes/probe.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::viewport {

namespace {

constexpr uint32_t kGrid = 64;  // probed pixels along an edge, at most

NoiseEstimate EstimateOf(const std::vector<passes::ProbedPixel>& pixels, uint32_t sampleCount) {
    NoiseEstimate estimate{.sampleCount = sampleCount, .relativeError = {}};
    double mean = 0.0, variance = 0.0;
    for (const passes::ProbedPixel& texels : pixels) {
        const double ofMean = double{texels.mean.x} + texels.mean.y + texels.mean.z;
        const double ofVariance = double{texels.variance.x} + texels.variance.y + texels.variance.z;
        mean += ofMean / 3.0;
        variance += ofVariance / 3.0;
    }
    if (sampleCount < 2 || !(mean > 0.0)) return estimate;
    const auto probed = static_cast<double>(pixels.size());
    estimate.relativeError = std::sqrt(variance / probed / sampleCount) / (mean / probed);
    return estimate;
}

}  // namespace

void NoiseRequests::Declare(Renderer& renderer, const passes::AccumulatedIds& samples,
                            const passes::Accumulation::Progress& progress) {
    const uint32_t sampleCount = progress.sampleCount;
    if (!m_requests.HasUnanswered() || sampleCount == 0) return;
    const Extent2D extent = renderer.Desc(samples.mean).extent;
    const Readback pixels =
        renderer.ReadBack(passes::Probe(renderer, samples, progress, passes::WholeOf(extent),
                                        {std::min(extent.width, kGrid), std::min(extent.height, kGrid)}));
    m_requests.DeclareReplies(renderer, [&](std::monostate) -> decltype(m_requests)::Reply {
        return {{pixels}, [pixels, sampleCount] {
                    return EstimateOf(ValuesOf<passes::ProbedPixel>(pixels), sampleCount);
                }};
    });
}

}  // namespace raygraph::viewport

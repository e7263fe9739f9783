#include "editor/viewport/error_estimate.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "passes/probe.h"

namespace raygraph::viewport {

namespace {

constexpr uint32_t kGrid = 64;  // probed pixels along an edge, at most

}  // namespace

struct ErrorRequest::State {
    bool isSubmitted = false;
    uint32_t sampleCount = 0;
    Readback texels;
};

bool ErrorRequest::IsReady() const {
    return m_state && m_state->isSubmitted && m_state->texels.IsReady();
}

ErrorEstimate ErrorRequest::Result() const {
    if (!IsReady()) throw Error(ErrorKind::Usage, "ErrorRequest: its answer is not there yet");
    ErrorEstimate estimate{.sampleCount = m_state->sampleCount};
    const std::span<const std::byte> bytes = m_state->texels.Bytes();
    double mean = 0.0, variance = 0.0;
    size_t count = 0;
    for (size_t at = 0; at + sizeof(passes::ProbedTexels) <= bytes.size();
         at += sizeof(passes::ProbedTexels)) {
        passes::ProbedTexels texels;
        std::memcpy(&texels, bytes.data() + at, sizeof texels);
        const double ofMean = double{texels.mean.x} + texels.mean.y + texels.mean.z;
        const double ofVariance = double{texels.variance.x} + texels.variance.y + texels.variance.z;
        mean += ofMean / 3.0;
        variance += ofVariance / 3.0;
        count++;
    }
    if (estimate.sampleCount < 2 || !(mean > 0.0)) return estimate;
    const auto probed = static_cast<double>(count);
    estimate.relativeError = std::sqrt(variance / probed / estimate.sampleCount) / (mean / probed);
    return estimate;
}

ErrorRequest ErrorRequests::Request() {
    ErrorRequest request;
    request.m_state = std::make_shared<ErrorRequest::State>();
    m_requests.push_back(request.m_state);
    return request;
}

void ErrorRequests::Declare(Renderer& renderer, TextureId mean, TextureId variance, uint32_t sampleCount) {
    std::erase_if(m_requests,
                  [](const std::shared_ptr<ErrorRequest::State>& state) { return state->isSubmitted; });
    if (m_requests.empty() || sampleCount == 0) return;
    const Extent2D extent = renderer.Desc(mean).extent;
    const BufferId texels = passes::ProbeGrid(
        renderer, mean, variance, {std::min(extent.width, kGrid), std::min(extent.height, kGrid)});
    const Readback readback = renderer.ReadBack(texels);
    for (const std::shared_ptr<ErrorRequest::State>& state : m_requests) {
        state->sampleCount = sampleCount;
        state->texels = readback;
        renderer.OnSubmitted([state] { state->isSubmitted = true; });
    }
}

}  // namespace raygraph::viewport

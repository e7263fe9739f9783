#include "editor/session/adaptive_frames.h"

#include <algorithm>
#include <string>
#include <utility>

#include "renderer/graph/readback_values.h"

namespace raygraph::session {

AdaptiveFrames::AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample)
    : m_renderer(renderer),
      m_size(size),
      m_firstSample(firstSample),
      m_counts(size),
      m_list(renderer.Device(), size) {}

AdaptiveFrames::AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample,
                               const AdaptiveState& state)
    : m_renderer(renderer),
      m_size(size),
      m_firstSample(firstSample),
      m_counts(size, state),
      m_list(renderer.Device(), size) {
    for (const auto& [base, variance] : state.variances)
        passes::UploadTexels(renderer, std::as_bytes(std::span(variance)), Variances(base));
}

TextureId AdaptiveFrames::Variances(uint32_t base) const {
    return m_renderer.Persist("adaptive.variance" + std::to_string(base), {m_size, Format::R32Float});
}

void AdaptiveFrames::SetList() {
    const auto listed = [&](uint32_t pixel) {
        return gpu::ListedPixel{pixel % m_size.width | pixel / m_size.width << 16u,
                                m_firstSample + m_counts.State().counts[pixel]};
    };
    std::vector<gpu::ListedPixel> pixels(m_counts.Members().size());
    std::ranges::transform(m_counts.Members(), pixels.begin(), listed);
    m_list.Set(pixels);
    m_isListDue = false;
    m_taken = 0;
}

void AdaptiveFrames::DecideIfDue(const passes::Accumulation& radiance) {
    if (!m_counts.NeedsDecision()) return;
    const uint32_t base = m_counts.Base();
    // The others were noted before they got more
    std::vector<gpu::ListedPixel> pixels;
    for (uint32_t pixel = 0; pixel < m_counts.State().counts.size(); ++pixel)
        if (m_counts.State().counts[pixel] == base)
            pixels.push_back({pixel % m_size.width | pixel / m_size.width << 16u, base});
    m_renderer.BeginFrame();
    TextureId noted = Variances(base);
    if (!pixels.empty()) {
        m_list.Set(pixels);
        noted = passes::NoteVariance(m_renderer, radiance, m_list.Declare(m_renderer), base, base, noted);
    }
    const Readback variance = m_renderer.ReadBack(noted);
    m_renderer.Execute();
    m_counts.Decide(WaitForValues<float>(variance));
    m_renderer.Forget("adaptive.variance" + std::to_string(base));
    m_isListDue = true;
}

AdaptiveFrames::Samples AdaptiveFrames::Take(const passes::Accumulation& radiance, uint32_t average,
                                             uint64_t mostTexels, uint32_t mostRows) {
    if (m_isListDue) SetList();
    const passes::ListedPixels pixels = m_list.Declare(m_renderer);
    if (m_taken == 0)
        for (const uint32_t base : m_counts.BasesToNote())
            std::ignore = passes::NoteVariance(m_renderer, radiance, pixels, m_firstSample + base, base,
                                               Variances(base));
    const uint64_t wanted = uint64_t{average} * m_counts.State().counts.size();
    const uint64_t missing = wanted > m_counts.Total() ? wanted - m_counts.Total() : 1;
    const uint64_t count =
        std::min({(missing + pixels.count - 1) / pixels.count, uint64_t{m_counts.StepLength()},
                  mostTexels / pixels.count, uint64_t{mostRows / pixels.extent.height}});
    const Samples samples{pixels, m_taken, static_cast<uint32_t>(std::max<uint64_t>(count, 1))};
    m_taken += samples.count;
    m_isListDue = m_counts.Advance(samples.count);
    return samples;
}

TextureId AdaptiveFrames::CountsTexture() const {
    return passes::UploadCounts(m_renderer, m_counts.State().counts, m_size);
}

uint32_t AdaptiveFrames::FirstBaseToKeep() const {
    return m_counts.State().isDecided ? 2 * m_counts.Base() : m_counts.Base();
}

void AdaptiveFrames::ReadBack() {
    m_variances.clear();
    const uint32_t most = std::ranges::max(m_counts.State().counts);
    for (uint32_t base = FirstBaseToKeep(); base < most; base *= 2)
        m_variances[base] = m_renderer.ReadBack(Variances(base));
}

AdaptiveState AdaptiveFrames::Take() const {
    AdaptiveState state = m_counts.State();
    for (const auto& [base, readback] : m_variances) {
        std::vector<float>& variance = state.variances[base];
        variance = WaitForValues<float>(readback);
        for (size_t i = 0; i < variance.size(); ++i)
            if (state.counts[i] <= base) variance[i] = 0.0f;
    }
    return state;
}

}  // namespace raygraph::session

// SampleFrames of an adaptive picture.
#include "editor/session/frames/sample_frames.h"
#include "passes/scene_bindings.h"
#include "rhi/device.h"

namespace raygraph::session {

void SampleFrames::RenderAdaptive(uint32_t average, uint32_t most) {
    const uint32_t next = m_submitted + std::min(average - m_submitted, most);
    while (m_adaptive->PrepareFor(next, m_radiance.accumulation)) RenderListed(next);
}

void SampleFrames::RenderListed(uint32_t average) {
    const bool hasGroups = m_plan.lightGroupCount > 0;
    const uint32_t tiles = hasGroups ? passes::LightGroupTiles(m_plan.lightGroupCount).height : 1;
    m_renderer.BeginFrame();
    const SceneIds ids = m_scene.Declare(m_plan.firstSample);
    const AdaptiveFrames::Samples samples =
        m_adaptive->Take(m_radiance.accumulation, average, PixelCount(Size()) * m_batchSize,
                         m_renderer.Device().Info().maxTextureExtent / tiles);
    passes::TraceSettings settings = m_scene.SettingsFor(samples.index);
    settings.sampleCount = samples.count;
    settings.pixels = samples.pixels;
    DeclareRadiance(ids, settings);
    DeclareUniformSamples(ids);
    m_pending.push_back({m_renderer.Execute(), uint64_t{samples.count} * samples.pixels.count});
    m_submitted = m_adaptive->Counts().Average();
    m_samples = {{m_plan.firstSample, m_submitted}};
    m_hasPicture = false;
    NonFiniteSamples();
    m_times.Add(m_renderer.TakeTimings());
}

void SampleFrames::DeclareUniformSamples(const SceneIds& ids) {
    // They have passes for each sample
    constexpr uint32_t kAtOnce = 16;
    const bool hasAverages = m_isKeepingAlbedo || m_isKeepingNormal;
    const uint32_t end = std::min(m_adaptive->Counts().Least(), m_uniformSamples + kAtOnce);
    for (; m_uniformSamples < end; ++m_uniformSamples) {
        const uint32_t index = m_plan.firstSample + m_uniformSamples;
        const passes::TraceSettings settings = m_scene.SettingsFor(index);
        if (hasAverages) DeclareAverages(ids, settings, m_uniformSamples + 1 == end);
        if (m_secondTraces.HasAny() && index % kSecondTracePeriod == 0)
            m_secondTraces.Declare(m_renderer, settings, DeclareSamples(ids, settings).radiance,
                                   [&](const auto& others) { return DeclareSamples(ids, others).radiance; });
    }
}

// Renders the surfaces that the last frames of samples left out.
void SampleFrames::CatchUpUniformSamples() {
    while (m_adaptive && m_uniformSamples < m_adaptive->Counts().Least()) {
        m_renderer.BeginFrame();
        DeclareUniformSamples(m_scene.Declare(m_plan.firstSample));
        m_renderer.Execute();
    }
}

uint32_t SampleFrames::SamplesDone() {
    const uint64_t completed = m_renderer.Device().CompletedValue();
    while (!m_pending.empty() && m_pending.front().doneAt <= completed) m_pending.pop_front();
    uint64_t pending = 0;
    for (const PendingSamples& samples : m_pending) pending += samples.count;
    if (m_adaptive)
        return static_cast<uint32_t>((m_adaptive->Counts().Total() - pending) / PixelCount(Size()));
    return m_submitted - static_cast<uint32_t>(pending);
}

std::optional<TextureId> SampleFrames::DeclareCounts() {
    if (!m_adaptive) return std::nullopt;
    return m_adaptive->CountsTexture();
}

passes::AccumulatedIds SampleFrames::Resolve(const passes::Accumulation& accumulation, Extent2D extent,
                                             bool withVariance, const std::optional<TextureId>& counts) {
    if (counts) return passes::Resolve(m_renderer, accumulation, *counts, extent, withVariance);
    return passes::Resolve(m_renderer, accumulation, extent, withVariance);
}

}  // namespace raygraph::session

#include "editor/viewport/raster_view.h"

#include "passes/overlay.h"

namespace raygraph::viewport {

RasterView::RasterView(const std::string& name)
    : m_name(name),
      m_samples(name + ".raster"),
      m_coarse(name + ".raster/coarse"),
      m_environment(name + ".environment") {}

RasterView::Ids RasterView::Declare(Renderer& renderer, const SceneIds& scene, passes::TraceSettings settings,
                                    const passes::RasterSettings& raster, uint32_t maxSamples,
                                    uint32_t scale) {
    const Extent2D extent = settings.extent;
    const auto declareSample = [&](uint32_t sampleIndex) {
        settings.sampleIndex = sampleIndex;
        return passes::AnyRasterShade(renderer, scene, settings, passes::FilmPosition::Jittered,
                                      m_environment, raster);
    };
    const uint32_t count = m_samples.SampleCount();
    m_targetSamples = maxSamples;
    Ids ids;
    const PassId firstDrawing = renderer.NextPass();
    PassId endDrawing = firstDrawing;
    if (count > 0 && ((maxSamples > 0 && count >= maxSamples) || scale > 1)) {
        const passes::AccumulatedIds kept = passes::StoredAccumulation(renderer, m_samples, extent, true);
        ids = {.radiance = kept.mean, .samples = kept, .base = kept.mean};
    } else if (scale > 1) {
        settings.extent = {(extent.width + scale - 1) / scale, (extent.height + scale - 1) / scale};
        const TextureId sample = declareSample(m_coarse.SampleCount());
        ids.base = passes::Accumulate(renderer, sample, m_coarse).mean;
        endDrawing = renderer.NextPass();
        ids.baseScale = scale;
        ids.radiance = passes::Upscale(renderer, ids.base, extent);
        ids.samples = passes::StoredAccumulation(renderer, m_samples, extent, true);
    } else {
        const TextureId sample = declareSample(count);
        const passes::AccumulatedIds sums = passes::Accumulate(renderer, sample, m_samples, true);
        endDrawing = renderer.NextPass();
        ids = {.radiance = sums.mean, .samples = sums, .base = sums.mean};
    }
    ids.firstDrawing = firstDrawing;
    ids.endDrawing = endDrawing;
    return ids;
}

void RasterView::ReleaseEnvironment(Renderer& renderer) {
    renderer.Release(m_name + ".environment");
    m_environment = passes::FilteredEnvironment(m_name + ".environment");
}

void RasterView::Release(Renderer& renderer) {
    passes::Release(renderer, m_samples);
    passes::Release(renderer, m_coarse);
    renderer.Release(m_name + ".environment");
}

}  // namespace raygraph::viewport

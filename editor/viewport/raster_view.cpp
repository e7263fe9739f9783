#include "editor/viewport/raster_view.h"

namespace raygraph::viewport {

RasterView::RasterView(const std::string& name)
    : m_name(name), m_samples(name + ".raster"), m_environment(name + ".environment") {}

passes::RasterVisibility DeclareVisibility(Renderer& renderer, const SceneIds& scene,
                                           const passes::TraceSettings& settings, passes::FilmPosition film) {
    if (renderer.Device().Info().optional.drawIndirectFirstInstance)
        return passes::DrawVisibility(renderer, scene, settings, film);
    return passes::TraceVisibility(renderer, scene, settings, film);
}

passes::AccumulatedIds RasterView::Declare(Renderer& renderer, const SceneIds& scene,
                                           passes::TraceSettings settings, uint32_t maxSamples) {
    const uint32_t count = m_samples.SampleCount();
    if (count > 0 && maxSamples > 0 && count >= maxSamples) {
        const GraphTextureDesc desc{settings.extent, Format::Rgba32Float};
        return {renderer.Persist(m_samples.Name() + ".mean", desc),
                renderer.Persist(m_samples.Name() + ".variance", desc)};
    }
    settings.sampleIndex = count;
    const passes::RasterVisibility seen =
        DeclareVisibility(renderer, scene, settings, passes::FilmPosition::Jittered);
    const TextureId radiance = passes::RasterShade(renderer, scene, settings, seen, m_environment);
    return passes::Accumulate(renderer, radiance, m_samples, true);
}

void RasterView::ForgetEnvironment(Renderer& renderer) {
    renderer.Forget(m_name + ".environment");
    m_environment = passes::FilteredEnvironment(m_name + ".environment");
}

void RasterView::Forget(Renderer& renderer) {
    renderer.Forget(m_samples.Name() + ".mean");
    renderer.Forget(m_samples.Name() + ".variance");
    renderer.Forget(m_name + ".environment");
}

}  // namespace raygraph::viewport

#include "editor/viewport/outline_view.h"

#include "editor/viewport/raster_view.h"
#include "passes/overlay.h"

namespace raygraph::viewport {

namespace {

constexpr uint32_t kCoarse = 4;  // in pixels per texel along an edge, while something moves

}  // namespace

void OutlineView::SetInstances(std::vector<uint32_t> instances) {
    if (instances == m_instances) return;
    m_instances = std::move(instances);
    ++m_selection;
}

TextureId OutlineView::Declare(Renderer& renderer, const SceneIds& scene, const SceneRevisions& revisions,
                               const scene::CameraView& camera, passes::TraceSettings settings,
                               const OutlineSettings& look, bool isMoving, TextureId picture) {
    const Extent2D extent = settings.extent;
    TextureId line = renderer.Persist(m_name, {extent, Format::R32Float});
    Key now{revisions, camera, extent, look.width, m_selection};
    // No outline depends on lights and environment; without alpha, none depends on materials either
    now.revisions.lights = now.revisions.environment = 0;
    if (!scene.features.Has(kTraceAnyHit)) now.revisions.materials = 0;
    const bool isCurrent = m_made && m_made->key == now && (!m_made->isCoarse || isMoving);
    if (!isCurrent || renderer.IsFresh(line)) {
        if (isMoving)
            settings.extent = {(extent.width + kCoarse - 1) / kCoarse,
                               (extent.height + kCoarse - 1) / kCoarse};
        settings.sampleIndex = 0;
        const TextureId hits =
            passes::AnyVisibility(renderer, scene, settings, passes::FilmPosition::Center).hits;
        line = passes::OutlineInstances(renderer, hits, m_instances, line, look.width, [this, now, isMoving] {
            m_made = {now, isMoving};
        });
    }
    return passes::DrawOutline(renderer, picture, line, look.color);
}

}  // namespace raygraph::viewport

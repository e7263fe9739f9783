#include "passes/preview.h"

#include "passes/scene_bindings.h"

namespace raygraph::passes {

TextureId Preview(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, float gain) {
    const PrimaryHitIds hits = PrimaryHits(renderer, scene, settings, FilmPosition::Center);
    const Extent2D extent = renderer.Desc(hits.albedo).extent;
    TextureId preview = renderer.CreateTexture("preview", {extent, Format::Rgba32Float});
    renderer.AddPass(
        "Preview", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/preview.comp");
            pass.Reads("albedo", hits.albedo);
            pass.Reads("normal", hits.normal);
            pass.Constants(glm::vec4(settings.camera.forward, gain));
            preview = pass.Writes("preview", preview);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return preview;
}

}  // namespace raygraph::passes

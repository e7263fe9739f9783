#include "passes/occlusion.h"

#include "passes/raster_bindings.h"
#include "passes/scene_bindings.h"

namespace raygraph::passes {

TextureId Occlusion(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                    const RasterVisibility& seen) {
    TextureId share = renderer.CreateTexture("ambientVisibility", {settings.extent, Format::R32Float});
    renderer.AddPass(
        "Occlusion", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/occlusion.comp");
            pass.Uniform("parameters", RasterParameters(scene, settings));
            BindPixelSurfaces(pass, scene, seen, {});
            pass.Reads("depths", seen.depth,
                       {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            share = pass.Writes("ambientVisibility", share);
        },
        [extent = settings.extent](CommandList& commands) { commands.DispatchOver(extent); });
    return share;
}

}  // namespace raygraph::passes

#include "passes/tonemap.h"

namespace raygraph::passes {

TextureId Tonemap(Renderer& renderer, TextureId radiance, const TonemapSettings& settings) {
    const Extent2D extent = renderer.Desc(radiance).extent;
    TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    struct Constants {
        float exposureEv;
        uint32_t tonemapOperator;
    };
    renderer.AddPass(
        "Tonemap", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/tonemap.comp");
            pass.Reads("radiance", radiance,
                       {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
            pass.Constants(Constants{settings.exposureEv, static_cast<uint32_t>(settings.tonemapOperator)});
            display = pass.Writes("display", display);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return display;
}

}  // namespace raygraph::passes

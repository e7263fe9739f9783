#include "passes/see_through.h"

#include "passes/raster_bindings.h"
#include "shaders/shared/blur_levels.h"

namespace raygraph::passes {

RasterVisibility DrawBehindGlass(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                                 const RasterVisibility& seen) {
    RasterVisibility behind = seen;
    behind.hits = renderer.CreateTexture("behindVisibility", renderer.Desc(seen.hits));
    behind.depth = DepthTexture(renderer, "behindDepth", settings.extent, seen.rasterizer);
    DrawHits(renderer, scene, settings, behind, GlassDrawn::No);
    return behind;
}

TextureId BlurLevels(Renderer& renderer, TextureId picture) {
    const Extent2D size = renderer.Desc(picture).extent;
    const Extent2D extent{gpu::BlurSize(size.width, 1), gpu::BlurRow(size.height, gpu::kBlurLevels + 1)};
    TextureId levels = renderer.CreateTexture("blurLevels", {extent, Format::Rgba32Float});
    renderer.AddPass(
        "BlurLevels", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/blur_levels.comp");
            pass.Reads(
                "picture", picture,
                {.addressU = rhi::AddressMode::ClampToEdge, .addressV = rhi::AddressMode::ClampToEdge});
            levels = pass.Writes("levels", levels);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return levels;
}

}  // namespace raygraph::passes

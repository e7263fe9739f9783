#include "passes/overlay.h"

namespace raygraph::passes {

namespace {

TextureId Compose(Renderer& renderer, const char* name, TextureId coarse, TextureId fine, Extent2D extent,
                  const TileCursor& done) {
    TextureId picture = renderer.CreateTexture("overlay", {extent, Format::Rgba32Float});
    struct Constants {
        uint32_t x, y, bandHeight;
    };
    renderer.AddPass(
        name, PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/overlay.comp");
            pass.Reads("coarse", coarse);
            pass.Reads("fine", fine);
            pass.Constants(Constants{done.X(), done.Y(), done.BandHeight()});
            picture = pass.Writes("picture", picture);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return picture;
}

}  // namespace

TextureId Overlay(Renderer& renderer, TextureId coarse, TextureId fine, const TileCursor& done) {
    return Compose(renderer, "Overlay", coarse, fine, renderer.Desc(fine).extent, done);
}

TextureId Upscale(Renderer& renderer, TextureId coarse, Extent2D extent) {
    return Compose(renderer, "Upscale", coarse, coarse, extent, {});
}

}  // namespace raygraph::passes

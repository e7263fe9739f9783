#include "sharpen.h"

using namespace raygraph;

TextureId Sharpen(Renderer& renderer, TextureId picture, float amount) {
    const Extent2D extent = renderer.Desc(picture).extent;
    TextureId sharpened = renderer.CreateTexture("sharpened", {extent, Format::Rgba32Float});
    renderer.AddPass(
        "Sharpen", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("sharpen.comp");
            pass.Reads("picture", picture);
            pass.Constants(amount);                           // the whole block; sizes must agree
            sharpened = pass.Writes("sharpened", sharpened);  // a write gives a new id: return that one
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return sharpened;
}

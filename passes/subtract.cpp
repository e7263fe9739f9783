#include "passes/subtract.h"

#include "base/text.h"

namespace raygraph::passes {

TextureId Subtract(Renderer& renderer, TextureId whole, TextureId part) {
    const GraphTextureDesc desc = renderer.Desc(whole), other = renderer.Desc(part);
    if (!(desc.extent == other.extent))
        throw MakeError(ErrorKind::Usage, "Subtract: a picture of {}x{} from one of {}x{}",
                        other.extent.width, other.extent.height, desc.extent.width, desc.extent.height);
    TextureId difference = renderer.CreateTexture("difference", {desc.extent, Format::Rgba32Float});
    renderer.AddPass(
        "Subtract", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/subtract.comp");
            pass.Reads("whole", whole);
            pass.Reads("part", part);
            difference = pass.Writes("difference", difference);
        },
        [extent = desc.extent](CommandList& commands) { commands.DispatchOver(extent); });
    return difference;
}

}  // namespace raygraph::passes

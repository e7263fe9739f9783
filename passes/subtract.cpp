#include "passes/subtract.h"

#include "base/error.h"

namespace raygraph::passes {

TextureId Subtract(Renderer& renderer, TextureId whole, TextureId part) {
    const GraphTextureDesc desc = renderer.Desc(whole), other = renderer.Desc(part);
    if (!(desc.extent == other.extent))
        throw Error(ErrorKind::Usage, "Subtract: a picture of " + std::to_string(other.extent.width) + "x" +
                                          std::to_string(other.extent.height) + " from one of " +
                                          std::to_string(desc.extent.width) + "x" +
                                          std::to_string(desc.extent.height));
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

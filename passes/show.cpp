#include "passes/show.h"

#include "base/error.h"

namespace raygraph::passes {

TextureId Show(Renderer& renderer, TextureId picture, TextureId target) {
    const GraphTextureDesc desc = renderer.Desc(target), from = renderer.Desc(picture);
    if (!(from.extent == desc.extent))
        throw Error(ErrorKind::Usage, "Show: a picture of " + std::to_string(from.extent.width) + "x" +
                                          std::to_string(from.extent.height) + " in a texture of " +
                                          std::to_string(desc.extent.width) + "x" +
                                          std::to_string(desc.extent.height));
    const bool isEncoding = desc.format == Format::Rgba8Srgb || desc.format == Format::Bgra8Srgb;
    renderer.AddPass(
        "Show", PassKind::Raster,
        [&](PassBuilder& pass) {
            pass.Vertex("post/show.vert");
            pass.Fragment("post/show.frag");
            pass.Reads("picture", picture,
                       {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
            pass.Constants<uint32_t>(isEncoding ? 1u : 0u);
            target = pass.ColorTarget(0, target);
        },
        [](CommandList& commands) { commands.Draw(3); });
    return target;
}

}  // namespace raygraph::passes

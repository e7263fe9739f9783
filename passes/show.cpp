#include "passes/show.h"

namespace raygraph::passes {

TextureId Show(Renderer& renderer, TextureId picture, TextureId target, std::function<void()> onSubmitted) {
    const GraphTextureDesc desc = renderer.Desc(target);
    const bool isScaled = !(renderer.Desc(picture).extent == desc.extent);
    const rhi::Filter filter = isScaled ? rhi::Filter::Linear : rhi::Filter::Nearest;
    struct Constants {
        float size[2];
        uint32_t isEncoding;
    };
    const bool isEncoding = desc.format == Format::Rgba8Srgb || desc.format == Format::Bgra8Srgb;
    renderer.AddPass(
        "Show", PassKind::Raster,
        [&](PassBuilder& pass) {
            pass.Vertex("post/show.vert");
            pass.Fragment("post/show.frag");
            pass.Reads("picture", picture,
                       {.magFilter = filter,
                        .minFilter = filter,
                        .addressU = rhi::AddressMode::ClampToEdge,
                        .addressV = rhi::AddressMode::ClampToEdge});
            pass.Constants(
                Constants{{static_cast<float>(desc.extent.width), static_cast<float>(desc.extent.height)},
                          isEncoding ? 1u : 0u});
            target = pass.ColorTarget(0, target);
        },
        [onSubmitted = std::move(onSubmitted)](CommandList& commands) {
            commands.Draw(3);
            if (onSubmitted) commands.OnSubmitted(onSubmitted);
        });
    return target;
}

}  // namespace raygraph::passes

#include "passes/tonemap.h"

#include "passes/same_extent.h"

namespace raygraph::passes {

namespace {

// What stood in `display` outside of the region stays if it is `kept`.
TextureId TonemapTo(Renderer& renderer, TextureId radiance, TextureId display, bool isKept,
                    const Region& region, const TonemapSettings& settings,
                    std::function<void()> onSubmitted) {
    struct Constants {
        uint32_t offset[2], size[2];
        float exposureEv;
        uint32_t tonemapOperator;
    };
    renderer.AddPass(
        "Tonemap", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/tonemap.comp");
            pass.Reads("radiance", radiance,
                       {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
            pass.Constants(Constants{{region.x, region.y},
                                     {region.width, region.height},
                                     settings.exposureEv,
                                     static_cast<uint32_t>(settings.tonemapOperator)});
            display = isKept ? pass.Updates("display", display) : pass.Writes("display", display);
        },
        [extent = region.Extent(), onSubmitted = std::move(onSubmitted)](CommandList& commands) {
            commands.DispatchOver(extent);
            if (onSubmitted) commands.OnSubmitted(onSubmitted);
        });
    return display;
}

}  // namespace

TextureId Tonemap(Renderer& renderer, TextureId radiance, const TonemapSettings& settings) {
    const Extent2D extent = renderer.Desc(radiance).extent;
    const TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    return TonemapTo(renderer, radiance, display, false, WholeOf(extent), settings, {});
}

TextureId TonemapInto(Renderer& renderer, TextureId radiance, TextureId display, const Region& region,
                      const TonemapSettings& settings, std::function<void()> onSubmitted) {
    const GraphTextureDesc from = renderer.Desc(radiance), to = renderer.Desc(display);
    RequireWithin(to.extent, region);
    if (!(from.extent == to.extent) || to.format != Format::Rgba8Unorm)
        throw Error(ErrorKind::Usage, "Tonemap: a picture of " + std::to_string(from.extent.width) + "x" +
                                          std::to_string(from.extent.height) + " into " +
                                          rhi::Name(to.format) + " of " + std::to_string(to.extent.width) +
                                          "x" + std::to_string(to.extent.height));
    const bool isKept = !(region == WholeOf(to.extent));
    return TonemapTo(renderer, radiance, display, isKept, region, settings, std::move(onSubmitted));
}

}  // namespace raygraph::passes

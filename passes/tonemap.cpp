#include "passes/tonemap.h"

#include <string>

#include "base/text.h"

namespace raygraph::passes {

namespace {

// The flags of shaders/post/tonemap.comp.
constexpr uint32_t kOpaque = 1, kUnassociated = 2, kBalanced = 4;

// The contents of `display` outside of the region stay if it is `kept`.
TextureId TonemapTo(Renderer& renderer, TextureId radiance, TextureId display, bool isKept,
                    const Region& region, const TonemapSettings& settings,
                    std::function<void()> onSubmitted) {
    struct Constants {
        uint32_t offset[2], size[2];
        float exposureEv;
        uint32_t tonemapOperator;
        uint32_t flags;
        glm::vec4 whiteBalance[3];  // columns
    };
    const glm::mat3& balance = settings.whiteBalance;
    uint32_t flags = settings.isOpaque ? kOpaque : 0u;
    if (settings.isUnassociated) flags |= kUnassociated;
    if (balance != glm::mat3(1.0f)) flags |= kBalanced;
    renderer.AddPass(
        "Tonemap", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/tonemap.comp");
            pass.Reads("radiance", radiance,
                       {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
            pass.Constants(Constants{
                {region.x, region.y},
                {region.width, region.height},
                settings.exposureEv,
                static_cast<uint32_t>(settings.tonemapOperator),
                flags,
                {glm::vec4(balance[0], 0.0f), glm::vec4(balance[1], 0.0f), glm::vec4(balance[2], 0.0f)}});
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
    const GraphTextureDesc to = renderer.Desc(display);
    RequireWithin(to.extent, region);
    if (to.format != Format::Rgba8Unorm)
        throw MakeError(ErrorKind::Usage, "Tonemap: into {}, must be {}", rhi::Name(to.format),
                        rhi::Name(Format::Rgba8Unorm));
    const bool isKept = !(region == WholeOf(to.extent));
    return TonemapTo(renderer, radiance, display, isKept, region, settings, std::move(onSubmitted));
}

}  // namespace raygraph::passes

#include "editor/session/denoise.h"

#include <algorithm>
#include <span>

#include "base/text.h"
#include "editor/session/file/render_file_parts.h"
#include "editor/session/oidn.h"
#include "editor/session/settings/parse.h"
#include "passes/denoise_network.h"
#include "passes/pixel_list.h"
#include "renderer/graph/readback_values.h"
#include "renderer/graph/renderer.h"

namespace raygraph::session {

std::string NotDenoisableReason(const RenderFile& render) {
    if (std::string flaw = FirstFlaw(render); !flaw.empty()) return flaw;
    if (const View view = SettingsFrom(render.settings).view; view != View::PathTraced)
        return std::string("it shows the view ") + Name(view);
    if (render.adaptive) return "it is adaptive, and its pixels have different numbers of samples";
    if (render.variance.empty()) return "it has no channel variance.R";
    if (render.denoising.albedo.empty() && (render.albedo.empty() || render.normal.empty()))
        return "it has neither the channels of --aov denoising nor those of --aov albedo,normal. Render it "
               "again with --aov denoising";
    return {};
}

void WarnIfTooLarge(const rhi::DeviceInfo& device, Extent2D extent, passes::Denoiser denoiser,
                    const Log& log) {
    if (denoiser == passes::Denoiser::Network && !passes::FitsNetwork(device, extent))
        WriteLog(log, LogLevel::Warning, log_category::kScene,
                 "{} pixels are too many for the denoiser's network on {}; the regression is used instead",
                 ToText(extent), device.name);
}

image::Image8 Denoise(rhi::Device& device, RenderFile& render, const passes::TonemapSettings& tonemap,
                      FileDenoiser denoiser) {
    if (const std::string why = NotDenoisableReason(render); !why.empty())
        throw MakeError(ErrorKind::BadInput, "the render cannot be denoised: {}", why);
    const uint32_t most = device.Info().maxTextureExtent;
    if (std::max(render.size.width, render.size.height) > most)
        throw MakeError(ErrorKind::BadInput, "{} pixels are more than a texture of the device has, {}x{}",
                        ToText(render.size), most, most);
    if (denoiser != FileDenoiser::Oidn)
        WarnIfTooLarge(device.Info(), render.size, static_cast<passes::Denoiser>(denoiser), device.Log());
    const Texels byOidn = denoiser == FileDenoiser::Oidn ? DenoiseByOidn(render) : Texels();
    Renderer renderer(device);
    renderer.BeginFrame();
    const auto upload = [&](const char* name, const Texels& texels) {
        return passes::UploadTexels(renderer, std::as_bytes(std::span(texels)),
                                    renderer.CreateTexture(name, {render.size, Format::Rgba32Float}));
    };
    const auto denoise = [&] {
        const DenoisingPlanes& planes = render.denoising;
        passes::DenoiseInputs inputs{
            .mean = upload("mean", render.radiance),
            .variance = upload("variance", render.variance),
            .albedo = upload("albedo", planes.albedo.empty() ? render.albedo : planes.albedo),
            .normal = upload("normal", planes.albedo.empty() ? render.normal : planes.normal),
            .firstHalf = {},
            .seen = {}};
        if (!planes.firstHalf.empty()) inputs.firstHalf = upload("firstHalf", planes.firstHalf);
        if (!planes.seen.empty())
            inputs.seen = {upload("seen", planes.seen), upload("seenByAll", planes.seenByAll),
                           upload("seenSquares", planes.seenSquares)};
        return passes::Denoise(renderer, inputs,
                               {static_cast<uint32_t>(SampleCount(render.samples)), planes.firstSamples,
                                static_cast<passes::Denoiser>(denoiser)});
    };
    const TextureId denoised = byOidn.empty() ? denoise() : upload("denoised", byOidn);
    const Readback result = renderer.ReadBack(denoised);
    const Readback shown = renderer.ReadBack(
        passes::Tonemap(renderer, denoised, WithAlphaOf(tonemap, SettingsFrom(render.settings))));
    renderer.Execute();
    render.denoised = WaitForValues<float>(result);
    return {render.size.width, render.size.height, WaitForValues<uint8_t>(shown)};
}

}  // namespace raygraph::session

// Denoises a render that was read from its file, without the scene. Threads: that of the device's Renderers.
#pragma once

#include <string>

#include "base/api.h"
#include "editor/session/file/render_file.h"
#include "passes/denoise.h"
#include "passes/tonemap.h"
#include "renderer/image/image.h"
#include "rhi/device.h"

namespace raygraph::session {

// Returns `tonemap` with the alpha that a picture with these settings has on a display: opaque, unless its
// environment is hidden.
inline passes::TonemapSettings WithAlphaOf(passes::TonemapSettings tonemap, const PictureSettings& settings) {
    tonemap.isUnassociated = settings.paths.isEnvironmentHidden;
    tonemap.isOpaque = !tonemap.isUnassociated;
    return tonemap;
}

// Returns why the render cannot be denoised; "" for a path-traced render with variance that is not adaptive,
// if it has Aov::Denoising, or else Aov::Albedo and Aov::Normal, which tell less: all samples count as
// independent, and edges of lights stay as they are. The picture may be cropped, merged or of half floats.
RAYGRAPH_API std::string NotDenoisableReason(const RenderFile& render);

// A file is denoised by one of the denoisers of passes, which keep their numbers, or by a library.
#define RAYGRAPH_FILE_DENOISERS(X, Of) \
    RAYGRAPH_DENOISERS(X, Of)          \
    X(Of, Oidn, 2, "oidn", "Intel Open Image Denoise on the CPU, if installed")
RAYGRAPH_CHOICE(FileDenoiser, RAYGRAPH_FILE_DENOISERS)

// Warns if a picture is too large for Denoiser::Network on the device, and is denoised by the regression.
RAYGRAPH_API void WarnIfTooLarge(const rhi::DeviceInfo& device, Extent2D extent, passes::Denoiser denoiser,
                                 const Log& log);

// Sets the denoised radiance, which with Aov::Denoising is that of SessionDesc::isDenoised to the bit, unless
// the file is of half floats or was merged, or the denoiser is Oidn (oidn.h). Returns it as Session::Display
// does. Throws Error{BadInput} for what cannot be denoised, for a picture that is larger than the device's
// textures, and where Oidn fails.
RAYGRAPH_API image::Image8 Denoise(rhi::Device& device, RenderFile& render,
                                   const passes::TonemapSettings& tonemap = {},
                                   FileDenoiser denoiser = FileDenoiser::Network);

}  // namespace raygraph::session

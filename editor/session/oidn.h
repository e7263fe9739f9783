// Intel's Open Image Denoise (openimagedenoise.org), a yardstick for passes::Denoise. The library is loaded
// when it is used, and nothing of it is needed to build. Threads: any.
#pragma once

#include "editor/session/file/render_file.h"

namespace raygraph::session {

// Returns the radiance as the library's filter for path-traced pictures denoises it on the CPU, by albedo and
// normal at the first hit, all of them of the render's size; alpha is kept. Guides of Aov::Denoising count as
// free of noise. Throws Error{BadInput} if the library cannot be loaded, lacks a function, or says that it
// failed.
Texels DenoiseByOidn(const RenderFile& render);

}  // namespace raygraph::session

// Preview: a picture of the scene's surfaces that needs a small program only. Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "passes/trace.h"

namespace raygraph::passes {

// The base colors of what the camera sees, lit from the camera, times `gain`; dark gray where it sees no
// surface. rgba32f of the settings' region. No light, no shadow and no refraction is in it; its programs
// depend on whether the scene has alpha tests and round primitives, and on the sampler, on nothing else. For
// a viewport that has nothing better yet.
[[nodiscard]] RAYGRAPH_API TextureId Preview(Renderer& renderer, const SceneIds& scene,
                                             const TraceSettings& settings, float gain = 1.0f);

}  // namespace raygraph::passes

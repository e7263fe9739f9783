// FilterEnvironment: the environment map, prefiltered for rough surfaces, for raster views. Threads: that of
// the Renderer.
#pragma once

#include <string>

#include "base/api.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// Holds the state of the filtered map between frames. One object per GpuScene and Renderer; `name` keys the
// persistent texture.
class RAYGRAPH_API FilteredEnvironment {
  public:
    explicit FilteredEnvironment(std::string name) : m_name(std::move(name)) {}
    const std::string& Name() const { return m_name; }

  private:
    friend TextureId FilterEnvironment(Renderer& renderer, const SceneIds& scene, FilteredEnvironment& state);
    std::string m_name;
    uint64_t m_version = 0;  // SceneIds::environmentVersion of what the texture holds
};

// Returns the levels of shaders/shared/light_records.h, rgba32f, without the scene's factor and
// rotation: the work is done once for each map. Without a map there is nothing to filter, and the texture is
// undefined. `state` outlives the frame.
[[nodiscard]] RAYGRAPH_API TextureId FilterEnvironment(Renderer& renderer, const SceneIds& scene,
                                                       FilteredEnvironment& state);

}  // namespace raygraph::passes

// The backdrop: what a picture shows behind the scene, whose environment is hidden (PathSettings). It is no
// light. Tonemap puts it where alpha is below 1. Threads: that of the Renderer; settings: plain values.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "base/api.h"
#include "passes/tiles.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

struct BackdropSettings {
    // Linear, 0 to 1: shown as it is, whatever exposure and tone curve are. None: the environment.
    std::optional<glm::vec3> color = {};
    float blurDegrees = 0.0f;  // of the environment, at most 90; 0: as it is

    bool operator==(const BackdropSettings&) const = default;
};

// Holds the blurred map between frames. One object per Renderer and picture; `name` keys the persistent
// texture.
class RAYGRAPH_API BlurredEnvironment {
  public:
    explicit BlurredEnvironment(std::string name) : m_name(std::move(name)) {}
    // Returns the scene's environment map blurred, rgba32f, without its factor and rotation: a texel is the
    // mean of the radiance around it, weighted by exp(-a^2 / 2s^2) of the angle a, where s is `degrees`,
    // above 0 and at most 90. Without a map it returns SceneIds::environmentMap. The work is done once for
    // each map and angle.
    [[nodiscard]] TextureId Declare(Renderer& renderer, const SceneIds& scene, float degrees);
    void Release(Renderer& renderer) { renderer.Release(m_name); }

  private:
    std::string m_name;
    uint64_t m_version = 0;  // SceneIds::environmentVersion of what the texture holds
    float m_degrees = 0.0f;
};

// The backdrop of a frame, as Tonemap takes it.
struct Backdrop {
    BackdropSettings settings;
    TextureId map;  // equirectangular, rgba32f
    gpu::EnvironmentRecord environment{};
    gpu::CameraRecord camera{};
    Extent2D picture;  // the size of the camera's picture
    Region part{};     // of it, which the display shows
};

[[nodiscard]] RAYGRAPH_API Backdrop DeclareBackdrop(Renderer& renderer, const SceneIds& scene,
                                                    const BackdropSettings& settings,
                                                    BlurredEnvironment& blurred,
                                                    const gpu::CameraRecord& camera, Extent2D picture,
                                                    const Region& part);

}  // namespace raygraph::passes

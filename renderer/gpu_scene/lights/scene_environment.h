// The environment of a GpuScene: what the host set, what the scene brings along, or the studio. Threads: that
// of the Renderer.
#pragma once

#include <cstdint>
#include <optional>
#include <set>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/lights/environment_upload.h"
#include "rhi/upload.h"

namespace raygraph {

class LightSet;

// The sources of light that keep DefaultLight::Auto from showing the studio.
struct LightSources {
    bool isScene = false;
    std::set<uint32_t> parts;              // owners of parts that bring light
    std::set<uint32_t> instances, lights;  // those of emitting host meshes; those of AddLight

    bool IsAny() const { return isScene || !parts.empty() || !instances.empty() || !lights.empty(); }
};

class SceneEnvironment {
  public:
    SceneEnvironment(rhi::Device& device, rhi::Uploader& uploader);

    // These do what GpuScene's calls of their names say. They return false if nothing has changed.
    bool Set(const EnvironmentSettings& settings);
    void SetMap(const image::ImageF& equirectangular);
    bool RemoveMap();
    const EnvironmentSettings& Settings() const { return m_settings; }
    // With the default light that is shown; never Auto.
    EnvironmentSettings Shown() const;

    // Another scene's map, and whether that scene has light of its own.
    void SetScene(std::optional<EnvironmentOnDevice>&& map, bool hasOwnLight);
    LightSources& Sources() { return m_sources; }

    // Sets the environment's ids, and what `lights` samples of it.
    void Declare(Renderer& renderer, SceneIds& ids, LightSet& lights);

  private:
    DefaultLight ShownDefault() const;

    rhi::Device& m_device;
    rhi::Uploader& m_uploader;
    EnvironmentSettings m_settings{.radiance = glm::vec3(1.0f), .usesScene = true};
    std::optional<EnvironmentOnDevice> m_ofHost, m_ofScene;
    std::optional<EnvironmentOnDevice> m_studio;  // made by the first frame that shows it
    bool m_hadStudio = false;                     // the last frame showed it
    EnvironmentOnDevice m_blank;                  // for an environment without a map
    uint64_t m_version = 0;                       // of the map that is shown
    LightSources m_sources;
};

}  // namespace raygraph

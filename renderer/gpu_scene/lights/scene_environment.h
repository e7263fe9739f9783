// The environment of a GpuScene: the one that the host has set, that of the scene, or the studio. Threads:
// that of the Renderer.
#pragma once

#include <cstdint>
#include <optional>
#include <set>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/lights/environment_upload.h"
#include "rhi/upload.h"

namespace raygraph {

class LightSet;

// The light sources that keep DefaultLight::Auto from showing the studio.
struct LightSources {
    bool isScene = false;
    std::set<uint32_t> parts;              // owners of parts with light
    std::set<uint32_t> instances, lights;  // those of emitting host meshes; those of AddLight

    bool IsAny() const { return isScene || !parts.empty() || !instances.empty() || !lights.empty(); }
};

class SceneEnvironment {
  public:
    SceneEnvironment(rhi::Device& device, rhi::Uploader& uploader);

    // The setters do what GpuScene's calls of the same names say. They return false if nothing has changed.
    bool Set(const EnvironmentSettings& settings);
    void SetMap(const image::ImageF& equirectangular);
    bool RemoveMap();
    const EnvironmentSettings& Settings() const { return m_settings; }
    // Returns the settings with the default light that is shown, never Auto.
    EnvironmentSettings Shown() const;

    // Sets the map of another scene, and whether that scene lights itself.
    void SetScene(std::optional<EnvironmentOnDevice>&& map, bool hasOwnLight);
    LightSources& Sources() { return m_sources; }

    // Sets the environment's ids, and the environment that `lights` samples.
    void Declare(Renderer& renderer, SceneIds& ids, LightSet& lights);

  private:
    DefaultLight ShownDefault() const;

    rhi::Device& m_device;
    rhi::Uploader& m_uploader;
    EnvironmentSettings m_settings{.radiance = glm::vec3(1.0f), .usesScene = true};
    std::optional<EnvironmentOnDevice> m_ofHost, m_ofScene;
    std::optional<EnvironmentOnDevice> m_studio;  // created by the first frame that shows it
    bool m_hadStudio = false;                     // the last frame showed it
    EnvironmentOnDevice m_blank;                  // for an environment without a map
    uint64_t m_version = 0;                       // version of the map that is shown
    LightSources m_sources;
};

}  // namespace raygraph

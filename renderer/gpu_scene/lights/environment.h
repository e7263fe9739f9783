// The environment of a scene: the table over the cells of its equirectangular map, from which directions are
// sampled by inversion; map and table on the device; and the choice between the environment that the host
// has set, that of the scene, and the studio. Threads: the functions of the table are pure; uploads: that of
// the Uploader; SceneEnvironment: that of the Renderer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <numbers>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/access.h"
#include "renderer/image/image.h"
#include "rhi/device.h"
#include "rhi/transfer.h"
#include "shaders/shared/light_records.h"

namespace raygraph {

struct EnvironmentTable {
    uint32_t width = 1, height = 1;  // cells
    // The marginal entries of the rows, then the cells of each row.
    std::vector<gpu::EnvironmentEntry> entries;
    glm::vec3 meanRadiance{1.0f};  // mean of the map over the sphere, linear Rec. 709
    // Irradiance of the map on a surface that faces +y; that of a map of ones by default.
    glm::vec3 skyIrradiance{std::numbers::pi_v<float>};
};

inline constexpr uint64_t kMaxEnvironmentCells = uint64_t{1} << 22;

// Throws Error{Usage} for a map without texels, or with values that are negative or not finite.
void RequireRadiance(const image::ImageF& map);

// Builds the table of a map. A cell is a texel, or a square of 2^k x 2^k texels where the map is larger than
// `maxCells` and its size allows. Its weight is the luminance of its texels above half of the map's mean,
// times solid angle, of the map as a sampler interpolates it (bilinear, repeated in u, clamped in v). Hence
// directions to the dim part of a map have no density: BSDF sampling finds them anyway (Karlik et al. 2019,
// "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling"). Values of the map are
// finite and not negative. Takes linear time and needs no device.
EnvironmentTable BuildEnvironmentTable(const image::ImageF& map, uint64_t maxCells = kMaxEnvironmentCells);

// Returns the table of an environment without a map: one cell, uniform over all directions.
EnvironmentTable ConstantEnvironmentTable();

// --- Map and table on the device; textures of one color ---

// Returns a texture of one white texel, for unused texture slots.
rhi::Texture WhiteTexture(rhi::Device& device, rhi::Uploader& uploader);

// Holds a map, and the table from which directions to it are sampled.
struct EnvironmentOnDevice {
    rhi::Texture map;
    ResourceState mapState{.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    rhi::Buffer table;
    ResourceState tableState;
    glm::uvec2 cells{1};
    glm::vec3 meanRadiance{1.0f};  // these two as in EnvironmentTable
    glm::vec3 skyIrradiance{std::numbers::pi_v<float>};
};

// Uploads a map and its table, which are complete once the uploader's work is done. Throws Error{OutOfMemory}
// if the device cannot bind a table of that many entries, or has no memory for it.
EnvironmentOnDevice UploadEnvironment(rhi::Device& device, rhi::Uploader& uploader, const image::ImageF& map);
// Returns one black texel, for an environment without a map.
EnvironmentOnDevice BlankEnvironment(rhi::Device& device, rhi::Uploader& uploader);

// --- The environment of a GpuScene: that of the host, that of the scene, or the studio ---

class LightSet;

// Holds the light sources that keep DefaultLight::Auto from showing the studio.
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

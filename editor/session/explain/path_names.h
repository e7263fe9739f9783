// PathNames: what the objects are called that an explained path meets. Threads: plain values; constant calls
// from any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/api.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/path_record.h"

namespace raygraph::session {

// Returns what a light without a name is called: "point light 3".
RAYGRAPH_API std::string NameOfUnnamed(const scene::Light& light, size_t index);

class RAYGRAPH_API PathNames {
  public:
    PathNames() = default;
    // Takes the names of a scene before the device consumes it; an outline (scene::PoseOutline) will do.
    explicit PathNames(const scene::SceneData& scene);
    // Takes from a frame how the lights are numbered. Lights have no names before that.
    void NumberLights(const gpu::LightSetRecord& lights) { m_lights = lights; }

    // These return names in quotes, or the kind and the index of what has none: "instance 3".
    std::string Instance(uint32_t instance) const;
    std::string Material(uint32_t material) const;
    // The light of a candidate that has one.
    std::string Light(const gpu::LightCandidateRecord& candidate) const;
    // Names what emits the light that the ray to a vertex found.
    std::string Emitter(const gpu::PathVertexRecord& vertex) const;

  private:
    std::string Emitter(uint32_t instance, uint32_t material) const;

    std::vector<std::string> m_instances, m_materials;
    // Names of punctual lights by their numbers on the device, from the first bounded one on.
    std::vector<std::string> m_bounded, m_directional;
    gpu::LightSetRecord m_lights{};
};

}  // namespace raygraph::session

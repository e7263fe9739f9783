// SceneCopy: what the path tracer reads of a scene, copied back from its device, so that the integrator runs
// on the host with the inputs of the device (trace.h). Threads: constant calls from any thread; CopyScene:
// that of the Renderer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <vector>

#include "renderer/bvh/binary_bvh.h"
#include "renderer/bvh/wide_scene.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/light_records.h"
#include "shaders/shared/scene_records.h"

namespace raygraph::session {

// Copies of ranges of device memory, by their addresses there.
class CopiedMemory {
  public:
    void Add(uint64_t address, std::vector<std::byte> bytes);
    // Returns the copy of `count` values at an address, of which each has a size of a multiple of 4 bytes.
    // Throws Error{BadInput} for what is not in one range, which is a fault of the shaders or of the scene's
    // tables.
    template <typename T>
    std::span<const T> At(uint64_t address, uint64_t count = 1) const {
        return {reinterpret_cast<const T*>(Find(address, count, sizeof(T))), count};
    }

  private:
    const std::byte* Find(uint64_t address, uint64_t count, uint64_t size) const;

    std::map<uint64_t, std::vector<std::byte>> m_ranges;  // by their first addresses
};

// A texture with its sampler, as shaders read it.
class CopiedTexture {
  public:
    struct Level {
        Extent2D extent;
        std::vector<glm::vec4> texels;  // linear, rows from the top
    };

    CopiedTexture() = default;
    CopiedTexture(const scene::Sampler& sampler, std::vector<Level> levels)
        : m_sampler(sampler), m_levels(std::move(levels)) {}

    Extent2D Extent() const { return m_levels.front().extent; }
    // Returns what textureLod does. Weights of texels are not rounded, as devices may, to 1/256.
    glm::vec4 Sample(const glm::vec2& uv, float lod) const;

  private:
    glm::vec4 SampleLevel(const Level& level, const glm::vec2& uv, scene::FilterMode filter) const;

    scene::Sampler m_sampler;
    std::vector<Level> m_levels;
};

// Round primitives of an instance, with a tree over them.
struct CopiedCapsules {
    uint32_t instance = 0;  // number of its InstanceRecord
    uint32_t flags = 0;     // gpu::kWideBackCulled, ...
    glm::mat4x3 toObject{1.0f};
    std::span<const gpu::CapsuleRecord> capsules;
    BinaryBvh tree;
};

struct SceneCopy {
    SceneIds ids;  // of the copied frame: their values count, the ids are of no use
    CopiedMemory memory;
    std::vector<gpu::InstanceRecord> instances;
    std::vector<gpu::GeometryRecord> geometries;
    std::vector<gpu::MaterialRecord> materials;
    std::vector<gpu::LightRecord> lights;
    std::vector<gpu::LightNode> lightNodes;
    std::vector<gpu::AliasEntry> lightAlias;
    std::vector<gpu::LightMeshRecord> lightMeshes;
    std::vector<float> lightProfiles;
    std::vector<gpu::EnvironmentEntry> environmentTable;
    std::vector<CopiedTexture> textures;  // by slot
    CopiedTexture environmentMap;
    WideScene trees;  // of two levels
    std::vector<CopiedCapsules> capsules;
};

// Copies the scene that `declare` declares in the open frame, the same each time, and builds trees over its
// primitives. Executes frames, and waits for them; `renderer` has none open. Throws Error{Usage} for trees
// that are deeper than the traversal's stack, or reach farther than 1e18.
SceneCopy CopyScene(Renderer& renderer, const GpuScene& scene, const std::function<SceneIds()>& declare);

}  // namespace raygraph::session

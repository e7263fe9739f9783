// SceneMemory: what a scene holds on the device beyond the tables of SceneIds, for who copies it back.
// Threads: plain values, valid until the scene changes.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/model/scene_data.h"
#include "rhi/resources.h"

namespace raygraph {

struct SceneMemory {
    // Describes a placed group that rays can hit.
    struct Placement {
        uint32_t record = 0;      // index of its gpu::InstanceRecord
        uint32_t primitives = 0;  // triangles, or capsules
        uint32_t flags = 0;       // gpu::kWideBackCulled, ...
    };
    struct Texture {
        uint32_t slot = 0;  // of the texture table
        const rhi::Texture* texture = nullptr;
        scene::Sampler sampler;
    };

    std::vector<Placement> placements;
    // All that addresses in instance and geometry records point to, but for the buffers of the host
    // (HostMesh). They have BufferUsage::CopySource.
    std::vector<const rhi::Buffer*> streams;
    std::vector<Texture> textures;
};

}  // namespace raygraph

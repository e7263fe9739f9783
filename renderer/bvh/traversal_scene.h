// Placed meshes on a device twice, as the driver's acceleration structures and as wide trees that a compute
// shader traverses, and passes that trace a buffer of rays by either: for measuring one against the other.
// Threads: that of the Renderer.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "base/api.h"
#include "renderer/bvh/wide_scene.h"
#include "renderer/graph/renderer.h"
#include "rhi/blas_builder.h"
#include "rhi/tlas.h"

namespace raygraph {

// The driver's structures.
class RAYGRAPH_API DriverScene {
  public:
    struct Ids {
        TlasId tlas;
        BlasSetId blases;
    };

    // Uploads and builds, and waits for it.
    DriverScene(rhi::Device& device, const BvhScene& scene);
    Ids Declare(Renderer& renderer);

  private:
    std::deque<rhi::Buffer> m_inputs;
    std::vector<std::shared_ptr<rhi::Blas>> m_blases;
    rhi::Tlas m_tlas;
    ResourceState m_tlasState, m_blasState;
};

// The wide trees.
class RAYGRAPH_API WideDeviceScene {
  public:
    struct Ids {
        BufferId nodes, triangles, instances;
    };

    WideDeviceScene(rhi::Device& device, const WideScene& scene);
    Ids Declare(Renderer& renderer);

  private:
    // Set while the buffers below are made
    ResourceState m_nodesState, m_trianglesState, m_instancesState;
    rhi::Buffer m_nodes, m_triangles, m_instances;
};

// `rays` holds `count` gpu::BenchRays; returns as many gpu::WideHits, of the nearest triangles. The passes
// have these names, and are never culled. `hasOneLevel`: the trees are of BuildOneLevel.
inline constexpr const char *kDriverPass = "TraceByDriver", *kSoftwarePass = "TraceBySoftware";
[[nodiscard]] RAYGRAPH_API BufferId TraceByDriver(Renderer& renderer, const DriverScene::Ids& scene,
                                                  BufferId rays, uint32_t count);
[[nodiscard]] RAYGRAPH_API BufferId TraceBySoftware(Renderer& renderer, const WideDeviceScene::Ids& scene,
                                                    BufferId rays, uint32_t count, bool hasOneLevel);

// A buffer on the device with these records, for Renderer::Import with `state`.
RAYGRAPH_API rhi::Buffer UploadRecords(rhi::Device& device, const char* name,
                                       std::span<const std::byte> bytes, ResourceState& state,
                                       rhi::BufferUsage more = rhi::BufferUsage::None);

}  // namespace raygraph

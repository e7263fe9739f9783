// Placed meshes on a device twice: as the driver's acceleration structures, and as wide trees that a
// compute shader traverses. For measuring one against the other. Threads: that of the Renderer.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "base/api.h"
#include "renderer/bvh/build_order.h"
#include "renderer/bvh/wide_scene.h"
#include "renderer/graph/renderer.h"
#include "rhi/blas_builder.h"
#include "rhi/tlas.h"

namespace raygraph {

// The driver's structures. Triangles and instances are given to it in this order.
class RAYGRAPH_API DriverScene {
  public:
    struct Ids {
        TlasId tlas;
        BlasSetId blases;
    };

    // Uploads and builds, and waits for it.
    DriverScene(rhi::Device& device, const BvhScene& scene, BuildOrder order);
    Ids Declare(Renderer& renderer);
    // Turns places of triangles into the numbers that they have in BvhScene.
    void NumberTriangles(std::span<gpu::WideHit> hits) const;
    double OrderSeconds() const { return m_orderSeconds; }
    uint64_t Bytes() const;

  private:
    std::vector<std::vector<uint32_t>> m_orders;  // by mesh
    std::vector<uint32_t> m_meshes;               // by instance
    std::deque<rhi::Buffer> m_inputs;
    std::vector<std::shared_ptr<rhi::Blas>> m_blases;
    rhi::Tlas m_tlas;
    ResourceState m_tlasState, m_blasState;
    double m_orderSeconds = 0.0;
};

// The wide trees.
class RAYGRAPH_API WideDeviceScene {
  public:
    struct Ids {
        BufferId nodes, triangles, instances;
    };

    WideDeviceScene(rhi::Device& device, const WideScene& scene);
    Ids Declare(Renderer& renderer);
    uint64_t Bytes() const { return m_nodes.Size() + m_triangles.Size() + m_instances.Size(); }

  private:
    // Set while the buffers below are made
    ResourceState m_nodesState, m_trianglesState, m_instancesState;
    rhi::Buffer m_nodes, m_triangles, m_instances;
};

// A buffer on the device with these records, for Renderer::Import with `state`.
RAYGRAPH_API rhi::Buffer UploadRecords(rhi::Device& device, const char* name,
                                       std::span<const std::byte> bytes, ResourceState& state,
                                       rhi::BufferUsage more = rhi::BufferUsage::None);

}  // namespace raygraph

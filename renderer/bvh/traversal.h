// The two ways of tracing rays, by the driver or by Raygraph's own shaders; which one is faster on a device;
// and scenes and passes that measure it. Threads: that of the device's Renderers.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "base/api.h"
#include "renderer/bvh/wide_scene.h"
#include "renderer/graph/renderer.h"
#include "rhi/blas_builder.h"
#include "rhi/tlas.h"
#include "shaders/shared/choice.h"

namespace raygraph {

namespace rhi {
class Device;
}

// The choice affects speed alone: hits are the same, but at edges.
//   Auto:     the faster one on the device (FasterTraversal)
//   Driver:   the device's acceleration structures, by the driver's traversal
//   Software: trees of triangles, by shaders (shaders/scene/software_traversal.glsl)
#define RAYGRAPH_TRAVERSALS(X, Of) \
    X(Of, Auto, 0, "auto", "")     \
    X(Of, Driver, 1, "driver", "") \
    X(Of, Software, 2, "software", "")
RAYGRAPH_CHOICE(Traversal, RAYGRAPH_TRAVERSALS)

// Returns Driver or Software, a property of the device and its driver, whatever the scene. On a CPU it is
// Software, which was faster wherever it was measured (docs/performance.md). On a GPU it is Software where
// its rays are at least a tenth faster than the driver's (MeasureSoftwareSpeed), which is measured once and
// remembered (rhi::Device::StoreMeasurement). Driver on a device without timestamps.
RAYGRAPH_API Traversal FasterTraversal(rhi::Device& device);

// Returns the speed of Software relative to Driver in rays a second, measured on a GPU: half a million
// incoherent rays through a terrain of 18,432 triangles, by kernels that do nothing else, in turns. 0 on a
// device without timestamps.
RAYGRAPH_API double MeasureSoftwareSpeed(rhi::Device& device);

// --- Scenes for measuring one against the other ---
// Placed meshes are on a device twice, as the driver's acceleration structures and as wide trees that a
// compute shader traverses, and passes trace a buffer of rays by either.

// DriverScene has the driver's structures.
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

// WideDeviceScene has the wide trees.
class RAYGRAPH_API WideDeviceScene {
  public:
    struct Ids {
        BufferId nodes, triangles, instances;
    };

    WideDeviceScene(rhi::Device& device, const WideScene& scene);
    Ids Declare(Renderer& renderer);

  private:
    // These are set while the buffers below are made
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

// Returns a buffer on the device with these records, for Renderer::Import with `state`.
RAYGRAPH_API rhi::Buffer UploadRecords(rhi::Device& device, const char* name,
                                       std::span<const std::byte> bytes, ResourceState& state,
                                       rhi::BufferUsage more = rhi::BufferUsage::None);

}  // namespace raygraph

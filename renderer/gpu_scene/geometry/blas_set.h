// BlasSet builds, refits, rebuilds in place and compacts the BLASes of a scene in its frames. Threads: that
// of the Renderer.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "rhi/blas_builder.h"

namespace raygraph {

class DeformSet;

class BlasSet {
  public:
    // All of them outlive the set; `geometry` has BLASes that wait to be built.
    BlasSet(rhi::BlasBuilder& builder, SceneGeometry& geometry, InstanceSet& instances)
        : m_builder(builder), m_geometry(geometry), m_instances(instances) {}

    // Must be called after BLASes have been added to the builder.
    void MarkUnbuilt() noexcept { m_unbuilt = true; }
    // Must be called after BLASes have been added to the builder that replace some in the TLAS.
    void MarkReplaced() noexcept {
        m_unbuilt = true;
        m_instances.MarkStructuresChanged();
    }
    // The vertices of a host's mesh have changed, under the host's BLAS or under one of ours. The TLAS
    // follows, and a BLAS of ours is rebuilt, in place if it is Deforming. On an Error nothing has changed.
    void MarkVerticesDirty(uint32_t mesh);
    void Forget(uint32_t mesh) noexcept { std::erase(m_rebuilt, mesh); }

    // Declares the work, which stays pending while it is culled or its frame is dropped.
    void Declare(Renderer& renderer, SceneIds& ids, DeformSet* deform);
    // Work on structures, the TLAS included, is culled in frames that do not read them. A frame that was
    // declared with such work and recorded none of it lets IsSettled ignore it from then on, until a frame
    // begins without pending work or records some, or until an edit is made: MarkUsed says so of these two.
    void BeginFrame() { m_structuresUsed = !HasWork(); }
    void MarkUsed() { m_structuresUsed = true; }
    bool IsSettled() const { return !(HasWork() && m_structuresUsed) && m_rebuilt.empty(); }

  private:
    bool HasWork() const { return m_unbuilt || m_instances.PendingWork() != TlasWork::None; }
    void DeclareRebuilds(Renderer& renderer, SceneIds& ids);

    rhi::BlasBuilder& m_builder;
    SceneGeometry& m_geometry;
    InstanceSet& m_instances;
    bool m_unbuilt = true;
    bool m_structuresUsed = true;
    std::vector<uint32_t> m_rebuilt;  // meshes of the host whose BLAS has to be rebuilt in place
};

}  // namespace raygraph

// BlasSet builds, refits, rebuilds in place and compacts the BLASes of a scene in its frames. RefitQuality
// measures when a deforming BLAS has to be rebuilt. Threads: BlasSet: that of the Renderer; RefitQuality: as
// std::vector.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
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
    void Unmark(uint32_t mesh) noexcept { std::erase(m_rebuilt, mesh); }

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

// RefitQuality measures how much a tree over triangles has decayed by refits. A deforming BLAS is rebuilt by
// this measure.
//
// The driver's tree cannot be inspected, so a tree over a sample of the triangles models it: a balanced one
// over their order along a space-filling curve. Its cost is the sum of the surface areas of its boxes, which
// is proportional to how many boxes a random ray meets. The decay is the cost with the order of the last
// build, divided by the cost with the order of the triangles as they are now, which a rebuild would restore.
// It stays near 1 for a mesh that only moves, turns, stretches or bends as a whole.
class RefitQuality {
  public:
    // A copy is rebuilt when its decay exceeds this.
    static constexpr float kMaxDecay = 1.25f;
    // Number of triangles of a group in the sample.
    static constexpr size_t kSampleCount = 128;

    // Sets the current triangles: three corners each, and the same number in every call. Returns the decay,
    // which is 1 before the first build and without triangles.
    float Follow(std::span<const glm::vec3> corners);
    // Records that the BLAS has been built from the current triangles. It allocates nothing, because it is
    // called once a frame has been submitted, when no call may fail.
    void OnBuild() noexcept;

  private:
    std::vector<uint32_t> m_order;         // order at the last build
    std::vector<uint32_t> m_currentOrder;  // order of the triangles as they are now
};

}  // namespace raygraph

// InstanceSet: the placed meshes of the scene, their records on the device and the TLAS over them. It tracks
// what has changed since the TLAS was last built and does the least work: none, an update, or a rebuild.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/scene_resources.h"
#include "rhi/tlas.h"

namespace raygraph {

class InstanceSet {
  public:
    // An instance of the TLAS: one group of one scene instance. Its index is the custom index, and that of
    // its record.
    struct Placement {
        uint32_t instance = 0;
        uint32_t group = 0;
        uint32_t firstLight = 0;  // of the group's emitters, as numbered over all placements in their order
    };

    // `resources` outlives the set, and still has its emitters. `data` has lost its meshes by then.
    InstanceSet(rhi::Device& device, const SceneResources& resources, const scene::SceneData& data);

    std::span<const Placement> Placements() const { return m_placements; }
    uint32_t Count() const { return static_cast<uint32_t>(m_instances.size()); }
    const scene::PlacedTransform& Transform(uint32_t index) const { return m_instances[index].objectToWorld; }
    void SetTransform(uint32_t index, const scene::PlacedTransform& objectToWorld);
    // As on the device: relative to the scene's origin.
    glm::mat4x3 DeviceTransform(uint32_t index) const {
        return m_instances[index].objectToWorld.RelativeTo(m_origin);
    }
    void MoveOrigin(const glm::dvec3& origin) noexcept;
    // The bounding box of all positions that an instance has had, in world space.
    const scene::Bounds& Reach() const { return m_reach; }
    void SetVisible(uint32_t index, bool isVisible);
    bool IsVisible(uint32_t index) const { return m_instances[index].isVisible; }
    // A BLAS was built or has moved: every address has to be written again.
    void MarkStructuresChanged() { m_needsRebuild = true; }
    // The box of an instance's mesh has changed.
    void MarkDeformed(uint32_t instance);
    // BLASes were refitted or rebuilt in place.
    void MarkRefitted() { m_needsUpdate = true; }
    // Kinds or draws of groups have changed: every record has to be written again as well.
    void MarkGroupsChanged() { m_needsRebuild = m_areRecordsDue = true; }

    // What the next refresh will do.
    TlasWork PendingWork() const;
    // Declares the passes that bring the instance records and the TLAS up to date, and sets `tlas` and
    // `instances`. `done` is told of the work when it has been submitted: a refresh that is culled, or whose
    // frame is dropped, stays pending.
    void DeclareRefresh(Renderer& renderer, SceneIds& ids, std::function<void(TlasWork)> done);

    uint64_t TlasBytes() const { return m_tlas.Bytes(); }

  private:
    struct Instance {
        scene::PlacedTransform objectToWorld;
        uint32_t mesh = 0;
        uint32_t firstPlacement = 0;  // one for each group of the mesh
        bool isVisible = true;
    };
    // Placements that have moved since they were last written to one of the buffers.
    class MovedPlacements {
      public:
        explicit MovedPlacements(size_t placementCount) : m_isListed(placementCount) {}
        void Add(uint32_t placement);
        void Clear();
        const std::vector<uint32_t>& List() const { return m_list; }

      private:
        std::vector<uint32_t> m_list;
        std::vector<bool> m_isListed;
    };

    void ExtendReach(const Instance& instance);
    rhi::TlasInstance TlasInstanceOf(uint32_t placement) const;
    gpu::InstanceRecord RecordOf(uint32_t placement) const;
    uint32_t PlacementCount() const { return static_cast<uint32_t>(m_placements.size()); }
    void OrderSlots();
    // Beyond a quarter of the scene one large copy is faster than many small ones.
    bool IsMany(const MovedPlacements& moved) const { return moved.List().size() > m_placements.size() / 4; }
    // Copies what `write` puts into staging memory for the sorted `elements` of a buffer, of `bytes` each.
    void RecordUpload(CommandList& commands, std::span<const uint32_t> elements, uint64_t bytes,
                      const rhi::Buffer& target, const std::function<void(std::span<std::byte>)>& write);
    void RecordInstanceUpload(CommandList& commands);
    void RecordTlasInstanceUpload(CommandList& commands, TlasWork work);
    void DeclareInstanceUpload(Renderer& renderer, SceneIds& ids);

    rhi::Device& m_device;
    const SceneResources& m_resources;
    std::vector<Instance> m_instances;
    std::vector<Placement> m_placements;
    glm::dvec3 m_origin{0.0};
    scene::Bounds m_reach;
    std::vector<uint32_t> m_slotToPlacement;  // TLAS order: spatial
    std::vector<uint32_t> m_placementToSlot;
    MovedPlacements m_movedInRecords{0}, m_movedInTlas{0};
    bool m_areRecordsDue = true;  // all of them
    bool m_needsRebuild = true;
    bool m_needsUpdate = false;  // a transform has changed since the TLAS was built

    rhi::Buffer m_tlasInstances;  // what the build reads, in slot order
    rhi::Buffer m_records;        // gpu::InstanceRecord[], by placement
    rhi::Tlas m_tlas;
    ResourceState m_tlasInstancesState;
    ResourceState m_recordsState;
    ResourceState m_tlasState;
};

}  // namespace raygraph

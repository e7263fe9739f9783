// InstanceSet: the placed meshes of the scene, their records on the device and the TLAS over them. It tracks
// what has changed since the TLAS was last built and does the least work: none, an update, or a rebuild. What
// is hidden stays in the TLAS, with a mask that no ray meets: an update may neither add nor remove instances.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/box_tree.h"
#include "renderer/gpu_scene/change_list.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/record_table.h"
#include "renderer/gpu_scene/scene_resources.h"
#include "renderer/gpu_scene/tlas_quality.h"
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
    InstanceSet(rhi::Device& device, const SceneResources& resources, const scene::SceneData& data,
                TlasRule rule = TlasRule::Decay);

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
    // Forgets all positions but the present ones.
    void RestartReach();
    void SetVisible(uint32_t index, bool isVisible);
    bool IsVisible(uint32_t index) const { return m_instances[index].isVisible; }
    // A BLAS was built or has moved: every address has to be written again.
    void MarkStructuresChanged() { m_needsRebuild = true; }
    // Around what is visible, from the scene's origin. Takes time in proportion to what has changed since
    // the last call.
    scene::Bounds VisibleBounds();
    // The shape of a mesh or copy has changed, and of these instances that place it.
    void MarkDeformed(uint32_t mesh, std::span<const uint32_t> instances);
    // BLASes were refitted or rebuilt in place.
    void MarkRefitted() { m_needsUpdate = true; }
    // Kinds or draws of groups have changed: every record has to be written again as well.
    void MarkGroupsChanged() {
        m_needsRebuild = true;
        m_records.AddAll();
    }

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
        uint32_t leaf = 0;            // its number in the order of the TLAS
        uint32_t firstSlot = 0;       // of its placements in the TLAS
        uint32_t firstLight = 0;      // of its emitters
        bool isVisible = true;
    };

    scene::Bounds MeshBounds(const MeshResources& mesh) const;
    void ExtendReach(const Instance& instance);
    // `isSeen`: the TLAS has to know.
    void NoteChanged(uint32_t index, bool isSeen);
    // Calls visit(index, instance) for each, some of whose memory is far from each other.
    template <typename Visit>
    void ForEach(std::span<const uint32_t> instances, Visit&& visit) const;
    void WriteRecords(std::span<const uint32_t> instances, RecordTable::Writer& writer) const;
    void WriteTlasInstances(std::span<const uint32_t> instances, RecordTable::Writer& writer) const;
    uint32_t PlacementCount() const { return static_cast<uint32_t>(m_placements.size()); }
    // Of what is visible, as on the device; empty: it is hidden.
    scene::Bounds BoxOf(uint32_t instance) const;
    void AssignBoxes();
    void RefreshBoxes();
    bool IsRebuildWorthwhile();
    void Order();

    const SceneResources& m_resources;
    TlasRule m_rule;
    std::vector<Instance> m_instances;
    std::vector<Placement> m_placements;
    std::vector<scene::Bounds> m_meshBounds;  // object space, copies as well
    std::vector<uint32_t> m_lightsBefore;     // by group: lights of the groups of its mesh before it
    glm::dvec3 m_origin{0.0};
    scene::Bounds m_reach;
    // The order of the TLAS: instances by space, and the placements of each side by side.
    std::vector<uint32_t> m_order;
    bool m_needsRebuild = true;
    bool m_needsUpdate = false;  // what is visible has changed since the TLAS was built or updated

    BoxTree m_boxes;  // in that order
    ChangeList m_movedBoxes;
    bool m_areBoxesOld = true;  // all of them
    TlasQuality m_quality;

    RecordTable m_tlasInstances;  // what the build reads, in the order of the TLAS
    RecordTable m_records;        // gpu::InstanceRecord[], by placement
    rhi::Tlas m_tlas;
    ResourceState m_tlasState;
};

}  // namespace raygraph

// InstanceSet: the placed meshes of the scene, their records on the device and the TLAS over them. It tracks
// what has changed since the TLAS was last built and does the least work: none, an update, or a rebuild. What
// is hidden stays in the TLAS, with a mask that no ray meets: an update may neither add nor remove instances.
// Where instances come and go the device rebuilds the TLAS, of records of which the host writes those that
// have changed: what comes has places behind the others, what goes leaves inactive ones. Only for another
// order in space does the host go through all.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "base/large_pages.h"
#include "renderer/gpu_scene/geometry/box_tree.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/instances/tlas_quality.h"
#include "renderer/gpu_scene/record_table.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/gpu_scene/scene_statistics.h"
#include "renderer/gpu_scene/slot_ranges.h"
#include "rhi/tlas.h"

namespace raygraph {

class InstanceSet {
  public:
    // An instance of the TLAS: one group of one scene instance. Its index is the custom index, and that of
    // its record.
    struct Placement {
        uint32_t instance = 0;
        uint32_t group = 0;       // kNoGroup: this index is free
        uint32_t firstLight = 0;  // as in its InstanceRecord
    };
    static constexpr uint32_t kNoGroup = ~0u;

    // `geometry` outlives the set. `data` has lost its meshes by then.
    InstanceSet(rhi::Device& device, const SceneGeometry& geometry, const scene::SceneData& data);

    // Places an instance of a mesh or copy. Later calls name it by what is returned: the index of one that
    // was removed before, or a new one. Error{Usage} where the device traces no more instances,
    // Error{OutOfMemory}; on an Error or std::bad_alloc nothing has changed.
    uint32_t Add(uint32_t mesh, const scene::PlacedTransform& objectToWorld, bool isVisible);
    // The next refresh no longer names its BLASes. The others keep their indices. On std::bad_alloc nothing
    // has changed.
    void Remove(uint32_t index);
    bool Exists(uint32_t index) const { return index < m_exists.size() && m_exists[index]; }
    // A mesh of the geometry is new, or has other groups; no instance places it yet.
    void AddMesh(uint32_t mesh);
    // Of the emitters of a placement that exists, which LightSet numbers.
    void SetFirstLight(uint32_t placement, uint32_t firstLight);

    // By index; some may be free.
    std::span<const Placement> Placements() const { return m_placements; }
    // On the device: all that there ever were. Those that are free now say that no view draws them.
    uint32_t RecordCount() const { return static_cast<uint32_t>(m_placements.size()); }
    uint32_t PlacementsOf(uint32_t group) const { return m_placementsOf[group]; }
    uint32_t ExistingCount() const { return m_indices.TakenCount(); }
    // Past the last index that an instance has had; not all below it need exist.
    uint32_t Count() const { return static_cast<uint32_t>(m_instances.size()); }
    uint32_t FirstPlacement(uint32_t index) const { return m_instances[index].firstPlacement; }
    uint32_t MeshOf(uint32_t index) const { return m_instances[index].mesh; }
    // The bounding box of a mesh or of a deformed copy, in object space.
    const scene::Bounds& BoundsOf(uint32_t mesh) const { return m_meshes[mesh].bounds; }
    const scene::PlacedTransform& Transform(uint32_t index) const { return m_instances[index].objectToWorld; }
    // The transform of each of these instances; of one that is listed twice the last. On an Error nothing has
    // changed. Whether something has.
    bool SetTransforms(std::span<const uint32_t> instances,
                       std::span<const scene::PlacedTransform> objectToWorld);
    // As on the device: relative to the scene's origin.
    glm::mat4x3 DeviceTransform(uint32_t index) const { return DeviceTransform(m_instances[index]); }
    void MoveOrigin(const glm::dvec3& origin) noexcept;
    // The bounding box of all positions that an instance has had, in world space.
    const scene::Bounds& Reach() const { return m_reach; }
    // Forgets all positions but the present ones.
    void RestartReach();
    bool SetVisible(std::span<const uint32_t> instances, bool isVisible);  // likewise
    bool IsVisible(uint32_t index) const { return m_instances[index].isVisible; }
    // A BLAS was built or has moved: every address has to be written again.
    void MarkStructuresChanged() {
        m_needsOrder = true;
        ++m_version;
    }
    // Another number whenever instances, their places, visibility or groups are others.
    uint64_t Version() const { return m_version; }
    // Around what is visible, from the scene's origin. Takes time in proportion to what has changed since
    // the last call.
    scene::Bounds VisibleBounds();
    // The shape of a mesh or copy has changed, and of these instances that place it.
    void MarkDeformed(uint32_t mesh, std::span<const uint32_t> instances);
    // BLASes were refitted or rebuilt in place.
    void MarkRefitted() { m_needsUpdate = true; }
    // Kinds or draws of groups have changed: every record has to be written again as well.
    void MarkGroupsChanged() {
        m_needsOrder = true;
        m_records.AddAll();
        ++m_version;
    }

    // What the next refresh will do.
    TlasWork PendingWork() const;
    // Declares the passes that bring the instance records and the TLAS up to date, and sets `tlas` and
    // `instances`. `done` is told of the work when it has been submitted: a refresh that is culled, or whose
    // frame is dropped, stays pending.
    void DeclareRefresh(Renderer& renderer, SceneIds& ids, std::function<void(TlasWork)> done);

    uint64_t TlasBytes() const { return m_tlas.Bytes(); }

  private:
    static constexpr uint32_t kUnplaced = ~0u;
    // All that a frame in which it moves needs, in two neighboring cache lines: waiting for memory is most of
    // what it costs.
    struct alignas(128) Instance {
        scene::PlacedTransform objectToWorld;
        bool isVisible = true;
        bool hasLights = false;  // some placement has another firstLight than 0
        uint32_t mesh = 0;
        uint32_t firstPlacement = 0;     // one for each group of the mesh
        uint32_t firstSlot = kUnplaced;  // in the TLAS, of its placements; the leaf with its box
        uint32_t recordListed = 0, tlasRecordListed = 0, boxListed = 0;
    };
    // Instances for which a frame has something to do, each listed once: those that it lists have its number.
    struct Changes {
        uint32_t Instance::*listed;
        uint32_t number = 1;
        std::vector<uint32_t> instances = {};  // some may have been removed
        size_t records = 0;                    // of those that exist
        void Clear() {
            instances.clear();
            records = 0;
            ++number;
        }
    };
    struct Mesh {
        uint32_t firstGroup = 0;
        uint32_t groupCount = 0;
        scene::Bounds bounds;  // object space
        float reach = 0.0f;    // the largest coordinate in it
    };
    void RefreshBounds(uint32_t mesh);
    void ExtendReach(const Instance& instance);
    // Makes room for so many more changes.
    void ReserveChanges(size_t count);
    void Note(Changes& changes, uint32_t index);
    // The same of what was added: it may have been listed before it was removed.
    void AppendDirty(Changes& changes, uint32_t index);
    void Forget(Changes& changes, const Instance& instance);
    // For so many records; Error where the device has no room.
    size_t MaxRecords() const;
    size_t GrownCapacity(size_t before, size_t needed) const;
    // Gives what was added places in the TLAS, behind all others or where as many are free.
    void PlaceAdded();
    void WriteRecords(bool areAll, RecordTable::Writer& writer) const;
    void WriteTlasInstances(bool areAll, RecordTable::Writer& writer) const;
    // `isSeen`: the TLAS has to know.
    void MarkInstanceChanged(uint32_t index, bool isSeen);
    // Calls visit(index, instance) for each, some of whose memory is far from each other, and before that
    // soon(instance).
    template <typename Visit, typename Soon>
    void ForEach(std::span<const uint32_t> instances, Visit&& visit, Soon&& soon) const;
    template <typename Visit>
    void ForEach(std::span<const uint32_t> instances, Visit&& visit) const;
    template <typename Visit>
    void ForEach(Visit&& visit) const;
    void WriteRecord(uint32_t index, const Instance& instance, RecordTable::Writer& writer) const;
    void WriteTlasInstance(const Instance& instance, RecordTable::Writer& writer) const;
    glm::mat4x3 DeviceTransform(const Instance& instance) const {
        return instance.objectToWorld.RelativeTo(m_origin);
    }
    // Of what is visible, as on the device; empty: it is hidden.
    scene::Bounds BoxOf(const Instance& instance) const;
    void AssignBoxes();
    void RefreshBoxes();
    bool NeedsReorder();
    std::vector<glm::vec3> Centers(std::span<const uint32_t> instances) const;
    void Order();

    rhi::Device& m_device;
    const SceneGeometry& m_geometry;
    LargeArray<Instance> m_instances;
    std::vector<bool> m_exists;  // by instance: so small that it stays in caches
    std::vector<Placement> m_placements;
    SlotRanges m_indices;           // of instances
    SlotRanges m_placementIndices;  // of m_placements
    SlotRanges m_slots;             // of the TLAS
    std::vector<bool> m_isSlotUsed;
    std::vector<uint32_t> m_placementsOf;  // by group
    std::vector<uint32_t> m_added;         // which have no place in the TLAS, or had none
    size_t m_unplacedSlots = 0;            // that these need
    size_t m_addedSinceOrder = 0;          // slots
    // To be written as free, unless they are taken again.
    std::vector<uint32_t> m_freedPlacements, m_freedSlots;
    std::vector<Mesh> m_meshes;  // of the scene, and copies
    glm::dvec3 m_origin{0.0};
    uint64_t m_version = 1;
    scene::Bounds m_reach;
    bool m_needsOrder = true;    // implies a rebuild
    bool m_needsRebuild = true;  // on the device
    bool m_needsUpdate = false;  // what is visible has changed since the TLAS was built or updated

    BoxTree m_boxes;  // by slot: that of an instance at its first one
    Changes m_dirtyRecords{&Instance::recordListed};
    Changes m_dirtyTlasRecords{&Instance::tlasRecordListed};
    Changes m_dirtyBoxes{&Instance::boxListed};
    bool m_boxesDirty = true;  // all of them
    TlasQuality m_quality;

    RecordTable m_tlasInstances;  // what the build reads, in the order of the TLAS
    RecordTable m_records;        // gpu::InstanceRecord[], by placement
    rhi::Tlas m_tlas;
    ResourceState m_tlasState;
};

// Instances are far apart in memory, and waiting for it would take most of the time: it is fetched ahead.
template <typename Visit, typename Soon>
void InstanceSet::ForEach(std::span<const uint32_t> instances, Visit&& visit, Soon&& soon) const {
    constexpr size_t kAhead = 12;
    // Inline: a call that does nothing but fetch would count as one without effect, and be left out
    const auto fetch = [&](size_t i) __attribute__((always_inline)) {
        if (i >= instances.size()) return;
        const Instance* const instance = &m_instances[instances[i]];
        __builtin_prefetch(instance);
        __builtin_prefetch(&instance->mesh);
    };
    const auto meet = [&](size_t i) __attribute__((always_inline)) {
        if (i < instances.size() && m_exists[instances[i]]) soon(m_instances[instances[i]]);
    };
    for (size_t i = 0; i < 2 * kAhead; ++i) fetch(i);
    for (size_t i = 0; i < kAhead; ++i) meet(i);
    for (size_t i = 0; i < instances.size(); ++i) {
        fetch(i + 2 * kAhead);
        meet(i + kAhead);
        if (m_exists[instances[i]]) visit(instances[i], m_instances[instances[i]]);
    }
}

template <typename Visit>
void InstanceSet::ForEach(std::span<const uint32_t> instances, Visit&& visit) const {
    ForEach(instances, visit, [](const Instance&) {});
}

template <typename Visit>
void InstanceSet::ForEach(Visit&& visit) const {
    for (uint32_t i = 0; i < m_instances.size(); ++i)
        if (m_exists[i]) visit(i, m_instances[i]);
}

}  // namespace raygraph

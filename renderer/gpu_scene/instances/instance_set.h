// InstanceSet: the placed meshes of the scene, their records on the device and the TLAS over them. It tracks
// what has changed since the TLAS was last built and does the least work: none, an update, or a rebuild.
// Hidden instances stay in the TLAS with a mask that no ray meets, because an update may neither add nor
// remove instances. Where instances are added or removed, the device rebuilds the TLAS, and the host writes
// only the records that have changed: added instances follow the others, removed ones leave inactive records.
// Only a new order in space makes the host write all records. Threads: that of the Renderer.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "base/large_pages.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/geometry/wide_set.h"
#include "renderer/gpu_scene/instances/tlas_quality.h"
#include "renderer/gpu_scene/record_table.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/gpu_scene/scene_statistics.h"
#include "rhi/tlas.h"
#include "shaders/shared/ray_types.h"

namespace raygraph {

class InstanceSet {
  public:
    // Describes an instance of the TLAS: one group of one scene instance. Its index is the custom index, and
    // the index of its record.
    struct Placement {
        uint32_t instance = 0;
        uint32_t group = 0;       // kNoGroup: the index is free
        uint32_t firstLight = 0;  // as in its InstanceRecord
    };
    static constexpr uint32_t kNoGroup = ~0u;

    // `geometry` outlives the set. The meshes have been moved out of `data`.
    InstanceSet(rhi::Device& device, const SceneGeometry& geometry, const scene::SceneData& data);

    // Places an instance of a mesh or of a deformed copy. Returns its index, which may be one that a removed
    // instance had. Throws Error{Usage} if the device can trace no more instances, and Error{OutOfMemory}; on
    // an Error or std::bad_alloc nothing has changed.
    uint32_t Add(uint32_t mesh, const scene::PlacedTransform& objectToWorld, bool isVisible);
    // Removes an instance: the next refresh no longer references its BLASes. Other indices do not change. On
    // std::bad_alloc nothing has changed.
    void Remove(uint32_t index);
    bool Exists(uint32_t index) const { return index < m_exists.size() && m_exists[index]; }
    // Must be called for a mesh of the geometry that is new or has other groups, before any instance places
    // it.
    void AddMesh(uint32_t mesh);
    // Sets the number that LightSet gives to the first emitter of an existing placement.
    void SetFirstLight(uint32_t placement, uint32_t firstLight);

    // By index; some of them may be free.
    std::span<const Placement> Placements() const { return m_placements; }
    // Returns the number of records on the device. It never falls; a free record tells that no view draws it.
    uint32_t RecordCount() const { return static_cast<uint32_t>(m_placements.size()); }
    uint32_t PlacementsOf(uint32_t group) const { return m_placementsOf[group]; }
    uint32_t ExistingCount() const { return m_indices.TakenCount(); }
    // Returns the largest index that an instance has had, plus 1. Not all instances below it need exist.
    uint32_t Count() const { return static_cast<uint32_t>(m_instances.size()); }
    uint32_t FirstPlacement(uint32_t index) const { return m_instances[index].firstPlacement; }
    uint32_t MeshOf(uint32_t index) const { return m_instances[index].mesh; }
    // Returns the bounding box of a mesh or of a deformed copy, in object space.
    const scene::Bounds& BoundsOf(uint32_t mesh) const { return m_meshes[mesh].bounds; }
    const scene::PlacedTransform& Transform(uint32_t index) const { return m_instances[index].objectToWorld; }
    // Sets the transforms of these instances; for one that is listed twice the last counts. Returns whether
    // any has changed. On an Error nothing has changed.
    bool SetTransforms(std::span<const uint32_t> instances,
                       std::span<const scene::PlacedTransform> objectToWorld);
    // Returns the transform on the device, relative to the scene's origin.
    glm::mat4x3 DeviceTransform(uint32_t index) const { return DeviceTransform(m_instances[index]); }
    void MoveOrigin(const glm::dvec3& origin) noexcept;
    // Returns the bounding box of all positions that instances have had since RestartReach, in world space.
    const scene::Bounds& Reach() const { return m_reach; }
    // Resets Reach() to the current positions.
    void RestartReach();
    bool SetVisible(std::span<const uint32_t> instances, bool isVisible);  // as SetTransforms
    bool IsVisible(uint32_t index) const { return m_instances[index].isVisible; }
    // These set what only passes of a host see: Version() does not change. On std::bad_alloc nothing has.
    void SetHostMask(std::span<const uint32_t> instances, uint8_t mask);
    void SetHitSet(std::span<const uint32_t> instances, uint8_t number);
    uint8_t HostMask(uint32_t index) const { return m_instances[index].hostMask; }
    uint8_t HitSet(uint32_t index) const { return m_instances[index].hitSet; }
    // Must be called when a BLAS was built or has moved: every address has to be written again.
    void MarkStructuresChanged() {
        m_needsOrder = true;
        ++m_version;
    }
    // Returns a number that changes whenever instances, their places, visibility or groups change.
    uint64_t Version() const { return m_version; }
    // Returns the box around all visible instances, relative to the scene's origin, without shadow catchers
    // unless there is nothing else. Takes time in proportion to what has changed since the last call.
    scene::Bounds VisibleBounds();
    // Must be called when the shape of a mesh or copy has changed, with all instances that place it.
    void MarkDeformed(uint32_t mesh, std::span<const uint32_t> instances);
    // Must be called when BLASes were refitted or rebuilt in place.
    void MarkRefitted() { m_needsUpdate = true; }
    // Must be called when kinds or draws of groups have changed: every record has to be written again as
    // well.
    void MarkGroupsChanged() {
        m_needsOrder = true;
        m_records.AddAll();
        ++m_version;
    }

    // Returns the work of the next refresh.
    TlasWork PendingWork() const;
    // Declares the passes that update the instance records and the TLAS, and sets `tlas` and `instances`.
    // `done` is called with the work when it has been submitted: a refresh that is culled, or whose frame is
    // dropped, stays pending.
    void DeclareRefresh(Renderer& renderer, SceneIds& ids, std::function<void(TlasWork)> done);

    uint64_t TlasBytes() const { return m_tlas.Bytes(); }

  private:
    static constexpr uint32_t kUnplaced = ~0u;
    // Holds the data that a frame needs to move an instance, in two adjacent cache lines: most of the time
    // goes into cache misses.
    struct alignas(128) Instance {
        scene::PlacedTransform objectToWorld;
        bool isVisible = true;
        bool hasLights = false;  // the firstLight of some placement is not 0
        uint8_t hostMask = kMaskHost;
        uint8_t hitSet = 0;  // its number: HitSetOf
        uint32_t mesh = 0;
        uint32_t firstPlacement = 0;  // the placements are contiguous, one for each group of the mesh
        // Slot of its first placement in the TLAS; also the leaf with its box.
        uint32_t firstSlot = kUnplaced;
        uint32_t recordListed = 0, tlasRecordListed = 0, boxListed = 0;
    };
    // Instances for which a frame has work to do. Each is listed once: a listed instance holds the number of
    // the list.
    struct Changes {
        uint32_t Instance::*listed;
        uint32_t number = 1;
        std::vector<uint32_t> instances = {};  // some of them may have been removed
        size_t records = 0;                    // number of records of those that exist
        void Clear() {
            instances.clear();
            records = 0;
            ++number;
        }
    };
    struct Mesh {
        uint32_t firstGroup = 0;
        uint32_t groupCount = 0;
        scene::Bounds bounds;          // object space
        float reach = 0.0f;            // the largest absolute coordinate in `bounds`
        bool isShadowCatcher = false;  // all of its parts are
    };
    void RefreshBounds(uint32_t mesh);
    void ExtendReach(const Instance& instance);
    // Makes room for `count` more changes.
    void ReserveChanges(size_t count);
    void AddChange(Changes& changes, uint32_t index);
    // Lists an instance that was added. It may have been listed already, before it was removed.
    void AppendDirty(Changes& changes, uint32_t index);
    void RemoveChange(Changes& changes, const Instance& instance);
    // Returns the number of records that fit. Throws an Error if the device has no room for them.
    size_t MaxRecords() const;
    size_t GrownCapacity(size_t before, size_t needed) const;
    // Gives added instances slots in the TLAS, after all others or in a free range that is large enough.
    void PlaceAdded();
    void WriteRecords(bool writesAll, RecordTable::Writer& writer) const;
    void WriteTlasInstances(bool writesAll, RecordTable::Writer& writer) const;
    // `isSeen`: the change affects the TLAS.
    void MarkInstanceChanged(uint32_t index, bool isSeen);
    template <typename T>
    void SetTraced(std::span<const uint32_t> instances, T Instance::*field, T value);
    // Calls visit(index, instance) for each instance. Since they may be far apart in memory, soon(instance)
    // is called some time before, to prefetch.
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
    // Returns the box of a visible instance, relative to the scene's origin; empty for a hidden one.
    scene::Bounds BoxOf(const Instance& instance) const;
    void AssignBoxes();
    void RefreshBoxes();
    bool NeedsReorder();
    std::vector<glm::vec3> Centers(std::span<const uint32_t> instances) const;
    void Order();

    rhi::Device& m_device;
    const SceneGeometry& m_geometry;
    LargeArray<Instance> m_instances;
    std::vector<bool> m_exists;  // by instance; it is small enough to stay in caches
    std::vector<Placement> m_placements;
    SlotRanges m_indices;           // indices of instances
    SlotRanges m_placementIndices;  // indices of m_placements
    SlotRanges m_slots;             // slots of the TLAS
    std::vector<bool> m_isSlotUsed;
    std::vector<uint32_t> m_placementsOf;    // by group: their number
    std::vector<uint32_t> m_added;           // instances that have or had no slot in the TLAS
    std::vector<uint32_t> m_shadowCatchers;  // instances of meshes that are shadow catchers
    size_t m_unplacedSlots = 0;              // slots that these need
    size_t m_addedSinceOrder = 0;            // slots added since the last order in space
    // Indices to be written as free, unless they are taken again.
    std::vector<uint32_t> m_freedPlacements, m_freedSlots;
    std::vector<Mesh> m_meshes;  // of the scene, then deformed copies
    glm::dvec3 m_origin{0.0};
    uint64_t m_version = 1;
    scene::Bounds m_reach;
    bool m_needsOrder = true;    // implies a rebuild
    bool m_needsRebuild = true;  // the TLAS on the device must be rebuilt
    bool m_needsUpdate = false;  // visible instances have changed since the TLAS was built or updated

    BoxTree m_boxes;  // by slot: the box of an instance is at its first slot
    Changes m_dirtyRecords{&Instance::recordListed};
    Changes m_dirtyTlasRecords{&Instance::tlasRecordListed};
    Changes m_dirtyBoxes{&Instance::boxListed};
    bool m_boxesDirty = true;  // the boxes of all instances
    TlasQuality m_quality;

    RecordTable m_tlasInstances;  // input of the build, in the order of the TLAS
    RecordTable m_records;        // gpu::InstanceRecord[], by placement
    rhi::Tlas m_tlas;
    ResourceState m_tlasState;
};

// Instances are far apart in memory, and cache misses would take most of the time: they are prefetched.
template <typename Visit, typename Soon>
void InstanceSet::ForEach(std::span<const uint32_t> instances, Visit&& visit, Soon&& soon) const {
    constexpr size_t kAhead = 12;
    // A function that only prefetches has no effect to the compiler, which would remove calls of it unless it
    // is inlined
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

// --- Owners: which part of the scene owns an object ---
// So a new object at the index of a removed one is not taken for it.

// Owners of the objects of one kind, by index. Parts are numbered from kOwnedByScene + 1 on.
inline constexpr uint32_t kOwnedByNone = 0, kOwnedByScene = 1;

class Owners {
  public:
    // Makes the scene the owner of objects 0 to `count` - 1, and removes all others.
    void Reset(size_t count) { m_owners.assign(count, kOwnedByScene); }
    // Makes room for an object that is about to be added, so that Set does not throw.
    void Reserve(size_t count) {
        if (m_owners.capacity() < count) m_owners.reserve(std::max(count, 2 * m_owners.capacity()));
    }
    void Set(uint32_t index, uint32_t owner) {
        if (index >= m_owners.size()) m_owners.resize(index + size_t{1}, kOwnedByNone);
        m_owners[index] = owner;
    }
    void Release(uint32_t index) noexcept {
        if (index < m_owners.size()) m_owners[index] = kOwnedByNone;
    }
    uint32_t Of(uint32_t index) const { return index < m_owners.size() ? m_owners[index] : kOwnedByNone; }

  private:
    std::vector<uint32_t> m_owners;
};

struct ObjectOwners {
    Owners textures, materials, meshes, instances, lights;
};

}  // namespace raygraph

#include "renderer/gpu_scene/instances/instance_set.h"

#include <algorithm>
#include <utility>

#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/lights/change_list.h"

namespace raygraph {
InstanceSet::InstanceSet(rhi::Device& device, const SceneGeometry& geometry, const scene::SceneData& data)
    : m_device(device), m_geometry(geometry) {
    for (uint32_t mesh = 0; mesh < geometry.meshes.size(); ++mesh) AddMesh(mesh);
    m_instances.reserve(data.instances.size());
    const std::vector<bool> isVisible = scene::VisibleNodes(data);
    for (const scene::Instance& instance : data.instances) {
        const auto index = static_cast<uint32_t>(m_instances.size());
        const uint32_t placed = geometry.meshOf[index];
        const Mesh& mesh = m_meshes[placed];
        const auto first = static_cast<uint32_t>(m_placements.size());
        m_instances.push_back({.objectToWorld = {instance.objectToWorld, instance.translationResidual},
                               .isVisible = scene::IsVisible(isVisible, instance),
                               .mesh = placed,
                               .firstPlacement = first,
                               .firstSlot = mesh.groupCount > 0 ? first : kUnplaced});
        for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groupCount; ++group) {
            m_placements.push_back({.instance = index, .group = group});
            ++m_placementsOf[group];
        }
        ExtendReach(m_instances.back());
    }
    RequirePlacements(device, m_placements.size());
    RequireBindable(device, "instances of groups of primitives", m_placements.size(),
                    sizeof(gpu::InstanceRecord));
    const auto count = static_cast<uint32_t>(m_placements.size());
    m_indices.Allocate(Count());
    m_exists.assign(Count(), true);
    m_placementIndices.Allocate(count);
    m_slots.Allocate(count);
    m_isSlotUsed.assign(count, true);
    m_tlasInstances = RecordTable(device, {.name = "TLAS instances",
                                           .passName = "UploadTlasInstances",
                                           .recordBytes = rhi::kTlasInstanceBytes,
                                           .capacity = count,
                                           .usage = rhi::BufferUsage::BuildInput});
    m_records = RecordTable(device, {.name = "instances",
                                     .passName = "UploadInstances",
                                     .recordBytes = sizeof(gpu::InstanceRecord),
                                     .capacity = count,
                                     .usage = rhi::BufferUsage::CopySource});
    m_tlasInstances.SetCount(count);
    m_records.SetCount(count);
    m_tlas = rhi::Tlas(device, {.name = "scene TLAS", .capacity = std::max(1u, count)});
}

void InstanceSet::AddMesh(uint32_t mesh) {
    const MeshResources& added = m_geometry.meshes[mesh];
    const size_t groups = added.firstGroup + added.groupCount;
    m_placementsOf.resize(std::max(groups, m_placementsOf.size()));
    m_meshes.resize(std::max<size_t>(mesh + 1, m_meshes.size()));
    RefreshBounds(mesh);
}

size_t InstanceSet::MaxRecords() const {
    return std::min(MaxPlacements(m_device),
                    m_device.Info().maxStorageBufferBytes / sizeof(gpu::InstanceRecord));
}

size_t InstanceSet::GrownCapacity(size_t before, size_t needed) const {
    RequirePlacements(m_device, needed);
    RequireBindable(m_device, "instances of groups of primitives", needed, sizeof(gpu::InstanceRecord));
    return std::min(std::max(needed, 2 * before), MaxRecords());
}

uint32_t InstanceSet::Add(uint32_t meshIndex, const scene::PlacedTransform& objectToWorld, bool isVisible) {
    const Mesh& mesh = m_meshes[meshIndex];
    RecordTable grownRecords, grownTlasInstances;
    rhi::Tlas grownTlas;
    const uint32_t index = m_indices.Allocate(1);
    uint32_t first = 0, taken = 0;
    try {
        first = m_placementIndices.Allocate(mesh.groupCount);
        taken = mesh.groupCount;
        if (const size_t end = m_placementIndices.End(); end > m_records.Capacity())
            grownRecords = m_records.WithCapacity(GrownCapacity(m_records.Capacity(), end));
        const size_t slots = m_slots.TakenCount() + m_unplacedSlots + mesh.groupCount;
        // There is room for as many gaps as there may be: otherwise each frame would need another order
        if (const size_t before = m_tlasInstances.Capacity();
            mesh.groupCount > 0 && (slots > before || (slots + slots / TlasQuality::kMaxChanged > before &&
                                                       before < MaxRecords()))) {
            const size_t capacity = GrownCapacity(before, slots);
            grownTlasInstances = m_tlasInstances.WithCapacity(capacity);
            grownTlas =
                rhi::Tlas(m_device, {.name = m_tlas.Name(), .capacity = static_cast<uint32_t>(capacity)});
        }
        ReserveChanges(1);
        ReserveMore(m_added, 1);
        m_placements.resize(std::max<size_t>(m_placements.size(), m_placementIndices.End()),
                            {.group = kNoGroup});
        m_exists.resize(std::max<size_t>(m_exists.size(), m_indices.End()));
        m_instances.resize(std::max<size_t>(m_instances.size(), m_indices.End()));
    } catch (...) {
        m_placementIndices.Free(first, taken);
        m_indices.Free(index, 1);
        throw;
    }

    if (grownRecords.Capacity() > 0) m_records = std::move(grownRecords);
    if (grownTlas) {
        m_tlasInstances = std::move(grownTlasInstances);
        m_tlas = std::move(grownTlas);
        m_tlasState = {};
    }
    m_exists[index] = true;
    ++m_version;
    Instance& instance = m_instances[index];
    instance = {.objectToWorld = objectToWorld,
                .isVisible = isVisible,
                .mesh = meshIndex,
                .firstPlacement = first,
                .recordListed = instance.recordListed,
                .tlasRecordListed = instance.tlasRecordListed,
                .boxListed = instance.boxListed};
    for (uint32_t i = 0; i < mesh.groupCount; ++i) {
        m_placements[first + i] = {.instance = index, .group = mesh.firstGroup + i};
        ++m_placementsOf[mesh.firstGroup + i];
    }
    m_records.SetCount(m_placements.size());
    AppendDirty(m_dirtyRecords, index);
    ExtendReach(instance);
    if (mesh.groupCount == 0) return index;
    m_added.push_back(index);
    m_unplacedSlots += mesh.groupCount;
    m_needsRebuild = true;
    return index;
}

void InstanceSet::Remove(uint32_t index) {
    Instance& instance = m_instances[index];
    const Mesh& mesh = m_meshes[instance.mesh];
    ReserveMore(m_freedPlacements, mesh.groupCount);
    ReserveMore(m_freedSlots, mesh.groupCount);

    Forget(m_dirtyRecords, instance);
    for (uint32_t i = 0; i < mesh.groupCount; ++i) {
        --m_placementsOf[mesh.firstGroup + i];
        m_placements[instance.firstPlacement + i] = {.group = kNoGroup};
        m_freedPlacements.push_back(instance.firstPlacement + i);
    }
    m_placementIndices.Free(instance.firstPlacement, mesh.groupCount);
    if (instance.firstSlot != kUnplaced) {
        Forget(m_dirtyTlasRecords, instance);
        for (uint32_t slot = instance.firstSlot; slot < instance.firstSlot + mesh.groupCount; ++slot) {
            m_isSlotUsed[slot] = false;
            m_freedSlots.push_back(slot);
        }
        if (!m_boxesDirty) m_boxes.Set(instance.firstSlot, {});
        m_slots.Free(instance.firstSlot, mesh.groupCount);
        m_tlasInstances.SetCount(m_slots.End());
        m_needsRebuild = true;
    } else {
        m_unplacedSlots -= mesh.groupCount;
    }
    m_exists[index] = false;
    ++m_version;
    instance.firstSlot = kUnplaced;
    m_indices.Free(index, 1);
}

void InstanceSet::SetFirstLight(uint32_t placement, uint32_t firstLight) {
    Placement& changed = m_placements[placement];
    if (changed.firstLight == firstLight) return;
    ReserveChanges(1);
    changed.firstLight = firstLight;
    m_instances[changed.instance].hasLights = true;
    Note(m_dirtyRecords, changed.instance);
}

void InstanceSet::RefreshBounds(uint32_t index) {
    const MeshResources& changed = m_geometry.meshes[index];
    Mesh& mesh = m_meshes[index];
    mesh = {.firstGroup = changed.firstGroup, .groupCount = changed.groupCount};
    for (const GroupResources& group : m_geometry.GroupsOf(changed)) mesh.bounds.Extend(group.bounds);
    if (mesh.bounds.IsEmpty()) return;
    const glm::vec3 farthest = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
    mesh.reach = std::max({farthest.x, farthest.y, farthest.z});
}

void InstanceSet::ExtendReach(const Instance& instance) {
    const glm::mat4x3& matrix = instance.objectToWorld.matrix;
    const Mesh& mesh = m_meshes[instance.mesh];
    // Nearly all instances stay within Reach, for which a box around the mesh's box and the object's origin
    // is enough
    const glm::vec3 half = mesh.reach * (glm::abs(matrix[0]) + glm::abs(matrix[1]) + glm::abs(matrix[2]));
    if (glm::all(glm::greaterThanEqual(matrix[3] - half, m_reach.min)) &&
        glm::all(glm::lessThanEqual(matrix[3] + half, m_reach.max)))
        return;
    for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groupCount; ++group)
        m_reach.Extend(m_geometry.groups[group].bounds.Transformed(matrix));
}

void InstanceSet::RestartReach() {
    m_reach = {};
    ForEach([&](uint32_t, const Instance& instance) { ExtendReach(instance); });
}

void InstanceSet::MoveOrigin(const glm::dvec3& origin) noexcept {
    m_origin = origin;
    ++m_version;
    m_boxesDirty = true;
    m_records.AddAll();
    m_needsOrder = true;
}

bool InstanceSet::SetTransforms(std::span<const uint32_t> instances,
                                std::span<const scene::PlacedTransform> objectToWorld) {
    ReserveChanges(instances.size());  // this may throw std::bad_alloc
    bool isChanged = false;
    const scene::PlacedTransform* next = objectToWorld.data();
    ForEach(instances, [&](uint32_t index, const Instance& before) {
        const scene::PlacedTransform& transform = *next++;
        if (before.objectToWorld == transform) return;
        isChanged = true;
        MarkInstanceChanged(index, before.isVisible);
        Instance& instance = m_instances[index];
        instance.objectToWorld = transform;
        ExtendReach(instance);
    });
    return isChanged;
}

bool InstanceSet::SetVisible(std::span<const uint32_t> instances, bool isVisible) {
    ReserveChanges(instances.size());
    bool isChanged = false;
    ForEach(instances, [&](uint32_t index, const Instance& before) {
        if (before.isVisible == isVisible) return;
        isChanged = true;
        MarkInstanceChanged(index, true);
        m_instances[index].isVisible = isVisible;
    });
    return isChanged;
}

void InstanceSet::ReserveChanges(size_t count) {
    for (Changes* changes : {&m_dirtyRecords, &m_dirtyTlasRecords, &m_dirtyBoxes})
        ReserveMore(changes->instances, count);
}

void InstanceSet::Note(Changes& changes, uint32_t index) {
    Instance& instance = m_instances[index];
    uint32_t& listed = instance.*changes.listed;
    if (listed == changes.number) return;
    changes.instances.push_back(index);
    changes.records += m_meshes[instance.mesh].groupCount;
    listed = changes.number;
}

void InstanceSet::AppendDirty(Changes& changes, uint32_t index) {
    const Instance& instance = m_instances[index];
    if (instance.*changes.listed == changes.number)
        changes.records += m_meshes[instance.mesh].groupCount;
    else
        Note(changes, index);
}

void InstanceSet::Forget(Changes& changes, const Instance& instance) {
    if (instance.*changes.listed == changes.number) changes.records -= m_meshes[instance.mesh].groupCount;
}

// The box of a hidden instance in the TLAS stays where the instance was last visible, so that it enlarges no
// other boxes.
void InstanceSet::MarkInstanceChanged(uint32_t index, bool isSeen) {
    ++m_version;
    Note(m_dirtyRecords, index);
    if (!isSeen || m_instances[index].firstSlot == kUnplaced) return;
    Note(m_dirtyTlasRecords, index);
    Note(m_dirtyBoxes, index);
    m_needsUpdate = true;
}

void InstanceSet::MarkDeformed(uint32_t mesh, std::span<const uint32_t> instances) {
    ReserveChanges(instances.size());
    RefreshBounds(mesh);
    for (const uint32_t instance : instances) {
        ExtendReach(m_instances[instance]);
        if (m_instances[instance].firstSlot != kUnplaced) Note(m_dirtyBoxes, instance);
    }
}

}  // namespace raygraph

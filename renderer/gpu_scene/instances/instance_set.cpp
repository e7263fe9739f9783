#include "renderer/gpu_scene/instances/instance_set.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/geometry/mesh_packing.h"
#include "renderer/gpu_scene/lights/light_table.h"
#include "renderer/gpu_scene/materials/scene_materials.h"
#include "rhi/command_list.h"

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
        if (mesh.isShadowCatcher) m_shadowCatchers.push_back(index);
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
        ReserveMore(m_shadowCatchers, mesh.isShadowCatcher ? 1 : 0);
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
    if (mesh.isShadowCatcher) m_shadowCatchers.push_back(index);
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

    RemoveChange(m_dirtyRecords, instance);
    for (uint32_t i = 0; i < mesh.groupCount; ++i) {
        --m_placementsOf[mesh.firstGroup + i];
        m_placements[instance.firstPlacement + i] = {.group = kNoGroup};
        m_freedPlacements.push_back(instance.firstPlacement + i);
    }
    m_placementIndices.Free(instance.firstPlacement, mesh.groupCount);
    if (instance.firstSlot != kUnplaced) {
        RemoveChange(m_dirtyTlasRecords, instance);
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
    if (mesh.isShadowCatcher) std::erase(m_shadowCatchers, index);
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
    AddChange(m_dirtyRecords, changed.instance);
}

void InstanceSet::RefreshBounds(uint32_t index) {
    const MeshResources& changed = m_geometry.meshes[index];
    Mesh& mesh = m_meshes[index];
    mesh = {.firstGroup = changed.firstGroup, .groupCount = changed.groupCount};
    mesh.isShadowCatcher = mesh.groupCount > 0;
    for (const GroupResources& group : m_geometry.GroupsOf(changed)) {
        mesh.bounds.Extend(group.bounds);
        mesh.isShadowCatcher &= std::ranges::all_of(group.parts, &GroupPart::isShadowCatcher);
    }
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

template <typename T>
void InstanceSet::SetTraced(std::span<const uint32_t> instances, T Instance::*field, T value) {
    ReserveChanges(instances.size());
    ForEach(instances, [&](uint32_t index, const Instance& before) {
        if (before.*field == value) return;
        m_instances[index].*field = value;
        // Otherwise the record is written when the instance is shown or placed
        if (!before.isVisible || before.firstSlot == kUnplaced) return;
        AddChange(m_dirtyTlasRecords, index);
        m_needsUpdate = true;
    });
}

void InstanceSet::SetHostMask(std::span<const uint32_t> instances, uint8_t mask) {
    SetTraced(instances, &Instance::hostMask, mask);
}

void InstanceSet::SetHitSet(std::span<const uint32_t> instances, uint8_t number) {
    SetTraced(instances, &Instance::hitSet, number);
}

void InstanceSet::ReserveChanges(size_t count) {
    for (Changes* changes : {&m_dirtyRecords, &m_dirtyTlasRecords, &m_dirtyBoxes})
        ReserveMore(changes->instances, count);
}

void InstanceSet::AddChange(Changes& changes, uint32_t index) {
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
        AddChange(changes, index);
}

void InstanceSet::RemoveChange(Changes& changes, const Instance& instance) {
    if (instance.*changes.listed == changes.number) changes.records -= m_meshes[instance.mesh].groupCount;
}

// The box of a hidden instance in the TLAS stays where the instance was last visible, so that it enlarges no
// other boxes.
void InstanceSet::MarkInstanceChanged(uint32_t index, bool isSeen) {
    ++m_version;
    AddChange(m_dirtyRecords, index);
    if (!isSeen || m_instances[index].firstSlot == kUnplaced) return;
    AddChange(m_dirtyTlasRecords, index);
    AddChange(m_dirtyBoxes, index);
    m_needsUpdate = true;
}

void InstanceSet::MarkDeformed(uint32_t mesh, std::span<const uint32_t> instances) {
    ReserveChanges(instances.size());
    RefreshBounds(mesh);
    for (const uint32_t instance : instances) {
        ExtendReach(m_instances[instance]);
        if (m_instances[instance].firstSlot != kUnplaced) AddChange(m_dirtyBoxes, instance);
    }
}

// --- The work of each frame ---

namespace {

// Removes duplicates, and slots that are no longer free.
template <typename IsFree>
void RemoveStale(std::vector<uint32_t>& freed, IsFree&& isFree) {
    std::erase_if(freed, [&](uint32_t i) { return !isFree(i); });
    std::ranges::sort(freed);
    freed.erase(std::unique(freed.begin(), freed.end()), freed.end());
}

}  // namespace

const char* Name(TlasWork work) {
    switch (work) {
        case TlasWork::None:
            return "nothing";
        case TlasWork::Update:
            return "update";
        case TlasWork::Rebuild:
            return "rebuild";
    }
    return "unknown";
}

void InstanceSet::PlaceAdded() {
    // Instances that have been removed again, whose index may now belong to one without triangles, and those
    // that are listed twice
    std::erase_if(m_added,
                  [&](uint32_t i) { return !m_exists[i] || m_meshes[m_instances[i].mesh].groupCount == 0; });
    std::ranges::sort(m_added);
    m_added.erase(std::unique(m_added.begin(), m_added.end()), m_added.end());
    if (m_added.empty()) return;
    const std::vector<uint32_t> order = SpatialOrder(Centers(m_added));
    ReserveChanges(m_added.size());
    const auto count = static_cast<uint32_t>(m_unplacedSlots);
    uint32_t slot = m_slots.Allocate(count);
    try {
        m_isSlotUsed.resize(std::max<size_t>(m_isSlotUsed.size(), m_slots.End()));
        if (!m_boxesDirty) m_boxes.Grow(m_slots.End());
    } catch (...) {
        m_slots.Free(slot, count);
        throw;
    }
    std::fill_n(m_isSlotUsed.begin() + slot, count, true);
    for (const uint32_t i : order) {
        Instance& instance = m_instances[m_added[i]];
        instance.firstSlot = slot;
        slot += m_meshes[instance.mesh].groupCount;
        AppendDirty(m_dirtyTlasRecords, m_added[i]);
        AppendDirty(m_dirtyBoxes, m_added[i]);
    }
    m_added.clear();
    m_unplacedSlots = 0;
    m_addedSinceOrder += count;
    m_tlasInstances.SetCount(m_slots.End());
}

TlasWork InstanceSet::PendingWork() const {
    if (m_needsOrder || m_needsRebuild) return TlasWork::Rebuild;
    return m_needsUpdate ? TlasWork::Update : TlasWork::None;
}

void InstanceSet::WriteTlasInstance(const Instance& instance, RecordTable::Writer& writer) const {
    const Mesh& mesh = m_meshes[instance.mesh];
    const glm::mat4x3 objectToWorld = DeviceTransform(instance);
    rhi::TlasInstance written;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            written.objectToWorld[static_cast<size_t>(4 * row + column)] = objectToWorld[column][row];
    for (uint32_t i = 0; i < mesh.groupCount; ++i) {
        const GroupResources& group = m_geometry.groups[mesh.firstGroup + i];
        written.customIndex = instance.firstPlacement + i;
        written.blas = group.BlasAddress();
        // A face keeps its side under a mirroring transform, in Vulkan as in glTF, so that nothing is flipped
        written.isCullingDisabled = !group.kind.isBackCulled;
        const bool isRound = group.kind.isRound;
        written.hitRecord =
            FirstHitRecord(HitSetOf(instance.hitSet, isRound ? kHitSetCapsules : kHitSetTriangles));
        written.mask = 0;
        if (instance.isVisible) written.mask = (isRound ? kMaskRound : kMaskTriangles) | instance.hostMask;
        rhi::WriteInstances(std::span(&written, 1), writer.At(instance.firstSlot + i));
    }
}

void InstanceSet::WriteRecord(uint32_t index, const Instance& instance, RecordTable::Writer& writer) const {
    const Mesh& mesh = m_meshes[instance.mesh];
    const glm::mat4x3 objectToWorld = DeviceTransform(instance);
    for (uint32_t i = 0; i < mesh.groupCount; ++i) {
        gpu::InstanceRecord record = m_geometry.groups[mesh.firstGroup + i].record;
        record.objectToWorld = objectToWorld;
        record.instance = index;
        if (instance.hasLights) record.firstLight = m_placements[instance.firstPlacement + i].firstLight;
        if (!instance.isVisible) record.draw = gpu::kNotDrawn;
        std::memcpy(writer.At(instance.firstPlacement + i).data(), &record, sizeof(record));
    }
}

void InstanceSet::WriteRecords(bool writesAll, RecordTable::Writer& writer) const {
    const auto write = [&](uint32_t index, const Instance& instance) {
        WriteRecord(index, instance, writer);
    };
    const auto writeFree = [&](uint32_t placement) {
        gpu::InstanceRecord record{};
        record.draw = gpu::kNotDrawn;
        std::memcpy(writer.At(placement).data(), &record, sizeof(record));
    };
    if (!writesAll) {
        ForEach(m_dirtyRecords.instances, write);
        for (const uint32_t placement : m_freedPlacements) writeFree(placement);
        return;
    }
    ForEach(write);
    for (uint32_t i = 0; i < m_placements.size(); ++i)
        if (m_placements[i].group == kNoGroup) writeFree(i);
}

void InstanceSet::WriteTlasInstances(bool writesAll, RecordTable::Writer& writer) const {
    const auto write = [&](uint32_t, const Instance& instance) { WriteTlasInstance(instance, writer); };
    const auto writeFree = [&](uint32_t slot) {
        const rhi::TlasInstance inactive{.mask = 0};
        rhi::WriteInstances(std::span(&inactive, 1), writer.At(slot));
    };
    if (!writesAll) {
        ForEach(m_dirtyTlasRecords.instances, write);
        for (const uint32_t slot : m_freedSlots) writeFree(slot);
        return;
    }
    ForEach(write);
    for (uint32_t slot = 0; slot < m_slots.End(); ++slot)
        if (!m_isSlotUsed[slot]) writeFree(slot);
}

scene::Bounds InstanceSet::BoxOf(const Instance& instance) const {
    return instance.isVisible ? m_meshes[instance.mesh].bounds.Transformed(DeviceTransform(instance))
                              : scene::Bounds();
}

void InstanceSet::AssignBoxes() {
    std::vector<scene::Bounds> boxes(m_slots.End());
    ForEach([&](uint32_t, const Instance& instance) {
        if (instance.firstSlot != kUnplaced) boxes[instance.firstSlot] = BoxOf(instance);
    });
    m_boxes.Assign(boxes);
    m_dirtyBoxes.Clear();
    m_boxesDirty = false;
}

void InstanceSet::RefreshBoxes() {
    PlaceAdded();
    if (m_boxesDirty) return AssignBoxes();
    // The boxes are prefetched too, once the instances have told where they are
    ForEach(
        m_dirtyBoxes.instances,
        [&](uint32_t, const Instance& instance) {
            // The index may belong to an instance of a mesh without triangles now
            if (instance.firstSlot != kUnplaced) m_boxes.Set(instance.firstSlot, BoxOf(instance));
        },
        [&](const Instance& instance) {
            if (instance.firstSlot != kUnplaced) m_boxes.Prefetch(instance.firstSlot);
        });
    m_boxes.Refresh();
    m_dirtyBoxes.Clear();
}

scene::Bounds InstanceSet::VisibleBounds() {
    RefreshBoxes();
    std::vector<size_t> catchers;
    for (const uint32_t index : m_shadowCatchers)
        if (m_instances[index].firstSlot != kUnplaced) catchers.push_back(m_instances[index].firstSlot);
    const scene::Bounds others = m_boxes.AroundAllBut(std::move(catchers));
    return others.IsEmpty() ? m_boxes.Root() : others;
}

bool InstanceSet::NeedsReorder() {
    if (m_slots.End() > m_tlasInstances.Capacity()) return true;
    RefreshBoxes();
    const uint32_t taken = m_slots.TakenCount();
    const bool isDecayed = m_quality.UpdateDecay(m_boxes.Cost(), m_boxes.BoxCount());
    return isDecayed || TlasQuality::IsTooMany(m_addedSinceOrder, taken) ||
           TlasQuality::IsTooMany(m_slots.End() - taken, taken);
}

// Returns the centers as on the device. A hidden instance counts as lying at the nearest visible position, so
// that it does not change the order of those that are visible.
std::vector<glm::vec3> InstanceSet::Centers(std::span<const uint32_t> instances) const {
    std::vector<glm::vec3> centers(instances.size());
    scene::Bounds seen;
    for (size_t i = 0; i < centers.size(); ++i) {
        const Instance& instance = m_instances[instances[i]];
        const scene::Bounds& mesh = m_meshes[instance.mesh].bounds;
        const glm::vec3 center = mesh.IsEmpty() ? glm::vec3(0.0f) : mesh.Center();
        centers[i] = DeviceTransform(instance) * glm::vec4(center, 1.0f);
        if (instance.isVisible) seen.Extend(centers[i]);
    }
    if (!seen.IsEmpty())
        for (glm::vec3& center : centers) center = glm::clamp(center, seen.min, seen.max);
    return centers;
}

void InstanceSet::Order() {
    std::vector<uint32_t> placed;
    placed.reserve(m_indices.TakenCount());
    ForEach([&](uint32_t index, const Instance& instance) {
        if (instance.firstSlot != kUnplaced) placed.push_back(index);
    });
    SlotRanges slots;
    slots.Allocate(m_slots.TakenCount());
    m_isSlotUsed.reserve(m_slots.TakenCount());
    uint32_t slot = 0;
    for (const uint32_t i : SpatialOrder(Centers(placed))) {
        Instance& instance = m_instances[placed[i]];
        instance.firstSlot = slot;
        slot += m_meshes[instance.mesh].groupCount;
    }
    m_slots = std::move(slots);
    m_isSlotUsed.assign(slot, true);
    m_freedSlots.clear();
    m_tlasInstances.SetCount(slot);
    AssignBoxes();
    m_addedSinceOrder = 0;
    m_quality.OnBuild(m_boxes.Cost(), m_boxes.BoxCount());
}

void InstanceSet::DeclareRefresh(Renderer& renderer, SceneIds& ids, std::function<void(TlasWork)> done) {
    PlaceAdded();
    ids.tlas = renderer.Import("sceneTlas", m_tlas, m_tlasState);
    RemoveStale(m_freedPlacements, [&](uint32_t i) { return m_placements[i].group == kNoGroup; });
    ids.instances = m_records.DeclareUpload(
        renderer, m_records.Import(renderer),
        {.changed = m_dirtyRecords.records + m_freedPlacements.size(),
         .write = [this](bool writesAll, RecordTable::Writer& writer) { WriteRecords(writesAll, writer); },
         .done =
             [this] {
                 m_dirtyRecords.Clear();
                 m_freedPlacements.clear();
             }});
    if (NeedsReorder()) m_needsOrder = true;
    const TlasWork work = PendingWork();
    if (work == TlasWork::None) {
        renderer.OnSubmitted([done = std::move(done)] { done(TlasWork::None); });
        return;
    }

    const bool isRebuild = work == TlasWork::Rebuild;
    if (m_needsOrder) m_tlasInstances.AddAll();
    RemoveStale(m_freedSlots, [&](uint32_t i) { return i < m_slots.End() && !m_isSlotUsed[i]; });
    const BufferId tlasInstances = m_tlasInstances.DeclareUpload(
        renderer, m_tlasInstances.Import(renderer),
        {.prepare =
             [this] {
                 if (m_needsOrder) Order();
             },
         .changed = m_dirtyTlasRecords.records + m_freedSlots.size(),
         .write = [this](bool writesAll,
                         RecordTable::Writer& writer) { WriteTlasInstances(writesAll, writer); },
         .done =
             [this] {
                 m_dirtyTlasRecords.Clear();
                 m_freedSlots.clear();
             }});
    renderer.AddPass(
        "RefreshTlas", PassKind::AccelerationStructure,
        [&](PassBuilder& pass) {
            pass.BuildsFrom(tlasInstances);
            pass.BuildsFrom(ids.blases);
            ids.tlas = isRebuild ? pass.Builds(ids.tlas) : pass.Refits(ids.tlas);
        },
        [this, work, isRebuild, done = std::move(done)](CommandList& commands) {
            if (isRebuild)
                m_tlas.Build(commands, m_tlasInstances.Buffer(), m_slots.End());
            else
                m_tlas.Update(commands, m_tlasInstances.Buffer(), m_slots.End());
            commands.OnSubmitted([this, work, isRebuild, done] {
                if (isRebuild) m_needsOrder = m_needsRebuild = false;
                m_needsUpdate = false;
                done(work);
            });
        });
}

}  // namespace raygraph

// InstanceSet: the work of each frame.
#include <algorithm>
#include <cstring>
#include <utility>

#include "renderer/gpu_scene/geometry/spatial_order.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "rhi/command_list.h"

namespace raygraph {
namespace {

// Removes duplicates, and slots that are no longer free.
template <typename IsFree>
void Tidy(std::vector<uint32_t>& freed, IsFree&& isFree) {
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
        written.hitRecord = FirstHitRecord(group.kind.isRound ? kHitSetCapsules : kHitSetTriangles);
        written.mask = group.kind.isRound ? static_cast<uint8_t>(~kMaskTriangles) : uint8_t{0xff};
        if (!instance.isVisible) written.mask = 0;
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

void InstanceSet::WriteRecords(bool areAll, RecordTable::Writer& writer) const {
    const auto write = [&](uint32_t index, const Instance& instance) {
        WriteRecord(index, instance, writer);
    };
    const auto writeFree = [&](uint32_t placement) {
        gpu::InstanceRecord record{};
        record.draw = gpu::kNotDrawn;
        std::memcpy(writer.At(placement).data(), &record, sizeof(record));
    };
    if (!areAll) {
        ForEach(m_dirtyRecords.instances, write);
        for (const uint32_t placement : m_freedPlacements) writeFree(placement);
        return;
    }
    ForEach(write);
    for (uint32_t i = 0; i < m_placements.size(); ++i)
        if (m_placements[i].group == kNoGroup) writeFree(i);
}

void InstanceSet::WriteTlasInstances(bool areAll, RecordTable::Writer& writer) const {
    const auto write = [&](uint32_t, const Instance& instance) { WriteTlasInstance(instance, writer); };
    const auto writeFree = [&](uint32_t slot) {
        const rhi::TlasInstance inactive{.mask = 0};
        rhi::WriteInstances(std::span(&inactive, 1), writer.At(slot));
    };
    if (!areAll) {
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
    return m_boxes.Root();
}

bool InstanceSet::NeedsReorder() {
    if (m_slots.End() > m_tlasInstances.Capacity()) return true;
    RefreshBoxes();
    const uint32_t taken = m_slots.TakenCount();
    const bool isDecayed = m_quality.UpdateDecay(m_boxes.Cost(), m_boxes.BoxCount());
    return isDecayed || TlasQuality::AreMany(m_addedSinceOrder, taken) ||
           TlasQuality::AreMany(m_slots.End() - taken, taken);
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
    Tidy(m_freedPlacements, [&](uint32_t i) { return m_placements[i].group == kNoGroup; });
    ids.instances = m_records.DeclareUpload(
        renderer, m_records.Import(renderer),
        {.changed = m_dirtyRecords.records + m_freedPlacements.size(),
         .write = [this](bool areAll, RecordTable::Writer& writer) { WriteRecords(areAll, writer); },
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
    Tidy(m_freedSlots, [&](uint32_t i) { return i < m_slots.End() && !m_isSlotUsed[i]; });
    const BufferId tlasInstances = m_tlasInstances.DeclareUpload(
        renderer, m_tlasInstances.Import(renderer),
        {.prepare =
             [this] {
                 if (m_needsOrder) Order();
             },
         .changed = m_dirtyTlasRecords.records + m_freedSlots.size(),
         .write = [this](bool areAll, RecordTable::Writer& writer) { WriteTlasInstances(areAll, writer); },
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

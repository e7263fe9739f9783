#include "renderer/gpu_scene/instance_set.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/spatial_order.h"

namespace raygraph {

namespace {

// Calls copy(first, count) for each run of consecutive numbers in sorted `values`.
template <typename Copy>
void ForEachRun(std::span<const uint32_t> values, Copy&& copy) {
    for (size_t begin = 0; begin < values.size();) {
        size_t end = begin + 1;
        while (end < values.size() && values[end] == values[end - 1] + 1) ++end;
        copy(begin, end - begin);
        begin = end;
    }
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

void InstanceSet::MovedPlacements::Add(uint32_t placement) {
    if (!m_isListed[placement]) m_list.push_back(placement);
    m_isListed[placement] = true;
}

void InstanceSet::MovedPlacements::Clear() {
    for (const uint32_t placement : m_list) m_isListed[placement] = false;
    m_list.clear();
}

InstanceSet::InstanceSet(rhi::Device& device, const SceneResources& resources, const scene::SceneData& data)
    : m_device(device), m_resources(resources) {
    m_instances.reserve(data.instances.size());
    const std::vector<bool> isVisible = scene::VisibleNodes(data);
    uint32_t lightCount = 0;
    for (const scene::Instance& instance : data.instances) {
        const uint32_t placed = resources.meshOf[m_instances.size()];
        const MeshResources& mesh = resources.meshes[placed];
        const auto index = static_cast<uint32_t>(m_instances.size());
        m_instances.push_back({.objectToWorld = {instance.objectToWorld, instance.translationRest},
                               .mesh = placed,
                               .firstPlacement = PlacementCount(),
                               .isVisible = scene::IsVisible(isVisible, instance)});
        for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groupCount; ++group) {
            m_placements.push_back({.instance = index, .group = group, .firstLight = lightCount});
            lightCount += static_cast<uint32_t>(resources.groups[group].emitters.size());
        }
        ExtendReach(m_instances.back());
    }
    m_slotToPlacement.resize(m_placements.size());
    std::iota(m_slotToPlacement.begin(), m_slotToPlacement.end(), 0u);
    m_placementToSlot = m_slotToPlacement;
    m_movedInRecords = m_movedInTlas = MovedPlacements(m_placements.size());

    RequirePlacements(device, m_placements.size());
    RequireBindable(device, "instances of groups of primitives", m_placements.size(),
                    sizeof(gpu::InstanceRecord));
    const uint64_t capacity = std::max<uint64_t>(1, m_placements.size());
    m_tlasInstances =
        device.CreateBuffer({.name = "TLAS instances",
                             .size = capacity * rhi::kTlasInstanceBytes,
                             .usage = rhi::BufferUsage::BuildInput | rhi::BufferUsage::CopyDestination});
    m_records = device.CreateBuffer({.name = "instances",
                                     .size = capacity * sizeof(gpu::InstanceRecord),
                                     .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopySource |
                                              rhi::BufferUsage::CopyDestination});
    m_tlas = rhi::Tlas(device, {.name = "scene TLAS", .capacity = static_cast<uint32_t>(capacity)});
}

void InstanceSet::ExtendReach(const Instance& instance) {
    const MeshResources& mesh = m_resources.meshes[instance.mesh];
    for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groupCount; ++group)
        m_reach.Extend(m_resources.groups[group].bounds.Transformed(instance.objectToWorld.matrix));
}

void InstanceSet::MoveOrigin(const glm::dvec3& origin) noexcept {
    m_origin = origin;
    m_areRecordsDue = true;
    m_needsRebuild = true;
}

void InstanceSet::SetTransform(uint32_t index, const scene::PlacedTransform& objectToWorld) {
    Instance& instance = m_instances[index];
    if (instance.objectToWorld == objectToWorld) return;
    instance.objectToWorld = objectToWorld;
    ExtendReach(instance);
    for (uint32_t group = 0; group < m_resources.meshes[instance.mesh].groupCount; ++group) {
        m_movedInRecords.Add(instance.firstPlacement + group);
        m_movedInTlas.Add(instance.firstPlacement + group);
    }
    m_needsUpdate = true;
}

void InstanceSet::MarkDeformed(uint32_t index) {
    ExtendReach(m_instances[index]);
}

void InstanceSet::SetVisible(uint32_t index, bool isVisible) {
    if (m_instances[index].isVisible == isVisible) return;
    m_instances[index].isVisible = isVisible;
    m_areRecordsDue = true;
    m_needsRebuild = true;
}

TlasWork InstanceSet::PendingWork() const {
    if (m_needsRebuild) return TlasWork::Rebuild;
    return m_needsUpdate ? TlasWork::Update : TlasWork::None;
}

rhi::TlasInstance InstanceSet::TlasInstanceOf(uint32_t placement) const {
    const Instance& instance = m_instances[m_placements[placement].instance];
    const GroupResources& group = m_resources.groups[m_placements[placement].group];
    const glm::mat4x3 objectToWorld = DeviceTransform(m_placements[placement].instance);
    rhi::TlasInstance result;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            result.objectToWorld[static_cast<size_t>(4 * row + column)] = objectToWorld[column][row];
    result.customIndex = placement;
    result.blas = instance.isVisible ? group.blas->Address() : 0;
    // A face keeps its side under a mirroring transform, for Vulkan as for glTF: nothing to flip
    result.isCullingDisabled = !group.kind.isBackCulled;
    if (group.kind.isRound) {
        result.hitSet = kHitSetCapsules;
        result.mask &= static_cast<uint8_t>(~kMaskTriangles);
    }
    return result;
}

gpu::InstanceRecord InstanceSet::RecordOf(uint32_t placement) const {
    const Placement& placed = m_placements[placement];
    gpu::InstanceRecord record = m_resources.groups[placed.group].record;
    record.objectToWorld = DeviceTransform(placed.instance);
    record.instance = placed.instance;
    record.firstLight = placed.firstLight;
    if (!m_instances[placed.instance].isVisible) record.draw = gpu::kNotDrawn;
    return record;
}

void InstanceSet::OrderSlots() {
    std::vector<glm::vec3> centers(m_placements.size());
    for (size_t i = 0; i < m_placements.size(); ++i) {
        const glm::vec3 center = m_resources.groups[m_placements[i].group].bounds.Center();
        centers[i] = DeviceTransform(m_placements[i].instance) * glm::vec4(center, 1.0f);
    }
    m_slotToPlacement = SpatialOrder(centers);
    for (uint32_t slot = 0; slot < m_slotToPlacement.size(); ++slot)
        m_placementToSlot[m_slotToPlacement[slot]] = slot;
}

void InstanceSet::RecordUpload(CommandList& commands, std::span<const uint32_t> elements, uint64_t bytes,
                               const rhi::Buffer& target,
                               const std::function<void(std::span<std::byte>)>& write) {
    if (elements.empty()) return;
    // Freed by the device once this frame has completed
    rhi::Buffer staging = m_device.CreateBuffer({.name = "instance staging",
                                                 .size = elements.size() * bytes,
                                                 .usage = rhi::BufferUsage::CopySource,
                                                 .memory = rhi::MemoryKind::Upload});
    write(staging.Mapped());
    ForEachRun(elements, [&](size_t begin, size_t runLength) {
        commands.CopyBuffer(staging, begin * bytes, target, elements[begin] * bytes, runLength * bytes);
    });
}

void InstanceSet::RecordInstanceUpload(CommandList& commands) {
    std::vector<uint32_t> placements = m_movedInRecords.List();
    if (m_areRecordsDue || IsMany(m_movedInRecords)) {
        placements.resize(m_placements.size());
        std::iota(placements.begin(), placements.end(), 0u);
    }
    std::sort(placements.begin(), placements.end());
    RecordUpload(commands, placements, sizeof(gpu::InstanceRecord), m_records,
                 [&](std::span<std::byte> staging) {
                     std::vector<gpu::InstanceRecord> records(placements.size());
                     for (size_t i = 0; i < placements.size(); ++i) records[i] = RecordOf(placements[i]);
                     std::memcpy(staging.data(), records.data(), staging.size());
                 });
}

void InstanceSet::RecordTlasInstanceUpload(CommandList& commands, TlasWork work) {
    std::vector<uint32_t> slots = m_movedInTlas.List();
    for (uint32_t& slot : slots) slot = m_placementToSlot[slot];
    if (work == TlasWork::Rebuild || IsMany(m_movedInTlas)) {
        slots.resize(m_placements.size());
        std::iota(slots.begin(), slots.end(), 0u);
    }
    std::sort(slots.begin(), slots.end());
    RecordUpload(commands, slots, rhi::kTlasInstanceBytes, m_tlasInstances,
                 [&](std::span<std::byte> staging) {
                     std::vector<rhi::TlasInstance> instances(slots.size());
                     for (size_t i = 0; i < slots.size(); ++i)
                         instances[i] = TlasInstanceOf(m_slotToPlacement[slots[i]]);
                     rhi::WriteInstances(instances, staging);
                 });
}

void InstanceSet::DeclareInstanceUpload(Renderer& renderer, SceneIds& ids) {
    ids.instances = renderer.Import("instances", m_records, m_recordsState);
    if (m_placements.empty() || (!m_areRecordsDue && m_movedInRecords.List().empty())) return;
    renderer.AddPass(
        "UploadInstances", PassKind::Transfer,
        [&](PassBuilder& pass) { ids.instances = pass.CopiesTo(ids.instances); },
        [this](CommandList& commands) {
            RecordInstanceUpload(commands);
            commands.OnSubmitted([this] {
                m_movedInRecords.Clear();
                m_areRecordsDue = false;
            });
        });
}

void InstanceSet::DeclareRefresh(Renderer& renderer, SceneIds& ids, std::function<void(TlasWork)> done) {
    ids.tlas = renderer.Import("sceneTlas", m_tlas, m_tlasState);
    DeclareInstanceUpload(renderer, ids);
    const TlasWork work = PendingWork();
    if (work == TlasWork::None) {
        renderer.OnSubmitted([done = std::move(done)] { done(TlasWork::None); });
        return;
    }

    BufferId tlasInstances = renderer.Import("TLAS instances", m_tlasInstances, m_tlasInstancesState);
    if (!m_placements.empty())
        renderer.AddPass(
            "UploadTlasInstances", PassKind::Transfer,
            [&](PassBuilder& pass) { tlasInstances = pass.CopiesTo(tlasInstances); },
            [this, work](CommandList& commands) {
                if (work == TlasWork::Rebuild) OrderSlots();
                RecordTlasInstanceUpload(commands, work);
                commands.OnSubmitted([this] { m_movedInTlas.Clear(); });
            });
    renderer.AddPass(
        "RefreshTlas", PassKind::AccelerationStructure,
        [&](PassBuilder& pass) {
            pass.BuildsFrom(tlasInstances);
            pass.BuildsFrom(ids.blases);
            ids.tlas = work == TlasWork::Update ? pass.Refits(ids.tlas) : pass.Builds(ids.tlas);
        },
        [this, work, done = std::move(done)](CommandList& commands) {
            if (work == TlasWork::Update)
                m_tlas.Update(commands, m_tlasInstances, PlacementCount());
            else
                m_tlas.Build(commands, m_tlasInstances, PlacementCount());
            commands.OnSubmitted([this, work, done] {
                if (work == TlasWork::Rebuild) m_needsRebuild = false;
                m_needsUpdate = false;
                done(work);
            });
        });
}

}  // namespace raygraph

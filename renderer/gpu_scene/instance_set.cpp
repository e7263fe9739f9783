#include "renderer/gpu_scene/instance_set.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/spatial_order.h"
#include "rhi/command_list.h"

namespace raygraph {

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

InstanceSet::InstanceSet(rhi::Device& device, const SceneResources& resources, const scene::SceneData& data,
                         TlasRule rule)
    : m_resources(resources), m_rule(rule) {
    for (const MeshResources& mesh : resources.meshes) m_meshBounds.push_back(MeshBounds(mesh));
    for (const MeshResources& mesh : resources.meshes) {
        m_lightsBefore.resize(mesh.firstGroup + mesh.groupCount);
        for (uint32_t i = 1; i < mesh.groupCount; ++i) {
            const uint32_t group = mesh.firstGroup + i;
            m_lightsBefore[group] = m_lightsBefore[group - 1] +
                                    static_cast<uint32_t>(resources.groups[group - 1].emitters.size());
        }
    }
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
                               .leaf = index,
                               .firstSlot = PlacementCount(),
                               .firstLight = lightCount,
                               .isVisible = scene::IsVisible(isVisible, instance)});
        for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groupCount; ++group) {
            m_placements.push_back({.instance = index, .group = group, .firstLight = lightCount});
            lightCount += static_cast<uint32_t>(resources.groups[group].emitters.size());
        }
        ExtendReach(m_instances.back());
    }
    m_order.resize(m_instances.size());
    std::iota(m_order.begin(), m_order.end(), 0u);
    m_movedBoxes = ChangeList(m_instances.size());

    RequirePlacements(device, m_placements.size());
    RequireBindable(device, "instances of groups of primitives", m_placements.size(),
                    sizeof(gpu::InstanceRecord));
    m_tlasInstances = RecordTable(device, {.name = "TLAS instances",
                                           .passName = "UploadTlasInstances",
                                           .recordBytes = rhi::kTlasInstanceBytes,
                                           .recordCount = m_placements.size(),
                                           .itemCount = m_instances.size(),
                                           .usage = rhi::BufferUsage::BuildInput});
    m_records = RecordTable(device, {.name = "instances",
                                     .passName = "UploadInstances",
                                     .recordBytes = sizeof(gpu::InstanceRecord),
                                     .recordCount = m_placements.size(),
                                     .itemCount = m_instances.size(),
                                     .usage = rhi::BufferUsage::CopySource});
    m_tlas = rhi::Tlas(device, {.name = "scene TLAS", .capacity = std::max(1u, PlacementCount())});
}

scene::Bounds InstanceSet::MeshBounds(const MeshResources& mesh) const {
    scene::Bounds bounds;
    for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groupCount; ++group)
        bounds.Extend(m_resources.groups[group].bounds);
    return bounds;
}

void InstanceSet::ExtendReach(const Instance& instance) {
    const MeshResources& mesh = m_resources.meshes[instance.mesh];
    for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groupCount; ++group)
        m_reach.Extend(m_resources.groups[group].bounds.Transformed(instance.objectToWorld.matrix));
}

void InstanceSet::RestartReach() {
    m_reach = {};
    for (const Instance& instance : m_instances) ExtendReach(instance);
}

void InstanceSet::MoveOrigin(const glm::dvec3& origin) noexcept {
    m_origin = origin;
    m_areBoxesOld = true;
    m_records.AddAll();
    m_needsRebuild = true;
}

void InstanceSet::SetTransform(uint32_t index, const scene::PlacedTransform& objectToWorld) {
    Instance& instance = m_instances[index];
    if (instance.objectToWorld == objectToWorld) return;
    NoteChanged(index, instance.isVisible);  // first: memory may run out
    instance.objectToWorld = objectToWorld;
    ExtendReach(instance);
}

void InstanceSet::SetVisible(uint32_t index, bool isVisible) {
    if (m_instances[index].isVisible == isVisible) return;
    NoteChanged(index, true);
    m_instances[index].isVisible = isVisible;
}

// The box of a hidden instance in the TLAS stays where it was last seen, so that it widens no boxes there.
void InstanceSet::NoteChanged(uint32_t index, bool isSeen) {
    const uint32_t placements = m_resources.meshes[m_instances[index].mesh].groupCount;
    m_records.Add(index, placements);
    if (!isSeen) return;
    m_tlasInstances.Add(index, placements);
    m_movedBoxes.Add(index);
    m_needsUpdate = true;
}

void InstanceSet::MarkDeformed(uint32_t mesh, std::span<const uint32_t> instances) {
    m_meshBounds[mesh] = MeshBounds(m_resources.meshes[mesh]);
    for (const uint32_t instance : instances) {
        ExtendReach(m_instances[instance]);
        m_movedBoxes.Add(instance);
    }
}

TlasWork InstanceSet::PendingWork() const {
    if (m_needsRebuild) return TlasWork::Rebuild;
    return m_needsUpdate ? TlasWork::Update : TlasWork::None;
}

// Instances are far apart in memory, and waiting for it would take most of the time: it is fetched ahead.
template <typename Visit>
void InstanceSet::ForEach(std::span<const uint32_t> instances, Visit&& visit) const {
    constexpr size_t kAhead = 12;
    for (size_t i = 0; i < instances.size(); ++i) {
        if (i + kAhead < instances.size()) {
            const Instance* const next = &m_instances[instances[i + kAhead]];
            __builtin_prefetch(next);
            __builtin_prefetch(&next->isVisible);
        }
        visit(instances[i], m_instances[instances[i]]);
    }
}

void InstanceSet::WriteTlasInstances(std::span<const uint32_t> instances, RecordTable::Writer& writer) const {
    ForEach(instances, [&](uint32_t index, const Instance& instance) {
        const MeshResources& mesh = m_resources.meshes[instance.mesh];
        const glm::mat4x3 objectToWorld = DeviceTransform(index);
        rhi::TlasInstance written;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column)
                written.objectToWorld[static_cast<size_t>(4 * row + column)] = objectToWorld[column][row];
        for (uint32_t i = 0; i < mesh.groupCount; ++i) {
            const GroupResources& group = m_resources.groups[mesh.firstGroup + i];
            written.customIndex = instance.firstPlacement + i;
            written.blas = group.blas->Address();
            // A face keeps its side under a mirroring transform, for Vulkan as for glTF: nothing to flip
            written.isCullingDisabled = !group.kind.isBackCulled;
            written.hitSet = group.kind.isRound ? kHitSetCapsules : kHitSetTriangles;
            written.mask = group.kind.isRound ? static_cast<uint8_t>(~kMaskTriangles) : uint8_t{0xff};
            if (!instance.isVisible) written.mask = 0;
            rhi::WriteInstances(std::span(&written, 1), writer.At(instance.firstSlot + i));
        }
    });
}

void InstanceSet::WriteRecords(std::span<const uint32_t> instances, RecordTable::Writer& writer) const {
    ForEach(instances, [&](uint32_t index, const Instance& instance) {
        const MeshResources& mesh = m_resources.meshes[instance.mesh];
        const glm::mat4x3 objectToWorld = DeviceTransform(index);
        for (uint32_t i = 0; i < mesh.groupCount; ++i) {
            gpu::InstanceRecord record = m_resources.groups[mesh.firstGroup + i].record;
            record.objectToWorld = objectToWorld;
            record.instance = index;
            record.firstLight = instance.firstLight + m_lightsBefore[mesh.firstGroup + i];
            if (!instance.isVisible) record.draw = gpu::kNotDrawn;
            std::memcpy(writer.At(instance.firstPlacement + i).data(), &record, sizeof(record));
        }
    });
}

scene::Bounds InstanceSet::BoxOf(uint32_t index) const {
    const Instance& instance = m_instances[index];
    return instance.isVisible ? m_meshBounds[instance.mesh].Transformed(DeviceTransform(index))
                              : scene::Bounds();
}

void InstanceSet::AssignBoxes() {
    std::vector<scene::Bounds> boxes(m_order.size());
    for (size_t leaf = 0; leaf < boxes.size(); ++leaf) boxes[leaf] = BoxOf(m_order[leaf]);
    m_boxes.Assign(std::move(boxes));
    m_movedBoxes.Clear();
    m_areBoxesOld = false;
}

void InstanceSet::RefreshBoxes() {
    if (m_areBoxesOld) return AssignBoxes();
    // Boxes are fetched ahead too, once the instances have told where they are
    ForEach(m_movedBoxes.List(),
            [&](uint32_t, const Instance& instance) { m_boxes.Prefetch(instance.leaf); });
    ForEach(m_movedBoxes.List(),
            [&](uint32_t index, const Instance& instance) { m_boxes.Set(instance.leaf, BoxOf(index)); });
    m_boxes.Refresh();
    m_movedBoxes.Clear();
}

scene::Bounds InstanceSet::VisibleBounds() {
    RefreshBoxes();
    return m_boxes.Root();
}

bool InstanceSet::IsRebuildWorthwhile() {
    if (m_rule != TlasRule::Decay) return m_rule == TlasRule::Always && m_needsUpdate;
    RefreshBoxes();
    return m_quality.NoteFrame(m_boxes.Cost(), m_instances.size());
}

void InstanceSet::Order() {
    std::vector<glm::vec3> centers(m_instances.size());
    for (uint32_t i = 0; i < centers.size(); ++i) {
        const scene::Bounds& mesh = m_meshBounds[m_instances[i].mesh];
        const glm::vec3 center = mesh.IsEmpty() ? glm::vec3(0.0f) : mesh.Center();
        centers[i] = DeviceTransform(i) * glm::vec4(center, 1.0f);
    }
    m_order = SpatialOrder(centers);
    uint32_t slot = 0;
    for (uint32_t leaf = 0; leaf < m_order.size(); ++leaf) {
        Instance& instance = m_instances[m_order[leaf]];
        instance.leaf = leaf;
        instance.firstSlot = slot;
        slot += m_resources.meshes[instance.mesh].groupCount;
    }
    AssignBoxes();
    m_quality.NoteBuild(m_boxes.Cost());
}

void InstanceSet::DeclareRefresh(Renderer& renderer, SceneIds& ids, std::function<void(TlasWork)> done) {
    ids.tlas = renderer.Import("sceneTlas", m_tlas, m_tlasState);
    ids.instances = m_records.DeclareUpload(
        renderer, m_records.Import(renderer),
        {.write = [this](std::span<const uint32_t> items, RecordTable::Writer& writer) {
            WriteRecords(items, writer);
        }});
    if (IsRebuildWorthwhile()) m_needsRebuild = true;
    const TlasWork work = PendingWork();
    if (work == TlasWork::None) {
        renderer.OnSubmitted([done = std::move(done)] { done(TlasWork::None); });
        return;
    }

    const bool isRebuild = work == TlasWork::Rebuild;
    if (isRebuild) m_tlasInstances.AddAll();
    const BufferId tlasInstances = m_tlasInstances.DeclareUpload(
        renderer, m_tlasInstances.Import(renderer),
        {.prepare =
             [this, isRebuild] {
                 if (isRebuild) Order();
             },
         .write = [this](std::span<const uint32_t> items,
                         RecordTable::Writer& writer) { WriteTlasInstances(items, writer); }});
    renderer.AddPass(
        "RefreshTlas", PassKind::AccelerationStructure,
        [&](PassBuilder& pass) {
            pass.BuildsFrom(tlasInstances);
            pass.BuildsFrom(ids.blases);
            ids.tlas = isRebuild ? pass.Builds(ids.tlas) : pass.Refits(ids.tlas);
        },
        [this, work, isRebuild, done = std::move(done)](CommandList& commands) {
            if (isRebuild)
                m_tlas.Build(commands, m_tlasInstances.Buffer(), PlacementCount());
            else
                m_tlas.Update(commands, m_tlasInstances.Buffer(), PlacementCount());
            commands.OnSubmitted([this, work, isRebuild, done] {
                if (isRebuild) m_needsRebuild = false;
                m_needsUpdate = false;
                done(work);
            });
        });
}

}  // namespace raygraph

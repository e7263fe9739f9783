// The work of a LightSet in a frame: the tables follow the edits, and the device follows the tables.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/lights/light_set.h"

namespace raygraph {
namespace {

// Rounds to four steps per octave: light sampling needs no more, and a moving instance then makes the tables
// dirty only when it crosses from one step to the next, not in every frame of an animation.
float CoarseRadius(float radius) {
    return radius > 0.0f ? std::exp2(std::round(4.0f * std::log2(radius)) / 4.0f) : 0.0f;
}

}  // namespace

void LightSet::Reserve(Records& records, RecordTableDesc desc) {
    const size_t capacity = records.table.Capacity();
    if (desc.capacity <= capacity && capacity > 0) return;
    desc.capacity = GrownCount(m_device, desc.name, desc.capacity, capacity, desc.recordBytes);
    desc.usage = rhi::BufferUsage::CopySource;
    records.table = RecordTable(m_device, desc);
    records.changed = ChangeList(desc.capacity);
    records.table.AddAll();
}

void LightSet::ReserveAlias(uint64_t count) {
    constexpr const char* kName = "light alias";
    constexpr uint64_t kBytes = sizeof(gpu::AliasEntry);
    const uint64_t capacity = m_alias ? m_alias.Size() / kBytes : 0;
    if (count <= capacity && capacity > 0) return;
    m_alias = CreateTable(m_device, kName, GrownCount(m_device, kName, count, capacity, kBytes), kBytes);
    m_aliasState = {};
    m_aliasDirty = m_meshAliasDirty = true;
}

void LightSet::ReserveTables(const LightCounts& counts) {
    const uint64_t records = counts.lights + counts.triangles;
    Reserve(m_lights, {.name = "lights",
                       .passName = "UploadLights",
                       .recordBytes = sizeof(gpu::LightRecord),
                       .capacity = records});
    Reserve(m_nodes, {.name = "lightNodes",
                      .passName = "UploadLightNodes",
                      .recordBytes = sizeof(gpu::LightNode),
                      .capacity = 2 * records});
    ReserveAlias(3 * (counts.lights + 1) + 2 * counts.triangles);
    m_meshes.Reserve(counts.meshes);
    m_statistics.tableBytes = m_lights.table.Capacity() * sizeof(gpu::LightRecord) +
                              m_nodes.table.Capacity() * sizeof(gpu::LightNode) + m_alias.Size() +
                              m_meshes.DeviceBytes();
}

bool LightSet::HasInfiniteLight() const {
    return m_scene.environmentRadiance != glm::vec3(0.0f) ||
           std::ranges::any_of(m_scene.punctual, [](const scene::Light& light) {
               return light.type == scene::LightType::Directional;
           });
}

void LightSet::NoteChanges(const LightTableChanges& changes) {
    if (changes.IsEmpty()) return;
    if (changes.isAll || changes.allRecordsChanged) {
        m_lights.table.AddAll();
        m_nodes.table.AddAll();
    } else {
        for (const uint32_t light : changes.lights) m_lights.changed.Add(light);
        for (const uint32_t node : changes.nodes) m_nodes.changed.Add(node);
    }
    if (changes.isAll) {
        m_meshes.Assign(std::vector(m_table.Meshes()));
        m_statistics.bytesUploaded += m_meshes.Records().size_bytes();
        m_meshAliasDirty = true;
    }
    m_aliasDirty |= changes.isAll || changes.isAlias;
    ++(changes.isRebuilt ? m_statistics.rebuilds : m_statistics.updates);
}

// A small tree is rebuilt in less than the variation of a frame's time, and then a view, too, depends on the
// current scene alone. A new origin does not change the topology of any tree.
bool LightSet::MayRefit() const {
    constexpr size_t kSmallTree = 1024;
    if (m_rule == LightRule::Always) return false;
    return m_table.Set().boundedCount > kSmallTree ||
           (m_edits.placements.empty() && m_edits.punctual.empty());
}

void LightSet::UpdateTable(InstanceSet& instances) {
    Number();
    // The radius is that of the current scene, so that pictures do not depend on what was shown before
    if (HasInfiniteLight()) {
        const float radius = CoarseRadius(instances.VisibleBounds().Radius());
        m_edits.powersDirty |= radius != m_scene.radius;
        m_scene.radius = radius;
    }
    m_edits.placements.assign(m_changedPlacements.List().begin(), m_changedPlacements.List().end());
    m_edits.punctual.assign(m_changedPunctual.List().begin(), m_changedPunctual.List().end());
    LightTableChanges changes;
    const bool isDue = !m_edits.IsEmpty();
    try {
        if (isDue) changes = m_table.Update(m_scene, m_edits, MayRefit());
        if (m_rule == LightRule::Decay && m_table.UpdateDecay()) m_table.BuildTree(m_scene, changes);
        NoteChanges(changes);
    } catch (...) {
        m_edits.isAll = true;  // memory has run out meanwhile
        throw;
    }
    m_edits = {.isAll = false};
    m_changedPlacements.Clear();
    m_changedPunctual.Clear();
    const auto tell = [&](const EmitterPlacement& placement) {
        if (placement.isRemoved) return;
        const uint32_t isMesh = m_scene.isShared[placement.group] ? gpu::kFirstLightIsMesh : 0u;
        instances.SetFirstLight(placement.record, placement.firstLight | isMesh);
    };
    if (m_numbersChanged)
        std::ranges::for_each(m_scene.placements, tell);
    else
        for (const uint32_t i : m_newPlacements) tell(m_scene.placements[i]);
    m_numbersChanged = false;
    m_newPlacements.clear();
}

void LightSet::Declare(Renderer& renderer, SceneIds& ids, InstanceSet& instances) {
    UpdateTable(instances);
    ids.lightSet = m_table.SetIn(m_scene);
    ids.lightGroupCount = gpu::kLightGroupNamed + m_scene.lightGroups.namedCount;
    ids.punctualLights = static_cast<uint32_t>(m_scene.punctual.size());
    ids.triangleLights = ids.lightSet.lightCount - ids.punctualLights;
    // The feature is needed even if no light is sampled: hits find the group of their light by it
    if (!m_table.Meshes().empty()) ids.features |= kTraceMeshLights;
    if (ids.lightSet.activeCount > 0) {
        ids.features |= kTraceLightSampling;
        if (ids.triangleLights > 0) ids.features |= kTraceTriangleLights;
        if (ids.punctualLights > 0) ids.features |= kTracePunctualLights;
        if (!m_scene.profiles.words.empty()) ids.features |= kTraceLightProfiles;
        if (ids.lightSet.hasEnvironment != 0u) ids.features |= kTraceEnvironmentLight;
    }
    ids.lightProfiles = renderer.Import("lightProfiles", m_profiles, m_profilesState);
    ids.lights = DeclareUpload(renderer, m_lights, m_table.LightCount(),
                               [this](uint32_t index) { return m_table.LightAt(index); });
    ids.lightNodes = DeclareUpload(renderer, m_nodes, m_table.NodeCount(),
                                   [this](uint32_t index) { return m_table.NodeAt(index); });
    ids.lightAlias = renderer.Import("lightAlias", m_alias, m_aliasState);
    ids.lightMeshes = m_meshes.Declare(renderer);
    if (!m_aliasDirty) return;
    renderer.AddPass(
        "UploadLightAlias", PassKind::Transfer,
        [&](PassBuilder& pass) { ids.lightAlias = pass.CopiesTo(ids.lightAlias); },
        [this](CommandList& commands) {
            RecordAlias(commands);
            commands.OnSubmitted([this] { m_aliasDirty = m_meshAliasDirty = false; });
        });
}

// Uploads the changed records of a table. Changes beyond the table's end are ignored.
template <typename At>
BufferId LightSet::DeclareUpload(Renderer& renderer, Records& records, size_t count, At&& at) {
    const auto write = [this, count, at](uint32_t index, RecordTable::Writer& writer) {
        const auto record = index < count ? at(index) : decltype(at(index)){};
        std::memcpy(writer.At(index).data(), &record, sizeof(record));
        m_statistics.bytesUploaded += sizeof(record);
    };
    records.table.SetCount(count);
    return records.table.DeclareUpload(
        renderer, records.table.Import(renderer),
        {.changed = records.changed.List().size(),
         .write =
             [&records, count, write](bool areAll, RecordTable::Writer& writer) {
                 for (uint32_t i = 0; areAll && i < count; ++i) write(i, writer);
                 if (areAll) return;
                 for (const uint32_t i : records.changed.List()) write(i, writer);
             },
         .done = [&records] { records.changed.Clear(); }});
}

void LightSet::RecordAlias(CommandList& commands) {
    const std::span<const gpu::AliasEntry> ofMeshes(m_table.MeshAlias());
    const TableCopy copies[] = {
        {std::as_bytes(std::span(m_table.Alias())), m_alias},
        {std::as_bytes(m_meshAliasDirty ? ofMeshes : ofMeshes.first(0)), m_alias,
         m_table.FirstMeshAlias() * sizeof(gpu::AliasEntry)},
    };
    for (const TableCopy& copy : copies) m_statistics.bytesUploaded += copy.bytes.size();
    RecordCopies(commands, m_device, "light staging", copies);
}

}  // namespace raygraph

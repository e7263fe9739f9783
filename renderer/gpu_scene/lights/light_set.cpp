#include "renderer/gpu_scene/lights/light_set.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/text.h"
#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/instances/group_kinds.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/scene/model/check.h"

namespace raygraph {

namespace {

// Sets the position of `light` to that of `placed`, which is in world space, relative to the origin.
void PlaceFromOrigin(scene::Light& light, const scene::Light& placed, const glm::dvec3& origin) {
    light.lightToWorld =
        scene::PlacedTransform{placed.lightToWorld, placed.translationResidual}.RelativeTo(origin);
    light.translationResidual = glm::vec3(0.0f);
}

}  // namespace

LightSet::LightSet(rhi::Device& device, rhi::Uploader& uploader, SceneGeometry& geometry,
                   std::span<const InstanceSet::Placement> placements, const scene::SceneData& data,
                   LightRule rule)
    : m_device(device), m_rule(rule), m_meshes(device, "lightMeshes", "UploadLightMeshes") {
    for (uint32_t i = 0; i < data.materials.size(); ++i) AddMaterial(i, data.materials[i].EmittedRadiance());
    std::vector<bool> isDeformed(geometry.groups.size());
    for (const MeshResources& mesh : geometry.meshes)
        for (uint32_t i = 0; mesh.isDeformed && i < mesh.groupCount; ++i)
            isDeformed[mesh.firstGroup + i] = true;
    for (uint32_t i = 0; i < geometry.groups.size(); ++i)
        AddGroup(i, std::move(geometry.groups[i].emitters), geometry.groups[i].emitterVariants,
                 isDeformed[i]);
    const std::vector<bool> isVisible = scene::VisibleNodes(data);
    for (const scene::Instance& instance : data.instances)
        m_scene.instances.push_back(
            {.objectToWorld = instance.objectToWorld, .isVisible = scene::IsVisible(isVisible, instance)});
    for (uint32_t i = 0; i < placements.size(); ++i) {
        const LightScene::Instance instance = m_scene.instances[placements[i].instance];
        Place(i, placements[i].instance, placements[i].group, instance.objectToWorld, instance.isVisible);
    }
    m_scene.punctual = m_punctual = data.lights;
    for (const scene::Light& light : data.lights)
        m_scene.isPunctualHidden.push_back(!scene::IsVisible(isVisible, light.node));
    m_scene.profiles = MakeProfileTable(data.profiles);
    Number();
    const std::vector<float>& words = m_scene.profiles.words;
    m_profiles = CreateTable(device, "light profiles", words.size(), sizeof(float));
    if (!words.empty()) uploader.UploadBuffer(m_profiles, 0, std::as_bytes(std::span(words)));
}

void LightSet::AddMaterial(uint32_t material, const glm::vec3& radiance) {
    const size_t count = std::max<size_t>(m_scene.emission.size(), material + size_t{1});
    m_scene.emission.resize(count);
    m_isEmitterMaterial.resize(count);
    m_scene.emission[material] = radiance;
    m_isEmitterMaterial[material] = false;
    AssignToRest(m_scene.lightGroups.materials, material);
}

// A new object at the index of a removed one is in none of the host's groups.
void LightSet::AssignToRest(std::vector<uint32_t>& groups, uint32_t index) {
    if (index < groups.size()) groups[index] = gpu::kLightGroupRest;
}

void LightSet::RemoveGroup(uint32_t group) noexcept {
    if (group >= m_scene.groups.size() || m_scene.groups[group].empty()) return;
    m_scene.groups[group].clear();
    m_scene.isShared[group] = false;
}

void LightSet::AddGroup(uint32_t group, std::vector<Emitter> emitters,
                        std::span<const EmitterVariant> variants, bool isDeformed) {
    if (group >= m_scene.groups.size()) {
        m_scene.groups.resize(group + size_t{1});
        m_scene.isDeformed.resize(m_scene.groups.size());
        m_scene.isShared.resize(m_scene.groups.size());
        m_placementCounts.resize(m_scene.groups.size());
    }
    m_numberingDirty |= !emitters.empty();
    for (const Emitter& emitter : emitters) m_isEmitterMaterial[emitter.material] = true;
    for (const EmitterVariant& variant : variants) m_isEmitterMaterial[variant.material] = true;
    m_scene.groups[group] = std::move(emitters);
    m_scene.isDeformed[group] = isDeformed;
}

// Returns an upper bound of the lights that Number makes of the group.
LightSet::LightCounts LightSet::CountsOf(uint32_t group, uint32_t placementCount) const {
    const size_t emitters = m_scene.groups[group].size();
    const bool isShared = m_scene.Shares(group, placementCount) ||
                          (StaysShared() && m_scene.isShared[group] && placementCount > 1);
    if (isShared) return {.lights = placementCount, .triangles = emitters, .meshes = 1};
    return {.lights = placementCount * emitters};
}

// Returns the counts of all placements, with `placementCount` placements of this group.
LightSet::LightCounts LightSet::CountsAfter(uint32_t group, uint32_t placementCount) const {
    const LightCounts before = CountsOf(group, m_placementCounts[group]);
    const LightCounts after = CountsOf(group, placementCount);
    return {.lights = m_counts.lights - before.lights + after.lights,
            .triangles = m_counts.triangles - before.triangles + after.triangles,
            .meshes = m_counts.meshes - before.meshes + after.meshes};
}

void LightSet::AddPlacement(uint32_t record, uint32_t instance, uint32_t group,
                            const glm::mat4x3& objectToWorld, bool isVisible) {
    if (m_scene.groups[group].empty()) return;
    LightCounts counts = CountsAfter(group, m_placementCounts[group] + 1);
    const uint32_t own = LightsOfOne(group);
    const auto free = m_removed.find(own);
    const bool isReused = free != m_removed.end() && !free->second.empty();
    counts.lights += m_removedLights - (isReused ? own : 0) + m_scene.punctual.size();
    ReserveTables(counts);
    Place(record, instance, group, objectToWorld, isVisible);
    AssignToRest(m_scene.lightGroups.instances, instance);
}

void LightSet::Place(uint32_t record, uint32_t instance, uint32_t group, const glm::mat4x3& objectToWorld,
                     bool isVisible) {
    if (m_scene.groups[group].empty()) return;
    // Everything that may fail comes first
    if (instance >= m_scene.instances.size()) m_scene.instances.resize(instance + size_t{1});
    if (instance >= m_firstPlacement.size()) m_firstPlacement.resize(m_scene.instances.size(), kNone);
    // Reuses a removed placement with as many light numbers, so that all others keep theirs
    std::vector<uint32_t>& removed = m_removed[LightsOfOne(group)];
    const bool isNew = removed.empty();
    const auto index = isNew ? static_cast<uint32_t>(m_scene.placements.size()) : removed.back();
    if (m_scene.isDeformed[group]) m_deformedPlacements[group].push_back(index);
    if (isNew) {
        ReserveMore(m_nextPlacement, 1);
        m_scene.placements.emplace_back();
        m_nextPlacement.push_back(kNone);
    } else {
        ReserveMore(m_newPlacements, 1);
        m_changedPlacements.Reserve(1);
    }

    EmitterPlacement& placement = m_scene.placements[index];
    placement = {.record = record,
                 .instance = instance,
                 .group = group,
                 .firstLight = placement.firstLight,
                 .lightCount = placement.lightCount};
    m_numberingDirty |= isNew || m_rule == LightRule::Always;
    if (!isNew) {
        removed.pop_back();
        m_removedLights -= placement.lightCount;
        m_newPlacements.push_back(index);
        if (!m_numberingDirty) m_changedPlacements.Add(index);
    }
    m_nextPlacement[index] = m_firstPlacement[instance];
    m_firstPlacement[instance] = index;
    m_scene.instances[instance] = {.objectToWorld = objectToWorld, .isVisible = isVisible};
    m_counts = CountsAfter(group, m_placementCounts[group] + 1);
    ++m_placementCounts[group];
}

void LightSet::ReserveRemoval(uint32_t instance) {
    if (!IsEmitter(instance)) return;
    size_t count = 0;
    for (uint32_t i = m_firstPlacement[instance]; i != kNone; i = m_nextPlacement[i]) ++count;
    for (uint32_t i = m_firstPlacement[instance]; i != kNone; i = m_nextPlacement[i])
        ReserveMore(m_removed[m_scene.placements[i].lightCount], count);
    m_changedPlacements.Reserve(count);
}

void LightSet::RemovePlacements(uint32_t instance) {
    if (!IsEmitter(instance)) return;
    for (uint32_t i = m_firstPlacement[instance]; i != kNone; i = m_nextPlacement[i]) {
        EmitterPlacement& placement = m_scene.placements[i];
        m_removed[placement.lightCount].push_back(i);
        placement.isRemoved = true;
        m_removedLights += placement.lightCount;
        m_counts = CountsAfter(placement.group, m_placementCounts[placement.group] - 1);
        --m_placementCounts[placement.group];
        if (!m_numberingDirty) m_changedPlacements.Add(i);
    }
    m_firstPlacement[instance] = kNone;
    m_numberingDirty |= m_rule == LightRule::Always || IsMostlyRemoved();
}

uint32_t LightSet::AddPunctual(const scene::Light& values, bool isVisible, LightOwner place) {
    const bool isNew = m_removedPunctual.empty();
    const auto index = isNew ? PunctualCount() : m_removedPunctual.back();
    auto [inWorld, fromOrigin] = Checked(values, index, place);
    if (isNew) {
        LightCounts counts = m_counts;
        counts.lights += m_removedLights + m_scene.punctual.size() + 1;
        ReserveTables(counts);
        ReserveMore(m_punctual, 1);
        ReserveMore(m_scene.punctual, 1);
        m_scene.isPunctualHidden.push_back(true);
        m_punctual.emplace_back();
        m_scene.punctual.emplace_back();
        m_numberingDirty = true;
    } else {
        m_changedPunctual.Reserve(1);
        m_removedPunctual.pop_back();
        if (!m_numberingDirty) m_changedPunctual.Add(index);
    }
    SetPunctual(index, std::move(inWorld), std::move(fromOrigin));
    m_scene.isPunctualHidden[index] = !isVisible;
    AssignToRest(m_scene.lightGroups.lights, index);
    return index;
}

void LightSet::RemovePunctual(uint32_t light) {
    ReserveMore(m_removedPunctual, 1);
    SetPunctualVisible(light, false);
    m_removedPunctual.push_back(light);
}

bool LightSet::IsMostlyRemoved() const {
    return 2 * m_removedLights > m_numberedLights;
}

// With the rule Always, the placements are the existing ones in the order of their records. Otherwise removed
// placements stay until they outnumber the others.
void LightSet::DropRemoved() {
    const bool isAlways = m_rule == LightRule::Always;
    const bool isOrdered =
        !isAlways || std::ranges::is_sorted(m_scene.placements, {}, &EmitterPlacement::record);
    if (isOrdered && (m_removedLights == 0 || (!isAlways && !IsMostlyRemoved()))) return;
    std::erase_if(m_scene.placements, [](const EmitterPlacement& placement) { return placement.isRemoved; });
    if (isAlways) std::ranges::sort(m_scene.placements, {}, &EmitterPlacement::record);
    m_removed.clear();
    m_removedLights = 0;
    m_deformedPlacements.clear();
    m_nextPlacement.assign(m_scene.placements.size(), kNone);
    std::ranges::fill(m_firstPlacement, kNone);
    for (uint32_t i = 0; i < m_scene.placements.size(); ++i) {
        const EmitterPlacement& placement = m_scene.placements[i];
        uint32_t& first = m_firstPlacement[placement.instance];
        m_nextPlacement[i] = std::exchange(first, i);
        if (m_scene.isDeformed[placement.group]) m_deformedPlacements[placement.group].push_back(i);
    }
}

void LightSet::Number() {
    if (!m_numberingDirty) return;
    m_edits.isAll = true;
    DropRemoved();
    m_numberedLights = m_scene.NumberEmitters(StaysShared());
    LightCounts counts{.lights = m_numberedLights + m_scene.punctual.size()};
    m_firstPlacement.resize(m_scene.instances.size(), kNone);
    m_changedPlacements = ChangeList(m_scene.placements.size());
    m_changedPunctual = ChangeList(m_scene.punctual.size());
    for (size_t i = 0; i < m_scene.groups.size(); ++i) {
        if (!m_scene.isShared[i]) continue;
        counts.triangles += m_scene.groups[i].size();
        ++counts.meshes;
    }
    ReserveTables(counts);
    m_numbersChanged = true;
    m_numberingDirty = false;
}

void LightSet::MarkInstanceDirty(uint32_t instance) {
    for (uint32_t i = m_firstPlacement[instance]; i != kNone && !m_numberingDirty; i = m_nextPlacement[i])
        m_changedPlacements.Add(i);
}

void LightSet::SetTransform(uint32_t instance, const glm::mat4x3& objectToWorld) {
    glm::mat4x3& transform = m_scene.instances[instance].objectToWorld;
    if (transform == objectToWorld) return;
    MarkInstanceDirty(instance);
    transform = objectToWorld;
}

void LightSet::SetVisible(uint32_t instance, bool isVisible) {
    if (!IsEmitter(instance)) return;
    MarkInstanceDirty(instance);
    m_scene.instances[instance].isVisible = isVisible;
}

void LightSet::SetEmission(uint32_t material, const glm::vec3& radiance) {
    glm::vec3& old = m_scene.emission[material];
    if (old == radiance) return;
    old = radiance;
    m_edits.isAll |= m_isEmitterMaterial[material];
}

void LightSet::SetPose(uint32_t group, const OutlinePose& pose) {
    if (m_scene.groups[group].empty()) return;
    PoseEmitters(pose, m_scene.groups[group]);
    if (const auto placed = m_deformedPlacements.find(group);
        placed != m_deformedPlacements.end() && !m_numberingDirty)
        for (const uint32_t i : placed->second) m_changedPlacements.Add(i);
}

void LightSet::SetSides(uint32_t material, bool isDoubleSided) {
    if (!m_isEmitterMaterial[material]) return;
    for (std::vector<Emitter>& group : m_scene.groups)
        for (Emitter& emitter : group) {
            if (emitter.material != material || emitter.isDoubleSided == isDoubleSided) continue;
            emitter.isDoubleSided = isDoubleSided;
            m_edits.isAll = true;
        }
}

void LightSet::SetVariant(const SceneGeometry& geometry, std::span<const gpu::MaterialRecord> materials) {
    for (size_t i = 0; i < geometry.groups.size(); ++i) {
        const GroupResources& group = geometry.groups[i];
        for (const EmitterVariant& variant : group.emitterVariants) {
            if (group.parts[variant.geometry].material != variant.material) continue;
            Emitter& emitter = m_scene.groups[i][variant.emitter];
            m_edits.isAll |= emitter.material != variant.material;
            emitter.material = variant.material;
            emitter.meanTexture = variant.meanTexture;
            emitter.isDoubleSided = !IsBackCulled(materials[variant.material]);
        }
    }
}

std::pair<scene::Light, scene::Light> LightSet::Checked(const scene::Light& values, uint32_t light,
                                                        LightOwner place) const {
    const std::string subject = Text("GpuScene: SetLight: light {}", light);
    scene::Check(values, subject);
    if (const size_t count = m_scene.profiles.firstWords.size();
        values.profile != scene::kNone && values.profile >= count)
        throw MakeError(ErrorKind::Usage, "{}: profile is {}, there are {}", subject, values.profile, count);
    // The transform from a file may be degenerate; one that a host sets must have a direction
    if (place == LightOwner::OfHost)
        scene::CheckTransform({values.lightToWorld, values.translationResidual}, subject);
    scene::Light fromOrigin = values;
    PlaceFromOrigin(fromOrigin, values, m_origin);
    return {values, std::move(fromOrigin)};
}

void LightSet::SetPunctual(uint32_t light, const scene::Light& values, LightOwner place) {
    auto [inWorld, fromOrigin] = Checked(values, light, place);
    if (!m_numberingDirty) m_changedPunctual.Add(light);
    SetPunctual(light, std::move(inWorld), std::move(fromOrigin));
}

void LightSet::SetPunctual(uint32_t light, scene::Light&& inWorld, scene::Light&& fromOrigin) {
    const auto isDirectional = [](const scene::Light& of) {
        return of.type == scene::LightType::Directional;
    };
    // The order of the lights changes.
    m_edits.isAll |= isDirectional(m_punctual[light]) != isDirectional(inWorld);
    m_punctual[light] = std::move(inWorld);
    m_scene.punctual[light] = std::move(fromOrigin);
}

void LightSet::SetPunctualVisible(uint32_t light, bool isVisible) {
    if (IsPunctualVisible(light) == isVisible) return;
    if (!m_numberingDirty) m_changedPunctual.Add(light);
    m_scene.isPunctualHidden[light] = !isVisible;
}

void LightSet::MoveOrigin(const glm::dvec3& origin, const InstanceSet& instances) noexcept {
    m_origin = origin;
    for (uint32_t i = 0; i < m_scene.instances.size(); ++i)
        m_scene.instances[i].objectToWorld = instances.DeviceTransform(i);
    for (size_t i = 0; i < m_punctual.size(); ++i)
        PlaceFromOrigin(m_scene.punctual[i], m_punctual[i], origin);
    m_edits.transformsDirty = true;
}

void LightSet::SetGroups(LightGroups groups) {
    m_scene.lightGroups = std::move(groups);
    m_edits.isAll = true;
}

void LightSet::SetEnvironment(const glm::vec3& meanRadiance, float skyIrradiance, float rotation,
                              glm::uvec2 cells) {
    m_edits.powersDirty |= m_scene.environmentRadiance != meanRadiance;
    m_scene.environmentRadiance = meanRadiance;
    m_scene.skyIrradiance = skyIrradiance;
    m_scene.environmentRotation = rotation;
    m_scene.environmentWidth = cells.x;
    m_scene.environmentHeight = cells.y;
}

// --- The work of a frame: the tables follow the edits, and the device follows the tables ---

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

void LightSet::AddDirtyRecords(const LightTableChanges& changes) {
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
    const bool hasEdits = !m_edits.IsEmpty();
    try {
        if (hasEdits) changes = m_table.Update(m_scene, m_edits, MayRefit());
        if (m_rule == LightRule::Decay && m_table.UpdateDecay()) m_table.BuildTree(m_scene, changes);
        AddDirtyRecords(changes);
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
             [&records, count, write](bool writesAll, RecordTable::Writer& writer) {
                 for (uint32_t i = 0; writesAll && i < count; ++i) write(i, writer);
                 if (writesAll) return;
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

#include "renderer/gpu_scene/instances/scene_objects.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/geometry/mesh_packing.h"
#include "renderer/gpu_scene/host_objects.h"
#include "renderer/gpu_scene/instances/group_kinds.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/scene/model/check.h"

namespace raygraph {
namespace {

VkDeviceAddress AddressOf(const HostStream& stream) {
    return stream ? stream.buffer->Address() + stream.offset : 0;
}

}  // namespace

SceneObjects::SceneObjects(SceneContext& context, std::unique_ptr<SceneMaterials> newMaterials,
                           std::unique_ptr<SceneGeometry> newGeometry, const scene::SceneData& data)
    : m_context(context),
      materials(std::move(newMaterials)),
      geometry(std::move(newGeometry)),
      instances(context.device, *geometry, data),
      blases(context.builder, *geometry, instances),
      draws(context.device, *geometry, instances),
      lights(context.device, context.uploader, *geometry, instances.Placements(), data,
             context.desc.lightRule),
      setInstances(data.instances.size()),
      setMaterials(data.materials.size()),
      setLights(data.lights.size()),
      firstExtendedLight(data.lights.size()) {
    draws.Upload(context.uploader);
    if (geometry->deform) deform.emplace(context.device, *geometry, instances);
    context.builder.Reserve();
    owners.meshes.Reset(data.meshes.size());
    owners.instances.Reset(data.instances.size());
    owners.materials.Reset(data.materials.size());
    owners.lights.Reset(data.lights.size());
    MoveOrigin(ChooseSceneOrigin({}, glm::dvec3(0.0), instances.Reach()));
    if (context.traversal != Traversal::Software) return;
    trees.emplace(context.device, context.desc.lightRule == LightRule::Decay);
    trees->Follow(*geometry, instances);
    WriteLog(context.device.Log(), LogLevel::Debug, log_category::kGeometry,
             "trees for software traversal: {}",
             trees->UnavailableReason().empty() ? BytesText(trees->Bytes()) : trees->UnavailableReason());
}

void SceneObjects::RequireInstance(uint32_t instance) const {
    RequireIndex("instance", instance, instances.Count());
    if (!instances.Exists(instance))
        throw MakeError(ErrorKind::Usage, "GpuScene: instance {} has been removed", instance);
}

void SceneObjects::RequireMesh(uint32_t mesh) const {
    RequireIndex("mesh", mesh, geometry->meshes.size());
    if (!geometry->HasMesh(mesh) || geometry->meshes[mesh].isCopy)
        throw MakeError(ErrorKind::Usage, "GpuScene: mesh {} has been removed", mesh);
}

void SceneObjects::RequireMaterial(uint32_t material) const {
    RequireIndex("material", material, materials->Size());
    if (!materials->Exists(material))
        throw MakeError(ErrorKind::Usage, "GpuScene: material {} has been removed", material);
}

void SceneObjects::RequireTexture(uint32_t texture) const {
    RequireIndex("texture", texture, materials->Textures().Size());
    if (!materials->Textures().Exists(texture))
        throw MakeError(ErrorKind::Usage, "GpuScene: texture {} has been removed", texture);
}

void SceneObjects::RequireLight(uint32_t light) const {
    RequireIndex("light", light, lights.PunctualCount());
    if (!lights.HasPunctual(light))
        throw MakeError(ErrorKind::Usage, "GpuScene: light {} has been removed", light);
}

void SceneObjects::RequireMatrices(const char* call, uint32_t skin, size_t count) const {
    const std::vector<SkinMatrices> none;
    const std::vector<SkinMatrices>& skins = geometry->deform ? geometry->deform->skins : none;
    RequireIndex("skin", skin, skins.size());
    if (count != skins[skin].count)
        throw MakeError(ErrorKind::Usage, "GpuScene: {}: {} matrices for skin {}, which has {}", call, count,
                        skin, skins[skin].count);
}

void SceneObjects::RequireWeights(const char* call, uint32_t instance, size_t count) const {
    RequireInstance(instance);
    if (!deform)
        throw MakeError(ErrorKind::Usage, "GpuScene: {}: instance {} is not deformed", call, instance);
    if (count != deform->WeightCount(instance))
        throw MakeError(ErrorKind::Usage, "GpuScene: {}: {} for instance {}, which has {}", call,
                        Counted(count, "weight"), instance, deform->WeightCount(instance));
}

bool SceneObjects::IsDeformed(uint32_t instance) const {
    return geometry->meshes[instances.MeshOf(instance)].isDeformed && deform && deform->IsDeformed(instance);
}

bool SceneObjects::CanBePlaced(uint32_t mesh) const {
    return std::ranges::all_of(geometry->GroupsOf(geometry->meshes[mesh]),
                               [](const GroupResources& group) { return group.blas || group.hostBlas != 0; });
}

bool SceneObjects::Emits(uint32_t mesh) const {
    for (const GroupResources& group : geometry->GroupsOf(geometry->meshes[mesh]))
        for (const GroupPart& part : group.parts)
            if (materials->Records()[part.material].emission != glm::vec3(0.0f)) return true;
    return false;
}

// --- Adding single objects.

uint32_t SceneObjects::AddMaterial(const scene::Material& material, std::span<const uint32_t> textures) {
    const uint32_t number = materials->Add({&material, 1}, textures).front();
    try {
        lights.AddMaterial(number, material.EmittedRadiance());
    } catch (...) {
        materials->Remove(number);
        throw;
    }
    ++m_context.revisions.materials;
    return number;
}

void SceneObjects::ReserveBuilds(uint32_t mesh) {
    try {
        m_context.builder.Reserve();
    } catch (...) {
        ReleaseMesh(mesh);
        throw;
    }
}

uint32_t SceneObjects::AddMesh(std::vector<GroupResources>&& uploaded) {
    const uint32_t number = geometry->AddMesh(std::move(uploaded), *materials);
    const MeshResources& mesh = geometry->meshes[number];
    try {
        instances.AddMesh(number);
        for (uint32_t i = mesh.firstGroup; i < mesh.firstGroup + mesh.groupCount; ++i) {
            GroupResources& group = geometry->groups[i];
            lights.AddGroup(i, std::move(group.emitters), group.emitterVariants, false);
            draws.Add(group);
        }
    } catch (...) {
        ReleaseMesh(number);
        throw;
    }
    blases.MarkUnbuilt();
    ++m_context.revisions.geometry;
    return number;
}

// The mesh is packed as a part would be that has only the materials which the mesh uses.
uint32_t SceneObjects::AddMesh(scene::Mesh&& mesh) {
    std::vector<uint32_t> used;
    for (const scene::Primitive& primitive : mesh.primitives) {
        RequireMaterial(primitive.material);
        if (!primitive.variants.empty())
            throw Error(ErrorKind::Usage, "GpuScene: AddMesh: variants go with a scene");
        used.push_back(primitive.material);
    }
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (scene::Primitive& primitive : mesh.primitives)
        primitive.material =
            static_cast<uint32_t>(std::ranges::lower_bound(used, primitive.material) - used.begin());
    scene::SceneData part;
    PackingMaterials packing;
    for (const uint32_t material : used) {
        packing.records.push_back(materials->Records()[material]);
        packing.textureAlphas.push_back(materials->TextureAlphas()[material]);
        const gpu::MaterialRecord& record = materials->Records()[material];
        // The texels of an emissive texture have been freed: assume that it is not black
        const bool hasTexture = record.emissiveTexture != gpu::kNoTexture;
        part.materials.emplace_back().emissiveFactor = hasTexture ? glm::vec3(1.0f) : record.emission;
    }
    part.meshes.push_back(std::move(mesh));
    scene::Check(part, "GpuScene: AddMesh");
    EmitterFinder finder(part);
    PackedMesh packed = PackMesh(
        part.meshes.front(), packing,
        {.tree = m_context.traversal == Traversal::Software ? WideBvhUse::Tree : WideBvhUse::None}, finder);
    std::optional<uint32_t> number;
    try {
        m_context.uploader.FlushAfter([&] {
            MeshUpload upload(m_context, m_context.uploader, {&packed, 1}, used);
            uint64_t budget = UINT64_MAX;
            upload.Continue(0, budget);
            number = AddMesh(upload.Take());
        });
    } catch (...) {
        if (number) ReleaseMesh(*number);
        throw;
    }
    ReserveBuilds(*number);
    return *number;
}

uint32_t SceneObjects::AddMesh(const HostMesh& mesh) {
    std::vector<GroupResources> uploaded(1);
    GroupResources& group = uploaded.front();
    group.parts.push_back({.material = mesh.material, .lowestAlpha = mesh.colors ? mesh.lowestAlpha : 1.0f});
    group.kind = KindOf(group.parts, materials->Records(), materials->TextureAlphas());
    group.record.positions = AddressOf(mesh.positions);
    group.record.indices = AddressOf(mesh.indices);
    group.triangleCount = mesh.triangleCount;
    group.bounds = mesh.bounds;
    group.records.push_back({.normals = AddressOf(mesh.normals),
                             .tangents = AddressOf(mesh.tangents),
                             .frameTurns = 0,
                             .uv0 = AddressOf(mesh.uv0),
                             .uv1 = AddressOf(mesh.uv1),
                             .colors = AddressOf(mesh.colors),
                             .primitives = 0,
                             .material = mesh.material,
                             .tangentSet = gpu::kTangentsOfAllMaps});
    group.hostBlas = mesh.blas;
    if (mesh.blas == 0) {
        rhi::BlasDesc blas;
        blas.name = mesh.name;
        blas.kind = mesh.isDeforming ? rhi::BlasKind::Deforming : rhi::BlasKind::Static;
        blas.triangles.push_back({.vertices = group.record.positions,
                                  .vertexCount = mesh.vertexCount,
                                  .indices = group.record.indices,
                                  .triangleCount = mesh.triangleCount});
        SetFlags(blas, group.kind);
        group.blas = m_context.builder.Add(blas);
    }
    const uint32_t number = AddMesh(std::move(uploaded));
    ReserveBuilds(number);
    return number;
}

uint32_t SceneObjects::AddInstance(uint32_t mesh, const scene::PlacedTransform& objectToWorld,
                                   bool isVisible) {
    std::vector<uint32_t>* const placing = IsHostMesh(mesh) ? &m_hostPlacements[mesh] : nullptr;
    if (placing) ReserveMore(*placing, 1);
    const bool isFirst = instances.Reach().IsEmpty();
    const uint32_t number = instances.Add(mesh, objectToWorld, isVisible);
    try {
        const MeshResources& placed = geometry->meshes[mesh];
        const uint32_t firstPlacement = instances.FirstPlacement(number);
        for (uint32_t i = 0; i < placed.groupCount; ++i)
            lights.AddPlacement(firstPlacement + i, number, placed.firstGroup + i,
                                instances.DeviceTransform(number), isVisible);
    } catch (...) {
        lights.RemovePlacements(number);
        instances.Remove(number);
        throw;
    }
    if (placing) placing->push_back(number);
    if (isFirst) RestartOrigin();
    ++geometry->meshes[mesh].instanceCount;
    draws.MarkCountsDirty();
    ++m_context.revisions.geometry;
    return number;
}

uint32_t SceneObjects::AddLight(const scene::Light& light, bool isVisible, LightOwner place) {
    const uint32_t number = lights.AddPunctual(light, isVisible, place);
    ++m_context.revisions.lights;
    return number;
}

// --- Removing single objects that nothing uses.

void SceneObjects::RemoveInstance(uint32_t instance) {
    const uint32_t mesh = instances.MeshOf(instance);
    lights.ReserveRemoval(instance);
    instances.Remove(instance);
    lights.RemovePlacements(instance);
    if (const auto placing = m_hostPlacements.find(mesh); placing != m_hostPlacements.end())
        std::erase(placing->second, instance);
    owners.instances.Release(instance);
    m_context.environment.Sources().instances.erase(instance);
    --geometry->meshes[mesh].instanceCount;
    draws.MarkCountsDirty();
    ++m_context.revisions.geometry;
}

void SceneObjects::ReleaseMesh(uint32_t number) noexcept {
    const MeshResources& mesh = geometry->meshes[number];
    for (uint32_t i = mesh.firstGroup; i < mesh.firstGroup + mesh.groupCount; ++i) {
        lights.RemoveGroup(i);
        draws.Remove(geometry->groups[i]);
    }
    blases.Unmark(number);
    m_hostPlacements.erase(number);
    owners.meshes.Release(number);
    geometry->RemoveMesh(number, *materials);
}

void SceneObjects::RemoveLight(uint32_t light) {
    lights.RemovePunctual(light);
    owners.lights.Release(light);
    m_context.environment.Sources().lights.erase(light);
    ++m_context.revisions.lights;
}

void SceneObjects::RemoveMaterial(uint32_t material) {
    materials->Remove(material);
    owners.materials.Release(material);
    ++m_context.revisions.materials;
}

void SceneObjects::RemoveTexture(uint32_t texture) {
    materials->RemoveTexture(texture);
    owners.textures.Release(texture);
}

bool SceneObjects::IsMeshUsed(uint32_t mesh) const {
    return geometry->meshes[mesh].instanceCount > 0 || geometry->meshes[mesh].isDeformed;
}

void SceneObjects::Remove(const AddedPart& part) {
    if (part.owner <= kOwnedByScene) return;
    m_context.environment.Sources().parts.erase(part.owner);
    for (const uint32_t light : part.lights)
        if (owners.lights.Of(light) == part.owner) RemoveLight(light);
    for (const uint32_t instance : part.instances)
        if (owners.instances.Of(instance) == part.owner) RemoveInstance(instance);
    for (const uint32_t mesh : part.meshes)
        if (owners.meshes.Of(mesh) == part.owner && !IsMeshUsed(mesh)) ReleaseMesh(mesh);
    for (const uint32_t material : part.materials)
        if (owners.materials.Of(material) == part.owner && materials->PartCount(material) == 0)
            RemoveMaterial(material);
    for (const uint32_t texture : part.textures)
        if (owners.textures.Of(texture) == part.owner && materials->MaterialCount(texture) == 0)
            RemoveTexture(texture);
}

bool SceneObjects::IsHostMesh(uint32_t mesh) const {
    const MeshResources& found = geometry->meshes[mesh];
    return found.groupCount == 1 && !found.isDeformed && !geometry->groups[found.firstGroup].streams;
}

uint32_t SceneObjects::AddTexture(const HostTexture& texture) {
    const auto image = std::make_shared<SceneImage>(
        SceneImage{.hostTexture = texture.texture, .lowestAlpha = texture.lowestAlpha});
    const SceneTexture added{image, texture.sampler};
    return materials->AddTextures({&added, 1}).front();
}

// --- Edits.

void SceneObjects::SetTransforms(std::span<const uint32_t> indices,
                                 std::span<const scene::PlacedTransform> objectToWorld) {
    if (!instances.SetTransforms(indices, objectToWorld)) return;
    ++m_context.revisions.transforms;
    for (const uint32_t instance : indices)
        if (lights.IsEmitter(instance)) lights.SetTransform(instance, instances.DeviceTransform(instance));
}

void SceneObjects::SetVisible(std::span<const uint32_t> indices, bool isVisible) {
    if (!instances.SetVisible(indices, isVisible)) return;
    ++m_context.revisions.geometry;
    for (const uint32_t instance : indices) lights.SetVisible(instance, isVisible);
}

void SceneObjects::SetMaterial(uint32_t material, const gpu::MaterialRecord& record) {
    SceneMaterials::ChangedRecord changed{material, record, materials->TextureAlphas()[material]};
    const KindChanges changes = ChangeMaterials(*geometry, *materials, m_context.builder,
                                                {&changed, 1});  // everything that may fail comes first
    ++m_context.revisions.materials;
    lights.SetEmission(material, record.emission);
    lights.SetSides(material, !IsBackCulled(record));
    Follow(changes);
}

void SceneObjects::Follow(const KindChanges& changes) {
    if (changes.structuresChanged) blases.MarkReplaced();
    if (!changes.sidesChanged) return;
    ++m_context.revisions.geometry;
    draws.MarkNumbersDirty();
}

void SceneObjects::SwapTextures(std::span<const uint32_t> a, std::span<const uint32_t> b) {
    std::vector<SceneMaterials::ChangedRecord> changed = materials->ChangedBySwap(a, b);
    const KindChanges changes =  // what may fail comes first
        ChangeMaterials(*geometry, *materials, m_context.builder, changed);
    materials->SwapTextures(a, b);
    if (changed.empty()) return;
    ++m_context.revisions.materials;
    ++m_context.revisions.geometry;  // alpha comes from another texture
    Follow(changes);
}

void SceneObjects::SetVariant(uint32_t variant) {
    const KindChanges changes =
        // Everything that may fail comes first.
        ChangeVariant(*geometry, *materials, m_context.builder, variant);
    ++m_context.revisions.materials;
    ++m_context.revisions.geometry;  // alpha may come from another texture, even if culling has not changed
    lights.SetVariant(*geometry, materials->Records());
    if (changes.structuresChanged) blases.MarkReplaced();
    if (changes.sidesChanged) draws.MarkNumbersDirty();
}

void SceneObjects::SetViewpoint(const glm::dvec3& eye) {
    const glm::dvec3 wanted = ChooseSceneOrigin(m_origin, eye, instances.Reach());
    if (m_originHysteresis.Moves(m_origin, wanted)) MoveOrigin(wanted);
}

void SceneObjects::RestartOrigin() {
    instances.RestartReach();
    m_originHysteresis = {};
    const glm::dvec3 wanted = ChooseSceneOrigin({}, glm::dvec3(0.0), instances.Reach());
    if (wanted != m_origin) MoveOrigin(wanted);
}

void SceneObjects::MoveOrigin(const glm::dvec3& wanted) {
    m_origin = wanted;
    instances.MoveOrigin(wanted);
    lights.MoveOrigin(wanted, instances);
}

void SceneObjects::MarkChanged(uint32_t mesh, const scene::Bounds& bounds) {
    GroupResources& group = geometry->groups[geometry->meshes[mesh].firstGroup];
    const std::vector<uint32_t>& placing = m_hostPlacements[mesh];
    blases.MarkVerticesDirty(mesh);
    group.bounds = bounds;
    draws.SetBounds(group);
    instances.MarkDeformed(mesh, placing);
    ++m_context.revisions.geometry;
}

glm::dvec3 ChooseSceneOrigin(const glm::dvec3& current, const glm::dvec3& eye, const scene::Bounds& scene) {
    if (scene.IsEmpty()) return current;
    const glm::dvec3 nearest = glm::clamp(eye, glm::dvec3(scene.min), glm::dvec3(scene.max));
    bool isFar = false;
    for (int axis = 0; axis < 3; ++axis) {
        if (!std::isfinite(nearest[axis])) return current;
        isFar |= std::abs(nearest[axis] - current[axis]) > kOriginGrid;
    }
    return isFar ? kOriginGrid * glm::round(nearest / kOriginGrid) : current;
}

bool OriginHysteresis::Moves(const glm::dvec3& current, const glm::dvec3& wanted) {
    if (current == wanted) {
        m_farCount = 0;
        return false;
    }
    ++m_farCount;
    const glm::dvec3 way = glm::abs(wanted - current);
    const bool isBeyondReach = std::max({way.x, way.y, way.z}) > kOriginReach;
    if (!isBeyondReach && m_farCount < kFarViewpointsToMove) return false;
    m_farCount = 0;
    return true;
}

// --- The work of each frame ---

void SceneObjects::Declare(Renderer& renderer, SceneIds& ids) {
    draws.Refresh(*geometry, instances);
    ids.origin = m_origin;
    m_context.environment.Declare(renderer, ids, lights);
    ids.geometries = geometry->records.Declare(renderer);
    materials->Declare(renderer, ids, *geometry);
    ids.placementCount = instances.RecordCount();
    ids.blases = renderer.ImportBlasSet("BLASes", m_context.blasState);
    if (deform) deform->DeclareDeformation(renderer, ids, lights, draws);
    draws.Declare(renderer, ids);
    blases.Declare(renderer, ids, deform ? &*deform : nullptr);
    if (trees) {
        trees->Follow(*geometry, instances);
        trees->Declare(renderer, ids);
    }
    lights.Declare(renderer, ids, instances);
    blases.BeginFrame();
    instances.DeclareRefresh(renderer, ids, [this](TlasWork work) {
        blases.MarkUsed();
        GpuSceneStatistics& statistics = m_context.statistics;
        statistics.lastTlasWork = work;
        statistics.tlasUpdates += work == TlasWork::Update ? 1 : 0;
        statistics.tlasRebuilds += work == TlasWork::Rebuild ? 1 : 0;
    });
}

bool SceneObjects::IsSettled() const {
    return blases.IsSettled() && (!deform || !deform->HasWork());
}

void SceneObjects::RefreshStatistics() const {
    GpuSceneStatistics& statistics = m_context.statistics;
    const rhi::CompactionStatistics blas = m_context.builder.Statistics();
    statistics.blasCount = blas.blasCount;
    statistics.blasBytesBuilt = blas.bytesBuilt;
    statistics.blasBytesCompacted = blas.bytesCompacted;
    statistics.compactionsPending = blas.pending;
    statistics.isCompactionOff = blas.isOff;
    statistics.compactionDisabledReason = blas.disabledReason;
    statistics.blasBuilds = blas.buildCount;
    statistics.blasRefits = blas.refitCount;
    statistics.blasRebuilds = blas.rebuildCount;
    statistics.deformations = deform ? deform->DeformCount() : 0;
    statistics.textureBytes = materials->Textures().Bytes();
    statistics.reducedTextures = materials->Textures().ReducedImages();
    statistics.geometryCount = static_cast<uint32_t>(geometry->records.Size());
    statistics.geometryBytes = geometry->streamBytes;
    statistics.deformedMeshes = deform ? static_cast<uint32_t>(geometry->deform->meshes.size()) : 0;
    statistics.instanceCount = instances.ExistingCount();
    statistics.trianglesUnique = statistics.trianglesPlaced = 0;
    for (const MeshResources& mesh : geometry->meshes) {
        if (!mesh.isCopy) statistics.trianglesUnique += mesh.triangleCount;
        statistics.trianglesPlaced += mesh.triangleCount * mesh.instanceCount;
    }
    statistics.tlasBytes = instances.TlasBytes();
    statistics.wideTreeBytes = trees ? trees->Bytes() : 0;
    statistics.noWideBvhReason = trees ? trees->UnavailableReason() : "the driver's traversal is used";
    statistics.lightCount = lights.LightCount();
    statistics.emissiveTriangleCount = lights.EmissiveTriangleCount();
    const LightStatistics& tables = lights.Statistics();
    statistics.lightRebuilds = tables.rebuilds;
    statistics.lightUpdates = tables.updates;
    statistics.lightTableBytes = tables.tableBytes;
    statistics.lightBytesUploaded = tables.bytesUploaded;
}

}  // namespace raygraph

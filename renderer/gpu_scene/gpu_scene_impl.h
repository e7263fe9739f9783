// What a GpuScene holds, and the work that its frames declare. For gpu_scene.cpp alone.
#pragma once

#include <algorithm>
#include <list>
#include <map>
#include <optional>
#include <utility>

#include "base/stopwatch.h"
#include "base/text.h"
#include "renderer/gpu_scene/deform_set.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/draw_table.h"
#include "renderer/gpu_scene/energy_tables.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/group_kinds.h"
#include "renderer/gpu_scene/instance_set.h"
#include "renderer/gpu_scene/light_set.h"
#include "renderer/gpu_scene/part_owners.h"
#include "renderer/gpu_scene/part_upload.h"
#include "renderer/gpu_scene/prepared_scene.h"
#include "renderer/gpu_scene/scene_content.h"
#include "renderer/gpu_scene/scene_environment.h"
#include "renderer/gpu_scene/scene_materials.h"
#include "renderer/gpu_scene/scene_origin.h"
#include "renderer/gpu_scene/scene_upload_content.h"
#include "renderer/gpu_scene/texture_upload.h"
#include "renderer/gpu_scene/wide_set.h"
#include "rhi/blas_builder.h"
#include "rhi/upload.h"

namespace raygraph {

struct GpuScene::Impl {
    Impl(Renderer& r, const GpuSceneDesc& sceneDesc)
        : desc(sceneDesc),
          device(r.Device()),
          traversal(desc.traversal == Traversal::Auto ? FasterTraversal(device) : desc.traversal),
          uploader(device),
          environment(device, uploader),
          builder(device, {.name = "scene BLASes",
                           .scratchBudget = desc.scratchBudget,
                           .compactionBudget = desc.compactionBudget}) {
        defaultTexture = WhiteTexture(device, uploader);
        defaultSampler = device.CreateSampler({.name = "default sampler"});
        const auto tables = std::as_bytes(EnergyTables());
        constexpr auto kTableUsage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination;
        energyTables =
            device.CreateBuffer({.name = "energy tables", .size = tables.size(), .usage = kTableUsage});
        uploader.UploadBuffer(energyTables, 0, tables);
        SceneContent nothing;
        SetContent(nothing);
    }

    // Create the new scene first, so that an Error leaves the old one in place.
    void SetContent(SceneContent& content);
    void Finish(SceneUpload::Content& content);
    void Replace(SceneContent& content, ResourceUpload& upload, const Stopwatch& watch);
    ResourceSettings SettingsOfResources() const;
    PrepareSettings Preparing() const {
        return {.makesTrees = traversal == Traversal::Own, .measuresLight = desc.measuresLight};
    }
    TextureUploadSettings TextureSettings(uint64_t budget) const {
        return {.hasLevels = desc.textureLevels, .budget = budget, .maxAnisotropy = desc.maxAnisotropy};
    }

    // Objects that come and go: gpu_scene_parts.cpp, and gpu_scene_objects.cpp for what has a call of its
    // own. Arguments are checked.
    AddedPart Add(PreparedScene&& part);
    std::shared_ptr<const AddedPart> Stream(PreparedScene&& part);
    uint32_t AddMaterial(const scene::Material& material, std::span<const uint32_t> textures);
    uint32_t AddMesh(UploadedMesh&& uploaded);
    // The memory of its BLASes; without it, forgets the mesh.
    void ReserveBuilds(uint32_t mesh);
    uint32_t AddMesh(scene::Mesh&& mesh);
    uint32_t AddMesh(const HostMesh& mesh);
    uint32_t AddTexture(const HostTexture& texture);
    uint32_t AddInstance(uint32_t mesh, const scene::PlacedTransform& objectToWorld, bool isVisible);
    uint32_t AddLight(const scene::Light& light, bool isVisible, LightPlace place);
    void RemoveInstance(uint32_t instance);
    void ForgetMesh(uint32_t mesh) noexcept;
    void RemoveMaterial(uint32_t material);
    void RemoveTexture(uint32_t texture);
    void RemoveLight(uint32_t light);
    void Remove(const AddedPart& part);
    void MarkChanged(uint32_t mesh, const scene::Bounds& bounds);
    bool IsMeshUsed(uint32_t mesh) const;
    bool IsShowable(uint32_t mesh) const;
    bool IsOfHost(uint32_t mesh) const;
    bool IsDeformed(uint32_t instance) const;
    bool Emits(uint32_t mesh) const;
    // Error{Usage} for what does not exist, or not any more.
    void RequireInstance(uint32_t instance) const;
    void RequireMesh(uint32_t mesh) const;
    void RequireMaterial(uint32_t material) const;
    void RequireTexture(uint32_t texture) const;
    void RequireLight(uint32_t light) const;

    PartUpload BeginPart(const char* call, PreparedScene&& part, rhi::Uploader& with);
    // Goes on, and counts down the budget. True: all of it is there.
    bool Continue(PartUpload& part, uint64_t& budget);
    bool BringTexture(PartUpload& part, uint32_t texture, uint64_t& budget);
    bool BringMaterial(PartUpload& part, uint32_t material, uint64_t& budget);
    bool BringMesh(PartUpload& part, uint32_t mesh, uint64_t& budget);
    rhi::Uploader& StreamUploader();
    // The first that has an owner, and something to copy; null: none.
    std::shared_ptr<SceneUpload> NextUpload();
    void ContinueUpload(SceneUpload::Content& content, uint64_t& budget);
    bool ContinueStream(PartUpload& part, uint64_t& budget);
    void ContinueStreams();
    // A part of this owner streams.
    bool IsOnItsWay(uint32_t owner) const;
    // Error{Usage} for what a part that streams may still need.
    void RequireArrived(const char* what, uint32_t index, const Owners& of) const {
        if (IsOnItsWay(of.Of(index)))
            throw MakeError(ErrorKind::Usage, "GpuScene: {} {} cannot be removed: its part is on its way",
                            what, index);
    }
    void EndStream(std::list<PartUpload>::iterator part);

    SceneIds Declare(Renderer& renderer);
    // Error{Usage} naming the call for a skin or an instance that has not as many, or does not exist.
    void RequireMatrices(const char* call, uint32_t skin, size_t count) const;
    void RequireWeights(const char* call, uint32_t instance, size_t count) const;

    void SetViewpoint(const glm::dvec3& eye) {
        const glm::dvec3 wanted = ChooseSceneOrigin(origin, eye, instances->Reach());
        if (originTurns.Moves(origin, wanted)) MoveOrigin(wanted);
    }
    // As if the scene had been set as it is now.
    void RestartOrigin() {
        instances->RestartReach();
        originTurns = {};
        const glm::dvec3 wanted = ChooseSceneOrigin({}, glm::dvec3(0.0), instances->Reach());
        if (wanted != origin) MoveOrigin(wanted);
    }
    void MoveOrigin(const glm::dvec3& wanted) {
        origin = wanted;
        instances->MoveOrigin(wanted);
        lights->MoveOrigin(wanted, *instances);
    }

    void SetMaterial(uint32_t material, const gpu::MaterialRecord& record) {
        const KindChanges changes =
            ChangeMaterial(*geometry, *materials, builder, material, record);  // everything that may fail
        ++revisions.materials;
        lights->SetEmission(material, record.emission);
        lights->SetSides(material, !IsBackCulled(record));
        areAddressesDue |= changes.areStructures;
        hasUnbuiltBlases |= changes.areStructures;
        if (!changes.areSides) return;
        ++revisions.geometry;
        areDrawNumbersDue = true;
    }

    void SetVariant(uint32_t variant) {
        const KindChanges changes =
            ChangeVariant(*geometry, *materials, builder, variant);  // everything that may fail
        ++revisions.materials;
        ++revisions.geometry;  // alpha of another texture, if not sides
        lights->SetVariant(*geometry, materials->Records());
        areAddressesDue |= changes.areStructures;
        hasUnbuiltBlases |= changes.areStructures;
        areDrawNumbersDue |= changes.areSides;
    }

    // Done again where memory runs out.
    void RefreshDraws() {
        if (areDrawNumbersDue) {
            instances->MarkGroupsChanged();
            draws.Renumber(*geometry, *instances);
        } else if (areDrawsDue) {
            draws.Refresh(*geometry, *instances);
        }
        areDrawsDue = areDrawNumbersDue = false;
    }

    // An edit would change or destroy what the open frame was declared from.
    void RequireNoFrame(const char* call) {
        if (!declaredIn.expired())
            throw MakeError(
                ErrorKind::Usage,
                "GpuScene: {} between Declare and Execute; it comes before Declare or after Execute", call);
        areStructuresUsed = true;  // until a frame has shown what the edit asks for
    }

    void DeclareBlasWork(Renderer& r, SceneIds& ids) {
        const bool hasCompactions = builder.Poll();
        // The addresses are known once the passes record: the instances are written after that
        if (areAddressesDue || hasCompactions) instances->MarkStructuresChanged();
        areAddressesDue = false;
        if (hasUnbuiltBlases)
            r.AddPass(
                "BuildBlas", PassKind::AccelerationStructure,
                [&](PassBuilder& pass) {
                    if (deform) pass.BuildsFrom(ids.deformedStreams);
                    ids.blases = pass.Builds(ids.blases);
                },
                [this](CommandList& commands) {
                    std::vector<DeformedGroup*> deformed;
                    if (deform) deformed = deform->Unbuilt();
                    areStructuresUsed = true;
                    builder.RecordBuilds(commands);
                    commands.OnSubmitted([this, deformed = std::move(deformed)] {
                        hasUnbuiltBlases = false;
                        DeformSet::NoteBuilt(deformed);
                    });
                });
        if (deform) deform->DeclareRefits(r, ids, builder);
        if (!changedHostMeshes.empty()) DeclareHostRebuilds(r, ids);
        if (hasCompactions)
            r.AddPass(
                "CompactBlas", PassKind::AccelerationStructure,
                [&](PassBuilder& pass) { ids.blases = pass.Builds(ids.blases); },
                [this](CommandList& commands) { builder.RecordCompaction(commands); });
    }

    void DeclareHostRebuilds(Renderer& r, SceneIds& ids) {
        instances->MarkRefitted();
        r.AddPass(
            "RebuildHostBlas", PassKind::AccelerationStructure,
            [&](PassBuilder& pass) { ids.blases = pass.Refits(ids.blases); },
            [this](CommandList& commands) {
                std::vector<rhi::BlasBuilder::RefitRequest> requests;
                for (const uint32_t mesh : changedHostMeshes)
                    requests.push_back(
                        {.blas = geometry->groups[geometry->meshes[mesh].firstGroup].blas.get(),
                         .desc = {},
                         .rebuilds = true});
                builder.RecordRefits(commands, requests);
                commands.OnSubmitted([this] { changedHostMeshes.clear(); });
            });
    }

    void RefreshStatistics() {
        const rhi::CompactionStatistics blas = builder.Statistics();
        statistics.blasCount = blas.blasCount;
        statistics.blasBytesBuilt = blas.bytesBuilt;
        statistics.blasBytesCompacted = blas.bytesCompacted;
        statistics.compactionsPending = blas.pending;
        statistics.isCompactionOff = blas.isOff;
        statistics.whyCompactionOff = blas.whyOff;
        statistics.blasBuilds = blas.buildCount;
        statistics.blasRefits = blas.refitCount;
        statistics.blasRebuilds = blas.rebuildCount;
        statistics.deformations = deform ? deform->DeformCount() : 0;
        statistics.textureBytes = materials->Textures().Bytes();
        statistics.reducedTextures = materials->Textures().ReducedImages();
        statistics.geometryCount = static_cast<uint32_t>(geometry->records.Size());
        statistics.geometryBytes = geometry->streamBytes;
        statistics.deformedMeshes = deform ? static_cast<uint32_t>(geometry->deform->meshes.size()) : 0;
        statistics.instanceCount = instances->ExistingCount();
        statistics.trianglesUnique = statistics.trianglesPlaced = 0;
        for (const MeshResources& mesh : geometry->meshes) {
            if (!mesh.isCopy) statistics.trianglesUnique += mesh.triangleCount;
            statistics.trianglesPlaced += mesh.triangleCount * mesh.instanceCount;
        }
        statistics.tlasBytes = instances->TlasBytes();
        statistics.wideTreeBytes = trees ? trees->Bytes() : 0;
        statistics.whyNoWideTrees = trees ? trees->WhyNone() : "the driver's traversal is used";
        statistics.lightCount = lights->LightCount();
        statistics.emissiveTriangleCount = lights->EmissiveTriangleCount();
        const LightStatistics& tables = lights->Statistics();
        statistics.lightRebuilds = tables.rebuilds;
        statistics.lightUpdates = tables.updates;
        statistics.lightTableBytes = tables.tableBytes;
        statistics.lightBytesUploaded = tables.bytesUploaded;
    }

    GpuSceneDesc desc;
    rhi::Device& device;
    const Traversal traversal;  // Driver or Own
    rhi::Uploader uploader;
    SceneEnvironment environment;
    rhi::BlasBuilder builder;
    Disposer disposer;
    rhi::Texture defaultTexture;
    rhi::Sampler defaultSampler;
    rhi::Buffer energyTables;
    std::unique_ptr<SceneMaterials> materials;
    std::unique_ptr<SceneGeometry> geometry;
    std::unique_ptr<InstanceSet> instances;  // refers to geometry: declared after it
    std::unique_ptr<LightSet> lights;
    std::unique_ptr<DeformSet> deform;  // null: nothing is deformed; refers to both
    std::unique_ptr<WideSet> trees;     // null: of Traversal::Driver
    DrawTable draws;
    glm::dvec3 origin{0.0};
    OriginTurns originTurns;
    std::weak_ptr<const void> declaredIn;  // the frame that is open; expired: none
    bool hasUnbuiltBlases = false;
    // Of the last frame: something read the device's structures that it had to build or refresh.
    bool areStructuresUsed = true;
    bool areAddressesDue = false;   // BLASes of instances that are in the TLAS have been replaced
    bool areDrawsDue = false;       // groups or placements have come or gone
    std::list<PartUpload> streams;  // the first is on its way
    std::list<std::weak_ptr<SceneUpload>> uploads;  // likewise; before streams
    std::optional<rhi::Uploader> streamUploader;
    std::list<TextureUpload> endedTextures;  // that the device still works on
    ObjectOwners owners;
    uint32_t lastOwner = kOwnedByScene;
    std::map<uint32_t, std::vector<uint32_t>> hostPlacements;  // instances, by mesh of the host's
    uint64_t streamedBytes = 0;               // of parts that are complete, since something streams
    std::vector<uint32_t> changedHostMeshes;  // whose BLASes are to be rebuilt in place
    bool areDrawNumbersDue = false;  // kinds of groups have changed, or there are more than there is room for
    struct {
        size_t instances = 0, materials = 0, lights = 0;
    } set;  // what SetScene brought: poses are of these
    SceneRevisions revisions;

    ResourceState energyTablesState;
    ResourceState blasState;
    GpuSceneStatistics statistics;
};

}  // namespace raygraph

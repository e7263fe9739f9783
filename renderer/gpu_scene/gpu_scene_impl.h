// What a GpuScene holds, and the work that its frames declare. For gpu_scene.cpp alone.
#pragma once

#include <algorithm>
#include <optional>
#include <utility>

#include "base/stopwatch.h"
#include "base/text.h"
#include "renderer/gpu_scene/deform_set.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/device_table.h"
#include "renderer/gpu_scene/dirty_range.h"
#include "renderer/gpu_scene/draw_table.h"
#include "renderer/gpu_scene/energy_tables.h"
#include "renderer/gpu_scene/environment_upload.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/group_kinds.h"
#include "renderer/gpu_scene/instance_set.h"
#include "renderer/gpu_scene/light_set.h"
#include "renderer/gpu_scene/scene_origin.h"
#include "renderer/gpu_scene/scene_resources.h"
#include "renderer/gpu_scene/texture_upload.h"
#include "renderer/scene/check.h"
#include "rhi/blas_builder.h"
#include "rhi/texture_table.h"
#include "rhi/upload.h"

namespace raygraph {

struct GpuScene::Impl {
    Impl(Renderer& r, const GpuSceneDesc& sceneDesc)
        : desc(sceneDesc),
          device(r.Device()),
          uploader(device),
          builder(device, {.name = "scene BLASes",
                           .scratchBudget = desc.scratchBudget,
                           .compactsWithoutGain = desc.compactsWithoutGain,
                           .compactionBudget = desc.compactionBudget}) {
        defaultTexture = WhiteTexture(device, uploader);
        defaultSampler = device.CreateSampler({.name = "default sampler"});
        const auto tables = std::as_bytes(EnergyTables());
        constexpr auto kTableUsage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination;
        energyTables =
            device.CreateBuffer({.name = "energy tables", .size = tables.size(), .usage = kTableUsage});
        uploader.UploadBuffer(energyTables, 0, tables);
        blank = BlankEnvironment(device, uploader);
        Replace(scene::SceneData{});
    }

    // Creates the new scene first, so that an Error leaves the old one in place.
    void Replace(scene::SceneData&& data) {
        const Stopwatch watch;
        scene::Check(data, "GpuScene: SetScene");
        CheckLimits(device, data);
        device.CollectGarbage();  // room that there is already
        const TextureUploadSettings textures{
            .hasLevels = desc.textureLevels,
            .budget = desc.textureBudget > 0 ? desc.textureBudget : DefaultTextureBudget(device),
            .maxAnisotropy = desc.maxAnisotropy,
            .defaultTexture = &defaultTexture,
            .defaultSampler = &defaultSampler};
        std::unique_ptr<SceneResources> newResources;
        std::unique_ptr<InstanceSet> newInstances;
        std::unique_ptr<LightSet> newLights;
        std::unique_ptr<DeformSet> newDeform;
        DrawTable newDraws;
        std::optional<EnvironmentOnDevice> newEnvironment;
        try {
            uploader.FlushAfter([&] {
                newResources = UploadScene(device, uploader, builder, data, textures);
                newInstances = std::make_unique<InstanceSet>(device, *newResources, data, desc.tlasRule);
                newDraws = MakeDrawTable(device, uploader, *newResources, newInstances->Placements());
                newLights = std::make_unique<LightSet>(device, uploader, *newResources,
                                                       newInstances->Placements(), data);
                if (newResources->deform)
                    newDeform = std::make_unique<DeformSet>(device, *newResources, *newInstances);
                if (data.environment.IsPresent())
                    newEnvironment = UploadEnvironment(device, uploader, data.environment.map);
                builder.Reserve();  // a frame that ran out of it could not be drawn, nor the next one
            });
        } catch (...) {
            data.meshes.clear();  // some are freed by now: a retry would lack them
            throw;
        }
        const glm::dvec3 newOrigin = ChooseSceneOrigin({}, glm::dvec3(0.0), newInstances->Reach());
        newInstances->MoveOrigin(newOrigin);
        newLights->MoveOrigin(newOrigin, *newInstances);
        deform = std::move(newDeform);
        lights = std::move(newLights);
        instances = std::move(newInstances);
        resources = std::move(newResources);
        draws = std::move(newDraws);
        builder.Trim();
        if (newEnvironment || sceneEnvironment) {
            sceneEnvironment = std::move(newEnvironment);
            ++environmentVersion;
        }
        data.environment = {};
        areDrawsDue = false;
        origin = newOrigin;
        originTurns = {};
        drawsState = {};
        hasUnbuiltBlases = true;
        dirtyMaterials = {};
        areGeometriesDue = false;
        ++revisions.geometry;
        geometriesState = {};
        materialsState = {};
        statistics.uploadMs = watch.Milliseconds();
        statistics.instanceCount = instances->Count();
        statistics.geometryCount = resources->geometryCount;
        statistics.geometryBytes = resources->geometryBytes;
        statistics.textureBytes = resources->textureBytes;
        statistics.textureBudget = textures.budget;
        statistics.reducedTextures = resources->reducedTextures;
        statistics.trianglesUnique = TriangleCount(*resources);
        statistics.trianglesPlaced = TriangleCount(*resources, data.instances);
        if (!resources->textureReduction.empty())
            device.Log().Send(LogLevel::Warning, log_category::kScene, resources->textureReduction);
        if (statistics.instanceCount > 0)
            Say(device.Log(), LogLevel::Info, log_category::kScene,
                "{} triangles in {} instances are uploaded in {}", statistics.trianglesPlaced,
                statistics.instanceCount, DurationText(watch.Seconds()));
    }

    void SetEnvironmentMap(const image::ImageF& equirectangular);
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
            ChangeMaterial(*resources, builder, material, record);  // everything that may fail
        ++revisions.materials;
        dirtyMaterials.Add(material);
        lights->SetEmission(material, record.emission);
        lights->SetSides(material, !IsBackCulled(record));
        hasUnbuiltBlases |= changes.areStructures;
        if (!changes.areSides) return;
        ++revisions.geometry;
        areDrawsDue = true;
        instances->MarkGroupsChanged();
    }

    void SetVariant(uint32_t variant) {
        const KindChanges changes = ChangeVariant(*resources, builder, variant);  // everything that may fail
        ++revisions.materials;
        ++revisions.geometry;  // alpha of another texture, if not sides
        areGeometriesDue = !resources->geometryRecords.empty();
        lights->SetVariant(*resources);
        hasUnbuiltBlases |= changes.areStructures;
        if (!changes.areSides) return;
        areDrawsDue = true;
        instances->MarkGroupsChanged();
    }

    void RefreshDraws() {
        if (!areDrawsDue) return;
        DrawTable newDraws;
        uploader.FlushAfter(
            [&] { newDraws = MakeDrawTable(device, uploader, *resources, instances->Placements()); });
        draws = std::move(newDraws);
        drawsState = {};
        areDrawsDue = false;
    }

    void DeclareEnvironment(Renderer& r, SceneIds& ids) {
        EnvironmentOnDevice* map = hostEnvironment ? &*hostEnvironment : nullptr;
        if (!map && environment.usesScene && sceneEnvironment) map = &*sceneEnvironment;
        const bool isDark = !map && environment.usesScene;
        const glm::vec3 radiance = isDark ? glm::vec3(0.0f) : environment.radiance;
        EnvironmentOnDevice& shown = map ? *map : blank;
        ids.environment = {.radiance = radiance, .rotation = environment.rotation, .hasMap = map ? 1u : 0u};
        ids.environmentVersion = environmentVersion;
        ids.environmentMap = r.Import("environmentMap", shown.map, shown.mapState);
        ids.environmentAlias = r.Import("environmentAlias", shown.alias, shown.aliasState);
        lights->SetEnvironment(radiance * shown.meanRadiance, environment.rotation, shown.cells);
    }

    // An edit would change or destroy what the open frame was declared from.
    void RequireNoFrame(const char* call) const {
        if (!declaredIn.expired())
            throw MakeError(
                ErrorKind::Usage,
                "GpuScene: {} between Declare and Execute; it comes before Declare or after Execute", call);
    }

    void DeclareBlasWork(Renderer& r, SceneIds& ids) {
        const bool hasCompactions = builder.Poll();
        // The addresses are known once the passes record: the instances are written after that
        if (hasUnbuiltBlases || hasCompactions) instances->MarkStructuresChanged();
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
                    builder.RecordBuilds(commands);
                    commands.OnSubmitted([this, deformed = std::move(deformed)] {
                        hasUnbuiltBlases = false;
                        DeformSet::NoteBuilt(deformed);
                    });
                });
        if (deform) deform->DeclareRefits(r, ids, builder);
        if (hasCompactions)
            r.AddPass(
                "CompactBlas", PassKind::AccelerationStructure,
                [&](PassBuilder& pass) { ids.blases = pass.Builds(ids.blases); },
                [this](CommandList& commands) { builder.RecordCompaction(commands); });
    }

    void DeclareMaterialUpload(Renderer& r, SceneIds& ids) {
        if (dirtyMaterials.IsEmpty()) return;
        r.AddPass(
            "UploadMaterials", PassKind::Transfer,
            [&](PassBuilder& pass) { ids.materials = pass.CopiesTo(ids.materials); },
            [this](CommandList& commands) {
                const uint64_t offset = dirtyMaterials.first * sizeof(gpu::MaterialRecord);
                const std::span<const std::byte> bytes =
                    std::as_bytes(std::span(resources->materialRecords)
                                      .subspan(dirtyMaterials.first, dirtyMaterials.Count()));
                const TableCopy copy{bytes, resources->materials, offset};
                RecordCopies(commands, device, "material staging", {&copy, 1});
                commands.OnSubmitted([this] { dirtyMaterials = {}; });
            });
    }

    void DeclareGeometryUpload(Renderer& r, SceneIds& ids) {
        if (!areGeometriesDue) return;
        r.AddPass(
            "UploadGeometries", PassKind::Transfer,
            [&](PassBuilder& pass) { ids.geometries = pass.CopiesTo(ids.geometries); },
            [this](CommandList& commands) {
                const TableCopy copy{std::as_bytes(std::span(std::as_const(resources->geometryRecords))),
                                     resources->geometries};
                RecordCopies(commands, device, "geometry staging", {&copy, 1});
                commands.OnSubmitted([this] { areGeometriesDue = false; });
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
        statistics.deformedMeshes = deform ? static_cast<uint32_t>(resources->deform->meshes.size()) : 0;
        statistics.tlasBytes = instances->TlasBytes();
        statistics.lightCount = lights->LightCount();
        statistics.emissiveTriangleCount = lights->EmissiveTriangleCount();
        statistics.lightRebuilds = lights->RebuildCount();
    }

    GpuSceneDesc desc;
    rhi::Device& device;
    rhi::Uploader uploader;
    rhi::BlasBuilder builder;
    rhi::Texture defaultTexture;
    rhi::Sampler defaultSampler;
    rhi::Buffer energyTables;
    std::unique_ptr<SceneResources> resources;
    std::unique_ptr<InstanceSet> instances;  // refers to resources: declared after it
    std::unique_ptr<LightSet> lights;
    std::unique_ptr<DeformSet> deform;  // null: nothing is deformed; refers to both
    DrawTable draws;
    glm::dvec3 origin{0.0};
    OriginTurns originTurns;
    std::weak_ptr<const void> declaredIn;  // the frame that is open; expired: none
    bool hasUnbuiltBlases = false;
    bool areDrawsDue = false;       // kinds of groups have changed since `draws` was built
    bool areGeometriesDue = false;  // their records on the device are of another variant
    DirtyRange dirtyMaterials;
    SceneRevisions revisions;

    EnvironmentSettings environment{.radiance = glm::vec3(1.0f), .usesScene = true};
    std::optional<EnvironmentOnDevice> hostEnvironment, sceneEnvironment;
    EnvironmentOnDevice blank;  // for an environment without a map
    uint64_t environmentVersion = 0;
    ResourceState geometriesState;
    ResourceState materialsState;
    ResourceState drawsState;
    ResourceState energyTablesState;
    ResourceState blasState;
    GpuSceneStatistics statistics;
};

}  // namespace raygraph

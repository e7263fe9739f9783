#include "renderer/gpu_scene/gpu_scene.h"

#include <algorithm>
#include <cstring>
#include <optional>

#include "base/out_of_memory.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/dirty_range.h"
#include "renderer/gpu_scene/draw_table.h"
#include "renderer/gpu_scene/energy_tables.h"
#include "renderer/gpu_scene/environment_upload.h"
#include "renderer/gpu_scene/instance_set.h"
#include "renderer/gpu_scene/light_set.h"
#include "renderer/gpu_scene/material_features.h"
#include "renderer/gpu_scene/material_records.h"
#include "renderer/gpu_scene/scene_origin.h"
#include "renderer/scene/check.h"
#include "rhi/blas_builder.h"
#include "rhi/texture_table.h"
#include "rhi/upload.h"

namespace raygraph {

namespace {

ResourceState SampledState() {
    return {.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
}

}  // namespace

struct GpuScene::Impl {
    Impl(Renderer& r, const GpuSceneDesc& desc)
        : device(r.Device()),
          uploader(device),
          builder(device, {.name = "scene BLASes",
                           .scratchBudget = desc.scratchBudget,
                           .compactsWithoutGain = desc.compactsWithoutGain,
                           .compactionBudget = desc.compactionBudget}) {
        defaultTexture = WhiteTexture(device, uploader);
        blackEnvironment = BlackEnvironment(device, uploader);
        defaultSampler = device.CreateSampler({.name = "default sampler"});
        const auto tables = std::as_bytes(EnergyTables());
        constexpr auto kTableUsage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination;
        energyTables =
            device.CreateBuffer({.name = "energy tables", .size = tables.size(), .usage = kTableUsage});
        uploader.UploadBuffer(energyTables, 0, tables);
        textureTable.emplace(device, desc.textureCapacity, defaultTexture, defaultSampler);
        constantAlias = UploadAlias(device, uploader, ConstantEnvironmentAlias());
        Replace(scene::SceneData{});
    }

    // Creates the new scene first, so that an Error leaves the old one in place.
    void Replace(scene::SceneData&& data) {
        const Stopwatch watch;
        scene::Check(data, "GpuScene: SetScene");
        CheckLimits(device, *textureTable, data);
        device.CollectGarbage();  // room that there is already
        std::unique_ptr<SceneResources> newResources;
        std::unique_ptr<InstanceSet> newInstances;
        std::unique_ptr<LightSet> newLights;
        DrawTable newDraws;
        try {
            uploader.FlushAfter([&] {
                newResources = UploadScene(device, uploader, builder, *textureTable, data);
                newInstances = std::make_unique<InstanceSet>(device, *newResources, data);
                newDraws = MakeDrawTable(device, uploader, *newResources, newInstances->Placements());
                newLights =
                    std::make_unique<LightSet>(device, *newResources, newInstances->Placements(), data);
                builder.Reserve();  // a frame that ran out of it could not be drawn, nor the next one
            });
        } catch (...) {
            data.meshes.clear();  // some are freed by now: a retry would lack them
            throw;
        }
        const glm::dvec3 newOrigin = ChooseSceneOrigin({}, glm::dvec3(0.0), newInstances->Reach());
        newInstances->MoveOrigin(newOrigin);
        newLights->MoveOrigin(newOrigin, *newInstances);
        lights = std::move(newLights);
        instances = std::move(newInstances);
        resources = std::move(newResources);
        draws = std::move(newDraws);
        areDrawsDue = false;
        origin = newOrigin;
        originTurns = {};
        drawsState = {};
        hasUnbuiltBlases = true;
        dirtyMaterials = {};
        ++revisions.geometry;
        geometriesState = {};
        materialsState = {};
        statistics.uploadMs = watch.Milliseconds();
        statistics.instanceCount = instances->Count();
        statistics.geometryCount = resources->geometryCount;
        statistics.geometryBytes = resources->geometryBytes;
        statistics.textureBytes = resources->textureBytes;
        statistics.trianglesUnique = TriangleCount(*resources);
        statistics.trianglesPlaced = TriangleCount(*resources, data.instances);
        if (statistics.instanceCount > 0)
            Say(device.Log(), LogLevel::Info, log_category::kScene,
                "{} triangles in {} instances are uploaded in {}", statistics.trianglesPlaced,
                statistics.instanceCount, DurationText(watch.Seconds()));
    }

    void SetEnvironmentMap(const image::ImageF& equirectangular);
    SceneIds Declare(Renderer& renderer);

    void SetViewpoint(const glm::dvec3& eye) {
        const glm::dvec3 wanted = ChooseSceneOrigin(origin, eye, instances->Reach());
        if (!originTurns.Moves(origin, wanted)) return;
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
        const bool hasMap = static_cast<bool>(environmentMap);
        ids.environment = {
            .radiance = environment.radiance, .rotation = environment.rotation, .hasMap = hasMap ? 1u : 0u};
        ids.environmentVersion = environmentVersion;
        ids.environmentMap =
            r.Import("environmentMap", hasMap ? environmentMap : blackEnvironment, environmentState);
        ids.environmentAlias =
            r.Import("environmentAlias", hasMap ? mapAlias : constantAlias, environmentAliasState);
        lights->SetEnvironment(environment.radiance * (hasMap ? mapMeanRadiance : glm::vec3(1.0f)),
                               environment.rotation, hasMap ? mapCells : glm::uvec2(1));
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
                [&](PassBuilder& pass) { ids.blases = pass.Builds(ids.blases); },
                [this](CommandList& commands) {
                    builder.RecordBuilds(commands);
                    commands.OnSubmitted([this] { hasUnbuiltBlases = false; });
                });
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
                rhi::Buffer staging = device.CreateBuffer({.name = "material staging",
                                                           .size = bytes.size(),
                                                           .usage = rhi::BufferUsage::CopySource,
                                                           .memory = rhi::MemoryKind::Upload});
                std::copy(bytes.begin(), bytes.end(), staging.Mapped().begin());
                commands.CopyBuffer(staging, 0, resources->materials, offset, bytes.size());
                commands.OnSubmitted([this] { dirtyMaterials = {}; });
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
        statistics.tlasBytes = instances->TlasBytes();
        statistics.lightCount = lights->LightCount();
        statistics.emissiveTriangleCount = lights->EmissiveTriangleCount();
        statistics.lightRebuilds = lights->RebuildCount();
    }

    rhi::Device& device;
    rhi::Uploader uploader;
    rhi::BlasBuilder builder;
    rhi::Texture defaultTexture;
    rhi::Texture blackEnvironment;
    rhi::Sampler defaultSampler;
    rhi::Buffer energyTables;
    std::optional<rhi::TextureTable> textureTable;
    std::unique_ptr<SceneResources> resources;
    std::unique_ptr<InstanceSet> instances;  // refers to resources: declared after it
    std::unique_ptr<LightSet> lights;
    DrawTable draws;
    glm::dvec3 origin{0.0};
    OriginTurns originTurns;
    std::weak_ptr<const void> declaredIn;  // the frame that is open; expired: none
    bool hasUnbuiltBlases = false;
    bool areDrawsDue = false;  // kinds of groups have changed since `draws` was built
    DirtyRange dirtyMaterials;
    SceneRevisions revisions;

    EnvironmentSettings environment;
    rhi::Texture environmentMap;  // empty: none
    uint64_t environmentVersion = 0;
    ResourceState environmentState = SampledState();
    rhi::Buffer constantAlias;  // for directions to an environment without a map
    rhi::Buffer mapAlias;       // likewise to environmentMap
    glm::uvec2 mapCells{1};
    glm::vec3 mapMeanRadiance{1.0f};
    ResourceState environmentAliasState;
    ResourceState geometriesState;
    ResourceState materialsState;
    ResourceState drawsState;
    ResourceState energyTablesState;
    ResourceState blasState;
    GpuSceneStatistics statistics;
};

GpuScene::GpuScene(Renderer& renderer, const GpuSceneDesc& desc)
    : m_impl(WithMemoryErrors("GpuScene", [&] { return std::make_unique<Impl>(renderer, desc); })) {}
GpuScene::~GpuScene() = default;

void GpuScene::SetScene(scene::SceneData&& scene) {
    m_impl->RequireNoFrame("SetScene");
    const bool makesRoom = scene.meshes.empty();
    WithMemoryErrors("SetScene", [&] { m_impl->Replace(std::move(scene)); });
    if (makesRoom) m_impl->device.WaitIdle();
}

void GpuScene::SetTransform(uint32_t instance, const scene::PlacedTransform& objectToWorld) {
    m_impl->RequireNoFrame("SetTransform");
    RequireIndex("instance", instance, m_impl->instances->Count());
    if (m_impl->instances->Transform(instance) == objectToWorld) return;
    if (!scene::CanInvert(objectToWorld.matrix) || !scene::IsFinite(objectToWorld.rest))
        scene::CheckTransform(objectToWorld, Text("GpuScene: SetTransform: instance {}", instance));
    ++m_impl->revisions.transforms;
    m_impl->instances->SetTransform(instance, objectToWorld);
    m_impl->lights->SetTransform(instance, m_impl->instances->DeviceTransform(instance));
}

const scene::PlacedTransform& GpuScene::Transform(uint32_t instance) const {
    RequireIndex("instance", instance, m_impl->instances->Count());
    return m_impl->instances->Transform(instance);
}

void GpuScene::SetViewpoint(const glm::dvec3& eye) {
    m_impl->RequireNoFrame("SetViewpoint");
    m_impl->SetViewpoint(eye);
}

void GpuScene::SetVisible(uint32_t instance, bool isVisible) {
    m_impl->RequireNoFrame("SetVisible");
    RequireIndex("instance", instance, m_impl->instances->Count());
    if (m_impl->instances->IsVisible(instance) == isVisible) return;
    ++m_impl->revisions.geometry;
    m_impl->instances->SetVisible(instance, isVisible);
    m_impl->lights->SetVisible(instance, isVisible);
}

bool GpuScene::IsVisible(uint32_t instance) const {
    RequireIndex("instance", instance, m_impl->instances->Count());
    return m_impl->instances->IsVisible(instance);
}

void GpuScene::SetMaterial(uint32_t material, const scene::Material& values) {
    m_impl->RequireNoFrame("SetMaterial");
    std::vector<gpu::MaterialRecord>& records = m_impl->resources->materialRecords;
    RequireIndex("material", material, records.size());
    scene::Check(values, Text("GpuScene: SetMaterial: material {}", material));
    const gpu::MaterialRecord record = ToRecord(values, records[material]);
    // There is no padding that differs: scene_records.h asserts the size
    if (std::memcmp(&record, &records[material], sizeof(record)) == 0) return;
    WithMemoryErrors("SetMaterial", [&] { m_impl->SetMaterial(material, record); });
}

void GpuScene::SetLightVisible(uint32_t light, bool isVisible) {
    m_impl->RequireNoFrame("SetLightVisible");
    RequireIndex("light", light, m_impl->lights->PunctualCount());
    if (m_impl->lights->IsPunctualVisible(light) == isVisible) return;
    m_impl->lights->SetPunctualVisible(light, isVisible);
    ++m_impl->revisions.lights;
}

bool GpuScene::IsLightVisible(uint32_t light) const {
    RequireIndex("light", light, m_impl->lights->PunctualCount());
    return m_impl->lights->IsPunctualVisible(light);
}

void GpuScene::SetLight(uint32_t light, const scene::Light& values) {
    m_impl->RequireNoFrame("SetLight");
    RequireIndex("light", light, m_impl->lights->PunctualCount());
    if (m_impl->lights->Punctual(light) == values) return;
    WithMemoryErrors("SetLight", [&] { m_impl->lights->SetPunctual(light, values); });
    ++m_impl->revisions.lights;
}

const scene::Light& GpuScene::Light(uint32_t light) const {
    RequireIndex("light", light, m_impl->lights->PunctualCount());
    return m_impl->lights->Punctual(light);
}

void GpuScene::SetLightGroups(LightGroups groups) {
    m_impl->RequireNoFrame("SetLightGroups");
    RequireFitting(groups, m_impl->instances->Count(), m_impl->resources->materialRecords.size(),
                   m_impl->lights->PunctualCount());
    m_impl->lights->SetGroups(std::move(groups));
}

void GpuScene::SetEnvironment(const EnvironmentSettings& settings) {
    m_impl->RequireNoFrame("SetEnvironment");
    if (m_impl->environment == settings) return;
    if (!scene::IsFinite(settings.radiance) || glm::any(glm::lessThan(settings.radiance, glm::vec3(0.0f))) ||
        !std::isfinite(settings.rotation))
        throw Error(ErrorKind::Usage,
                    "GpuScene: SetEnvironment: radiance and rotation must be finite, radiance not negative");
    m_impl->environment = settings;
    ++m_impl->revisions.environment;
}

const EnvironmentSettings& GpuScene::Environment() const {
    return m_impl->environment;
}

void GpuScene::SetEnvironmentMap(const image::ImageF& equirectangular) {
    m_impl->RequireNoFrame("SetEnvironmentMap");
    WithMemoryErrors("SetEnvironmentMap", [&] { m_impl->SetEnvironmentMap(equirectangular); });
}

void GpuScene::Impl::SetEnvironmentMap(const image::ImageF& equirectangular) {
    RequireRadiance(equirectangular);
    rhi::Texture map = device.CreateTexture({.name = "environment map",
                                             .extent = {equirectangular.width, equirectangular.height},
                                             .format = rhi::Format::Rgba32Float});
    const EnvironmentAlias alias = BuildEnvironmentAlias(equirectangular);
    rhi::Buffer newAlias;
    uploader.FlushAfter([&] {
        newAlias = UploadAlias(device, uploader, alias);
        uploader.UploadTexture(map, std::as_bytes(std::span(equirectangular.rgba)));
    });
    environmentMap = std::move(map);
    ++environmentVersion;
    ++revisions.environment;
    environmentState = SampledState();
    mapAlias = std::move(newAlias);
    mapCells = {alias.width, alias.height};
    mapMeanRadiance = alias.meanRadiance;
    environmentAliasState = {};
}

void GpuScene::RemoveEnvironmentMap() {
    m_impl->RequireNoFrame("RemoveEnvironmentMap");
    if (!m_impl->environmentMap) return;
    ++m_impl->revisions.environment;
    m_impl->environmentMap = {};
    ++m_impl->environmentVersion;
    m_impl->environmentState = SampledState();
    m_impl->mapAlias = {};
    m_impl->environmentAliasState = {};
}

SceneIds GpuScene::Declare(Renderer& renderer) {
    m_impl->RequireNoFrame("Declare");
    return WithMemoryErrors("GpuScene", [&] { return m_impl->Declare(renderer); });
}

SceneIds GpuScene::Impl::Declare(Renderer& renderer) {
    declaredIn = renderer.OpenFrame();
    RefreshDraws();
    SceneIds ids;
    ids.origin = origin;
    DeclareEnvironment(renderer, ids);
    ids.geometries = renderer.Import("geometries", resources->geometries, geometriesState);
    ids.materials = renderer.Import("materials", resources->materials, materialsState);
    ids.draws = renderer.Import("draws", draws.records, drawsState);
    ids.drawsOfKind = draws.drawsOfKind;
    ids.placementCount = draws.placementCount;
    ids.chunkCount = draws.chunkCount;
    ids.energyTables = renderer.Import("energyTables", energyTables, energyTablesState);
    ids.lobeFeatures = LobeFeatures(*resources);
    ids.textureFeatures = TextureFeatures(*resources);
    ids.hasVolumes = HasVolumes(*resources);
    for (const GroupResources& group : resources->groups) {
        ids.hasAlpha |= !group.kind.isOpaque;
        ids.hasThinWalls |= group.kind.isThinWall;
    }
    ids.textures = renderer.Import("textures", *textureTable);
    ids.blases = renderer.ImportBlasSet("BLASes", blasState);
    DeclareBlasWork(renderer, ids);
    DeclareMaterialUpload(renderer, ids);
    lights->Declare(renderer, ids);
    instances->DeclareRefresh(renderer, ids, [&statistics = statistics](TlasWork work) {
        statistics.lastTlasWork = work;
        statistics.tlasUpdates += work == TlasWork::Update ? 1 : 0;
        statistics.tlasRebuilds += work == TlasWork::Rebuild ? 1 : 0;
    });
    return ids;
}

const GpuSceneStatistics& GpuScene::Statistics() const {
    m_impl->RefreshStatistics();
    return m_impl->statistics;
}

const SceneRevisions& GpuScene::Revisions() const {
    return m_impl->revisions;
}

bool GpuScene::IsSettled() const {
    const rhi::CompactionStatistics blas = m_impl->builder.Statistics();
    return !m_impl->hasUnbuiltBlases && blas.pending == 0 &&
           m_impl->instances->PendingWork() == TlasWork::None;
}

}  // namespace raygraph

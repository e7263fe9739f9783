#include "renderer/gpu_scene/gpu_scene.h"

#include <cstring>

#include "base/counted.h"
#include "base/out_of_memory.h"
#include "base/text.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/gpu_scene/material_records.h"
#include "renderer/scene/check.h"
#include "renderer/scene/flat_transform.h"

namespace raygraph {

GpuScene::GpuScene(Renderer& renderer, const GpuSceneDesc& desc)
    : m_impl(WithMemoryErrors("GpuScene", [&] { return std::make_unique<Impl>(renderer, desc); })) {}
GpuScene::~GpuScene() = default;

void GpuScene::SetScene(scene::SceneData&& scene) {
    m_impl->RequireNoFrame("SetScene");
    PreparedScene prepared(std::move(scene), m_impl->Preparing(), "SetScene");
    try {
        SetScene(std::move(prepared));
    } catch (...) {
        scene = std::move(prepared.m_content->data);
        scene.meshes.clear();  // some are freed by now: a retry would lack them
        throw;
    }
}

void GpuScene::SetScene(PreparedScene&& scene) {
    m_impl->RequireNoFrame("SetScene");
    const bool makesRoom = scene.m_content->meshes.empty();
    WithMemoryErrors("SetScene", [&] { m_impl->SetContent(*scene.m_content); });
    m_impl->disposer.Dispose(std::move(scene.m_content));
    if (makesRoom) m_impl->device.WaitIdle();
}

std::shared_ptr<SceneUpload> GpuScene::Upload(PreparedScene&& scene) {
    m_impl->RequireNoFrame("Upload");
    return WithMemoryErrors("Upload", [&] {
        Impl& impl = *m_impl;
        CheckLimits(impl.device, *scene.m_content);
        SceneContent& content = *scene.m_content;
        auto upload = std::make_shared<SceneUpload>(std::make_unique<SceneUpload::Content>(
            std::move(scene.m_content), impl.device, impl.StreamUploader(), impl.builder, impl.disposer,
            content, impl.SettingsOfResources()));
        impl.uploads.push_back(upload);
        return upload;
    });
}

void GpuScene::SetScene(SceneUpload& upload) {
    m_impl->RequireNoFrame("SetScene");
    if (!upload.m_content) throw Error(ErrorKind::Usage, "GpuScene: SetScene: the scene has been set before");
    const std::unique_ptr<SceneUpload::Content> content = std::move(upload.m_content);
    if (content->error) std::rethrow_exception(content->error);
    WithMemoryErrors("SetScene", [&] { m_impl->Finish(*content); });
}

void GpuScene::Impl::Finish(SceneUpload::Content& content) {
    const Stopwatch watch;
    if (!content.isDone)
        StreamUploader().FlushAfter([&] {
            uint64_t budget = UINT64_MAX;
            content.resources->Continue(budget);
        });
    Replace(*content.scene, *content.resources, watch);
    endedTextures.push_back(content.resources->TakeTextures());
    disposer.Dispose(std::move(content.scene));
}

ResourceSettings GpuScene::Impl::SettingsOfResources() const {
    return {.textures =
                TextureSettings(desc.textureBudget > 0 ? desc.textureBudget : DefaultTextureBudget(device)),
            .defaultTexture = &defaultTexture,
            .defaultSampler = &defaultSampler};
}

void GpuScene::Impl::SetContent(SceneContent& content) {
    const Stopwatch watch;
    CheckLimits(device, content);
    device.CollectGarbage();  // room that there is already
    ResourceUpload upload(device, uploader, builder, disposer, content, SettingsOfResources());
    Replace(content, upload, watch);
}

void GpuScene::Impl::Replace(SceneContent& content, ResourceUpload& upload, const Stopwatch& watch) {
    const scene::SceneData& data = content.data;
    SceneResources newResources;
    std::unique_ptr<InstanceSet> newInstances;
    std::unique_ptr<LightSet> newLights;
    std::unique_ptr<DeformSet> newDeform;
    DrawTable newDraws;
    std::optional<EnvironmentOnDevice> newEnvironment;
    uploader.FlushAfter([&] {
        uint64_t budget = UINT64_MAX;
        upload.Continue(budget);
        newResources = upload.Finish(uploader);
        newInstances = std::make_unique<InstanceSet>(device, *newResources.geometry, data);
        newDraws = DrawTable(device, *newResources.geometry, *newInstances);
        newDraws.Upload(uploader);
        newLights = std::make_unique<LightSet>(device, uploader, *newResources.geometry,
                                               newInstances->Placements(), data, desc.lightRule);
        if (newResources.geometry->deform)
            newDeform = std::make_unique<DeformSet>(device, *newResources.geometry, *newInstances);
        if (data.environment.IsPresent())
            newEnvironment = UploadEnvironment(device, uploader, data.environment.map);
        builder.Reserve();  // a frame that ran out of it could not be drawn, nor the next one
    });
    ObjectOwners newOwners;
    newOwners.meshes.Reset(data.meshes.size());
    newOwners.instances.Reset(data.instances.size());
    newOwners.materials.Reset(data.materials.size());
    newOwners.lights.Reset(data.lights.size());
    const glm::dvec3 newOrigin = ChooseSceneOrigin({}, glm::dvec3(0.0), newInstances->Reach());
    newInstances->MoveOrigin(newOrigin);
    newLights->MoveOrigin(newOrigin, *newInstances);
    std::unique_ptr<WideSet> newTrees;
    if (traversal == Traversal::Own) {
        newTrees = std::make_unique<WideSet>(device, desc.lightRule == LightRule::Decay);
        newTrees->Follow(*newResources.geometry, *newInstances);
        Say(device.Log(), LogLevel::Debug, log_category::kGeometry, "trees for own traversal: {}",
            newTrees->WhyNone().empty() ? BytesText(newTrees->Bytes()) : newTrees->WhyNone());
    }
    deform = std::move(newDeform);
    lights = std::move(newLights);
    trees = std::move(newTrees);
    instances = std::move(newInstances);
    geometry = std::move(newResources.geometry);
    materials = std::move(newResources.materials);
    draws = std::move(newDraws);
    builder.Trim();
    environment.SetScene(std::move(newEnvironment), content.hasOwnLight);
    content.data.environment = {};
    areDrawsDue = areDrawNumbersDue = false;
    while (!streams.empty()) EndStream(streams.begin());
    changedHostMeshes.clear();
    hostPlacements.clear();
    owners = std::move(newOwners);
    origin = newOrigin;
    originTurns = {};
    hasUnbuiltBlases = areAddressesDue = true;
    ++revisions.geometry;
    statistics.uploadMs = watch.Milliseconds();
    statistics.textureBudget = upload.Textures().budget;
    set = {data.instances.size(), data.materials.size(), data.lights.size()};
    if (const std::string& warning = upload.Warning(); !warning.empty())
        device.Log().Send(LogLevel::Warning, log_category::kScene, warning);
    RefreshStatistics();
    if (statistics.instanceCount > 0)
        Say(device.Log(), LogLevel::Info, log_category::kScene, "uploaded in {}: {} in {}",
            DurationText(watch.Seconds()), Counted(statistics.trianglesPlaced, "triangle"),
            Counted(statistics.instanceCount, "instance"));
}

void GpuScene::SetTransforms(std::span<const uint32_t> instances,
                             std::span<const scene::PlacedTransform> objectToWorld) {
    m_impl->RequireNoFrame("SetTransform");
    InstanceSet& set = *m_impl->instances;
    if (instances.size() != objectToWorld.size())
        throw MakeError(ErrorKind::Usage, "GpuScene: SetTransforms: {} for {}",
                        Counted(objectToWorld.size(), "transform"), Counted(instances.size(), "instance"));
    std::vector<scene::PlacedTransform> solid;  // a copy in which flat ones are thick; empty: none is flat
    for (size_t i = 0; i < instances.size(); ++i) {
        m_impl->RequireInstance(instances[i]);
        const scene::PlacedTransform& transform = objectToWorld[i];
        const bool mayBeFlat = scene::MayGainThickness(transform.matrix);
        if (!mayBeFlat && scene::CanInvert(transform.matrix) && scene::IsFinite(transform.rest)) continue;
        const scene::PlacedTransform shown =
            scene::CheckedPlacement(transform, set.BoundsOf(set.MeshOf(instances[i])),
                                    Text("GpuScene: SetTransform: instance {}", instances[i]));
        if (solid.empty())
            WithMemoryErrors("SetTransform",
                             [&] { solid.assign(objectToWorld.begin(), objectToWorld.end()); });
        solid[i] = shown;
    }
    if (!solid.empty()) objectToWorld = solid;
    if (!WithMemoryErrors("SetTransform", [&] { return set.SetTransforms(instances, objectToWorld); }))
        return;
    ++m_impl->revisions.transforms;
    for (const uint32_t instance : instances)
        if (m_impl->lights->IsEmitter(instance))
            m_impl->lights->SetTransform(instance, set.DeviceTransform(instance));
}

bool GpuScene::HasInstance(uint32_t instance) const {
    return m_impl->instances->Exists(instance);
}

const scene::PlacedTransform& GpuScene::Transform(uint32_t instance) const {
    m_impl->RequireInstance(instance);
    return m_impl->instances->Transform(instance);
}

bool GpuScene::TakesTrees() const {
    return m_impl->traversal == Traversal::Own;
}

void GpuScene::SetViewpoint(const glm::dvec3& eye) {
    m_impl->RequireNoFrame("SetViewpoint");
    m_impl->SetViewpoint(eye);
}

void GpuScene::SetVisible(std::span<const uint32_t> instances, bool isVisible) {
    m_impl->RequireNoFrame("SetVisible");
    for (const uint32_t instance : instances) m_impl->RequireInstance(instance);
    if (!WithMemoryErrors("SetVisible", [&] { return m_impl->instances->SetVisible(instances, isVisible); }))
        return;
    ++m_impl->revisions.geometry;
    for (const uint32_t instance : instances) m_impl->lights->SetVisible(instance, isVisible);
}

bool GpuScene::IsVisible(uint32_t instance) const {
    m_impl->RequireInstance(instance);
    return m_impl->instances->IsVisible(instance);
}

void GpuScene::SetMaterial(uint32_t material, const scene::Material& values) {
    m_impl->RequireNoFrame("SetMaterial");
    m_impl->RequireMaterial(material);
    scene::Check(values, Text("GpuScene: SetMaterial: material {}", material));
    const gpu::MaterialRecord& shown = m_impl->materials->Records()[material];
    const gpu::MaterialRecord record = ToRecord(values, shown);
    // There is no padding that differs: scene_records.h asserts the size
    if (std::memcmp(&record, &shown, sizeof(record)) == 0) return;
    WithMemoryErrors("SetMaterial", [&] { m_impl->SetMaterial(material, record); });
}

void GpuScene::SetVariant(uint32_t variant) {
    m_impl->RequireNoFrame("SetVariant");
    if (variant != scene::kNone) RequireIndex("variant", variant, m_impl->geometry->variantCount);
    if (m_impl->geometry->variant == variant) return;
    WithMemoryErrors("SetVariant", [&] { m_impl->SetVariant(variant); });
}

uint32_t GpuScene::Variant() const {
    return m_impl->geometry->variant;
}

void GpuScene::SetLightVisible(uint32_t light, bool isVisible) {
    m_impl->RequireNoFrame("SetLightVisible");
    m_impl->RequireLight(light);
    if (m_impl->lights->IsPunctualVisible(light) == isVisible) return;
    m_impl->lights->SetPunctualVisible(light, isVisible);
    ++m_impl->revisions.lights;
}

bool GpuScene::IsLightVisible(uint32_t light) const {
    m_impl->RequireLight(light);
    return m_impl->lights->IsPunctualVisible(light);
}

void GpuScene::SetLight(uint32_t light, const scene::Light& values) {
    m_impl->RequireNoFrame("SetLight");
    m_impl->RequireLight(light);
    if (m_impl->lights->Punctual(light) == values) return;
    WithMemoryErrors("SetLight", [&] { m_impl->lights->SetPunctual(light, values); });
    ++m_impl->revisions.lights;
}

const scene::Light& GpuScene::Light(uint32_t light) const {
    m_impl->RequireLight(light);
    return m_impl->lights->Punctual(light);
}

void GpuScene::SetLightGroups(LightGroups groups) {
    m_impl->RequireNoFrame("SetLightGroups");
    RequireFitting(groups, m_impl->instances->Count(), m_impl->materials->Size(),
                   m_impl->lights->PunctualCount());
    m_impl->lights->SetGroups(std::move(groups));
}

void GpuScene::SetEnvironment(const EnvironmentSettings& settings) {
    m_impl->RequireNoFrame("SetEnvironment");
    if (m_impl->environment.Set(settings)) ++m_impl->revisions.environment;
}

const EnvironmentSettings& GpuScene::Environment() const {
    return m_impl->environment.Settings();
}

EnvironmentSettings GpuScene::ShownEnvironment() const {
    return m_impl->environment.Shown();
}

void GpuScene::SetEnvironmentMap(const image::ImageF& equirectangular) {
    m_impl->RequireNoFrame("SetEnvironmentMap");
    WithMemoryErrors("SetEnvironmentMap", [&] { m_impl->environment.SetMap(equirectangular); });
    ++m_impl->revisions.environment;
}

void GpuScene::RemoveEnvironmentMap() {
    m_impl->RequireNoFrame("RemoveEnvironmentMap");
    if (m_impl->environment.RemoveMap()) ++m_impl->revisions.environment;
}

SceneIds GpuScene::Declare(Renderer& renderer) {
    m_impl->RequireNoFrame("Declare");
    return WithMemoryErrors("GpuScene", [&] { return m_impl->Declare(renderer); });
}

SceneIds GpuScene::Impl::Declare(Renderer& renderer) {
    declaredIn = renderer.OpenFrame();
    ContinueStreams();
    RefreshDraws();
    SceneIds ids;
    ids.origin = origin;
    environment.Declare(renderer, ids, *lights);
    ids.geometries = geometry->records.Declare(renderer);
    materials->Declare(renderer, ids, *geometry);
    ids.placementCount = instances->RecordCount();
    ids.energyTables = renderer.Import("energyTables", energyTables, energyTablesState);
    if (desc.textureLevels) ids.features |= kTraceTextureLod;
    ids.blases = renderer.ImportBlasSet("BLASes", blasState);
    if (deform) deform->DeclareDeformation(renderer, ids, *lights, draws);
    draws.Declare(renderer, ids);
    DeclareBlasWork(renderer, ids);
    if (trees) {
        trees->Follow(*geometry, *instances);
        trees->Declare(renderer, ids);
    }
    lights->Declare(renderer, ids, *instances);
    const bool hasWork = hasUnbuiltBlases || instances->PendingWork() != TlasWork::None;
    areStructuresUsed = !hasWork;
    instances->DeclareRefresh(renderer, ids, [this](TlasWork work) {
        areStructuresUsed = true;
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
    const bool hasStructureWork =
        m_impl->hasUnbuiltBlases || m_impl->instances->PendingWork() != TlasWork::None;
    return !(hasStructureWork && m_impl->areStructuresUsed) && blas.pending == 0 && m_impl->streams.empty() &&
           m_impl->changedHostMeshes.empty() && !m_impl->NextUpload() &&
           (!m_impl->deform || !m_impl->deform->HasWork());
}

}  // namespace raygraph

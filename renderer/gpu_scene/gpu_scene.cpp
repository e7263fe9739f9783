#include "renderer/gpu_scene/gpu_scene.h"

#include <cstring>

#include "base/out_of_memory.h"
#include "base/text.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/gpu_scene/material_features.h"
#include "renderer/gpu_scene/material_records.h"
#include "renderer/scene/check.h"

namespace raygraph {

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
    if (m_impl->lights->IsEmitter(instance))
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

void GpuScene::SetVariant(uint32_t variant) {
    m_impl->RequireNoFrame("SetVariant");
    if (variant != scene::kNone) RequireIndex("variant", variant, m_impl->resources->variantCount);
    if (m_impl->resources->variant == variant) return;
    WithMemoryErrors("SetVariant", [&] { m_impl->SetVariant(variant); });
}

uint32_t GpuScene::Variant() const {
    return m_impl->resources->variant;
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
    std::optional<EnvironmentOnDevice> uploaded;
    uploader.FlushAfter([&] { uploaded = UploadEnvironment(device, uploader, equirectangular); });
    hostEnvironment = std::move(uploaded);
    ++environmentVersion;
    ++revisions.environment;
}

void GpuScene::RemoveEnvironmentMap() {
    m_impl->RequireNoFrame("RemoveEnvironmentMap");
    if (!m_impl->hostEnvironment) return;
    m_impl->hostEnvironment.reset();
    ++m_impl->revisions.environment;
    ++m_impl->environmentVersion;
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
    ids.hasTextureLevels = desc.textureLevels;
    ids.hasVolumes = HasVolumes(*resources);
    for (const GroupResources& group : resources->groups) {
        ids.hasAlpha |= !group.kind.isOpaque;
        ids.hasThinWalls |= group.kind.isThinWall;
        ids.hasCapsules |= group.kind.isRound;
    }
    ids.textures = renderer.Import("textures", *resources->textureTable);
    ids.blases = renderer.ImportBlasSet("BLASes", blasState);
    if (deform) deform->DeclareDeformation(renderer, ids, *lights, draws);
    DeclareBlasWork(renderer, ids);
    DeclareMaterialUpload(renderer, ids);
    DeclareGeometryUpload(renderer, ids);
    lights->Declare(renderer, ids, *instances);
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
           (!m_impl->deform || !m_impl->deform->HasWork()) &&
           m_impl->instances->PendingWork() == TlasWork::None;
}

}  // namespace raygraph

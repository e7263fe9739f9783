#include "renderer/gpu_scene/gpu_scene.h"

#include <cstring>
#include <utility>

#include "base/counted.h"
#include "base/out_of_memory.h"
#include "base/text.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/gpu_scene/materials/energy_tables.h"
#include "renderer/gpu_scene/materials/material_records.h"
#include "renderer/scene/geometry/flat_transform.h"
#include "renderer/scene/model/check.h"

namespace raygraph {

GpuScene::Impl::Impl(Renderer& renderer, const GpuSceneDesc& desc) : context(renderer.Device(), desc) {
    const auto tables = std::as_bytes(EnergyTables());
    constexpr auto kTableUsage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination;
    energyTables =
        context.device.CreateBuffer({.name = "energy tables", .size = tables.size(), .usage = kTableUsage});
    context.uploader.UploadBuffer(energyTables, 0, tables);
    PreparedContent nothing;
    SetContent(nothing);
}

GpuScene::GpuScene(Renderer& renderer, const GpuSceneDesc& desc)
    : m_impl(WithMemoryErrors("GpuScene", [&] { return std::make_unique<Impl>(renderer, desc); })) {}
GpuScene::~GpuScene() = default;

void GpuScene::Impl::RequireNoFrame(const char* call) {
    if (!declaredIn.expired())
        throw MakeError(ErrorKind::Usage,
                        "GpuScene: {} between Declare and Execute; it comes before Declare or after Execute",
                        call);
    scene->blases.MarkUsed();  // cleared when a frame has shown the edit
}

void GpuScene::SetScene(scene::SceneData&& scene) {
    m_impl->RequireNoFrame("SetScene");
    PreparedScene prepared(std::move(scene), m_impl->Preparing(), "SetScene");
    try {
        SetScene(std::move(prepared));
    } catch (...) {
        scene = std::move(prepared.m_content->data);
        scene.meshes.clear();  // Some meshes have been freed, so that a retry would lack them
        throw;
    }
}

void GpuScene::SetScene(PreparedScene&& scene) {
    m_impl->RequireNoFrame("SetScene");
    const bool makesRoom = scene.m_content->meshes.empty();
    WithMemoryErrors("SetScene", [&] { m_impl->SetContent(*scene.m_content); });
    m_impl->context.disposer.Dispose(std::move(scene.m_content));
    if (makesRoom) m_impl->context.device.WaitIdle();
}

std::shared_ptr<SceneUpload> GpuScene::Upload(PreparedScene&& scene) {
    m_impl->RequireNoFrame("Upload");
    return WithMemoryErrors("Upload", [&] { return m_impl->streams.Upload(std::move(scene)); });
}

void GpuScene::SetScene(SceneUpload& upload) {
    m_impl->RequireNoFrame("SetScene");
    if (upload.m_error) std::rethrow_exception(std::exchange(upload.m_error, nullptr));
    if (!upload.m_impl) throw Error(ErrorKind::Usage, "GpuScene: SetScene: the scene has been set before");
    std::unique_ptr<PreparedContent> content = std::move(upload.m_content);
    const std::unique_ptr<SceneUpload::Impl> taken = std::move(upload.m_impl);
    const Stopwatch watch;
    WithMemoryErrors("SetScene", [&] {
        if (!taken->IsDone()) taken->Complete();
        m_impl->Replace(*content, *taken, watch);
        m_impl->streams.End(*taken);
        m_impl->context.disposer.Dispose(std::move(content));
    });
}

void GpuScene::Impl::SetContent(PreparedContent& content) {
    const Stopwatch watch;
    CheckLimits(context.device, content);
    context.device.CollectGarbage();  // frees memory that frames have released
    SceneUpload::Impl upload(context, context.uploader, content);
    Replace(content, upload, watch);
}

void GpuScene::Impl::Replace(PreparedContent& content, SceneUpload::Impl& upload, const Stopwatch& watch) {
    std::optional<EnvironmentOnDevice> newEnvironment;
    std::unique_ptr<SceneObjects> newScene;
    context.uploader.FlushAfter([&] {
        newScene = upload.Finish();
        if (content.data.environment.IsPresent())
            newEnvironment =
                UploadEnvironment(context.device, context.uploader, content.data.environment.map);
    });
    streams.StopAll();
    scene = std::move(newScene);
    context.builder.Trim();
    context.environment.SetScene(std::move(newEnvironment), content.hasOwnLight);
    content.data.environment = {};
    ++context.revisions.geometry;
    context.statistics.uploadMs = watch.Milliseconds();
    context.statistics.textureBudget = upload.TextureBudget();
    const Log& log = context.device.Log();
    if (const std::string& warning = upload.Warning(); !warning.empty())
        log.Send(LogLevel::Warning, log_category::kScene, warning);
    scene->RefreshStatistics();
    if (context.statistics.instanceCount > 0)
        Say(log, LogLevel::Info, log_category::kScene, "uploaded in {}: {} in {}",
            DurationText(watch.Seconds()), Counted(context.statistics.trianglesPlaced, "triangle"),
            Counted(context.statistics.instanceCount, "instance"));
}

void GpuScene::SetTransforms(std::span<const uint32_t> instances,
                             std::span<const scene::PlacedTransform> objectToWorld) {
    m_impl->RequireNoFrame("SetTransform");
    const InstanceSet& set = m_impl->scene->instances;
    if (instances.size() != objectToWorld.size())
        throw MakeError(ErrorKind::Usage, "GpuScene: SetTransforms: {} for {}",
                        Counted(objectToWorld.size(), "transform"), Counted(instances.size(), "instance"));
    // A copy in which flat transforms have a thickness; empty if none is flat.
    std::vector<scene::PlacedTransform> solid;
    for (size_t i = 0; i < instances.size(); ++i) {
        m_impl->scene->RequireInstance(instances[i]);
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
    WithMemoryErrors("SetTransform", [&] { m_impl->scene->SetTransforms(instances, objectToWorld); });
}

bool GpuScene::HasInstance(uint32_t instance) const {
    return m_impl->scene->instances.Exists(instance);
}

const scene::PlacedTransform& GpuScene::Transform(uint32_t instance) const {
    m_impl->scene->RequireInstance(instance);
    return m_impl->scene->instances.Transform(instance);
}

bool GpuScene::UsesWideBvhs() const {
    return m_impl->context.traversal == Traversal::Own;
}

void GpuScene::SetViewpoint(const glm::dvec3& eye) {
    m_impl->RequireNoFrame("SetViewpoint");
    m_impl->scene->SetViewpoint(eye);
}

void GpuScene::SetVisible(std::span<const uint32_t> instances, bool isVisible) {
    m_impl->RequireNoFrame("SetVisible");
    for (const uint32_t instance : instances) m_impl->scene->RequireInstance(instance);
    WithMemoryErrors("SetVisible", [&] { m_impl->scene->SetVisible(instances, isVisible); });
}

bool GpuScene::IsVisible(uint32_t instance) const {
    m_impl->scene->RequireInstance(instance);
    return m_impl->scene->instances.IsVisible(instance);
}

void GpuScene::SetMaterial(uint32_t material, const scene::Material& values) {
    m_impl->RequireNoFrame("SetMaterial");
    m_impl->scene->RequireMaterial(material);
    scene::Check(values, Text("GpuScene: SetMaterial: material {}", material));
    const gpu::MaterialRecord& shown = m_impl->scene->materials->Records()[material];
    const gpu::MaterialRecord record = ToRecord(values, shown);
    // scene_records.h asserts that there is no padding, which might differ
    if (std::memcmp(&record, &shown, sizeof(record)) == 0) return;
    WithMemoryErrors("SetMaterial", [&] { m_impl->scene->SetMaterial(material, record); });
}

void GpuScene::SetVariant(uint32_t variant) {
    m_impl->RequireNoFrame("SetVariant");
    if (variant != scene::kNone) RequireIndex("variant", variant, m_impl->scene->geometry->variantCount);
    if (m_impl->scene->geometry->variant == variant) return;
    WithMemoryErrors("SetVariant", [&] { m_impl->scene->SetVariant(variant); });
}

uint32_t GpuScene::Variant() const {
    return m_impl->scene->geometry->variant;
}

void GpuScene::SetLightVisible(uint32_t light, bool isVisible) {
    m_impl->RequireNoFrame("SetLightVisible");
    m_impl->scene->RequireLight(light);
    if (m_impl->scene->lights.IsPunctualVisible(light) == isVisible) return;
    m_impl->scene->lights.SetPunctualVisible(light, isVisible);
    ++m_impl->context.revisions.lights;
}

bool GpuScene::IsLightVisible(uint32_t light) const {
    m_impl->scene->RequireLight(light);
    return m_impl->scene->lights.IsPunctualVisible(light);
}

void GpuScene::SetLight(uint32_t light, const scene::Light& values) {
    m_impl->RequireNoFrame("SetLight");
    m_impl->scene->RequireLight(light);
    if (m_impl->scene->lights.Punctual(light) == values) return;
    WithMemoryErrors("SetLight", [&] { m_impl->scene->lights.SetPunctual(light, values); });
    ++m_impl->context.revisions.lights;
}

const scene::Light& GpuScene::Light(uint32_t light) const {
    m_impl->scene->RequireLight(light);
    return m_impl->scene->lights.Punctual(light);
}

void GpuScene::SetLightGroups(LightGroups groups) {
    m_impl->RequireNoFrame("SetLightGroups");
    RequireFitting(groups, m_impl->scene->instances.Count(), m_impl->scene->materials->Size(),
                   m_impl->scene->lights.PunctualCount());
    m_impl->scene->lights.SetGroups(std::move(groups));
}

void GpuScene::SetEnvironment(const EnvironmentSettings& settings) {
    m_impl->RequireNoFrame("SetEnvironment");
    if (m_impl->context.environment.Set(settings)) ++m_impl->context.revisions.environment;
}

const EnvironmentSettings& GpuScene::Environment() const {
    return m_impl->context.environment.Settings();
}

EnvironmentSettings GpuScene::ShownEnvironment() const {
    return m_impl->context.environment.Shown();
}

void GpuScene::SetEnvironmentMap(const image::ImageF& equirectangular) {
    m_impl->RequireNoFrame("SetEnvironmentMap");
    WithMemoryErrors("SetEnvironmentMap", [&] { m_impl->context.environment.SetMap(equirectangular); });
    ++m_impl->context.revisions.environment;
}

void GpuScene::RemoveEnvironmentMap() {
    m_impl->RequireNoFrame("RemoveEnvironmentMap");
    if (m_impl->context.environment.RemoveMap()) ++m_impl->context.revisions.environment;
}

SceneIds GpuScene::Declare(Renderer& renderer) {
    m_impl->RequireNoFrame("Declare");
    return WithMemoryErrors("GpuScene", [&] {
        Impl& impl = *m_impl;
        impl.declaredIn = renderer.OpenFrame();
        impl.streams.Continue(*impl.scene);
        SceneIds ids;
        ids.energyTables = renderer.Import("energyTables", impl.energyTables, impl.energyTablesState);
        if (impl.context.desc.textureLevels) ids.features |= kTraceTextureLod;
        impl.scene->Declare(renderer, ids);
        return ids;
    });
}

const GpuSceneStatistics& GpuScene::Statistics() const {
    m_impl->scene->RefreshStatistics();
    return m_impl->context.statistics;
}

const SceneRevisions& GpuScene::Revisions() const {
    return m_impl->context.revisions;
}

bool GpuScene::IsSettled() const {
    return m_impl->scene->IsSettled() && m_impl->context.builder.Statistics().pending == 0 &&
           m_impl->streams.IsDone();
}

}  // namespace raygraph

#include "renderer/gpu_scene/gpu_scene.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/printable.h"
#include "base/text.h"
#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/geometry/wide_set.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/gpu_scene/host_objects.h"
#include "renderer/gpu_scene/instances/scene_objects.h"
#include "renderer/gpu_scene/materials/energy_tables.h"
#include "renderer/gpu_scene/materials/scene_materials.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/ground.h"

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
    ground.reset();
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
        WriteLog(log, LogLevel::Info, log_category::kScene, "uploaded in {}: {} in {}",
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
    return m_impl->context.traversal == Traversal::Software;
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

void GpuScene::SetHostMask(std::span<const uint32_t> instances, uint8_t mask) {
    m_impl->RequireNoFrame("SetHostMask");
    for (const uint32_t instance : instances) m_impl->scene->RequireInstance(instance);
    if ((mask & ~kMaskHost) != 0)
        throw MakeError(ErrorKind::Usage,
                        "GpuScene: SetHostMask: 0x{:02x} has bits that are not the host's, 0x{:02x}", mask,
                        kMaskHost);
    WithMemoryErrors("SetHostMask", [&] { m_impl->scene->instances.SetHostMask(instances, mask); });
}

uint8_t GpuScene::HostMask(uint32_t instance) const {
    m_impl->scene->RequireInstance(instance);
    return m_impl->scene->instances.HostMask(instance);
}

void GpuScene::SetHitSet(std::span<const uint32_t> instances, uint32_t number) {
    m_impl->RequireNoFrame("SetHitSet");
    for (const uint32_t instance : instances) m_impl->scene->RequireInstance(instance);
    if (number >= kHitSetNumbers)
        throw MakeError(ErrorKind::Usage, "GpuScene: SetHitSet: {} is beyond the last number, {}", number,
                        kHitSetNumbers - 1);
    WithMemoryErrors("SetHitSet",
                     [&] { m_impl->scene->instances.SetHitSet(instances, static_cast<uint8_t>(number)); });
}

uint32_t GpuScene::HitSet(uint32_t instance) const {
    m_impl->scene->RequireInstance(instance);
    return m_impl->scene->instances.HitSet(instance);
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

TextureSetId GpuScene::Textures(Renderer& renderer) const {
    return renderer.Import("textures", m_impl->scene->materials->Textures().Table());
}

void GpuScene::SwapTextures(std::span<const uint32_t> a, std::span<const uint32_t> b) {
    m_impl->RequireNoFrame("SwapTextures");
    if (a.size() != b.size())
        throw MakeError(ErrorKind::Usage, "GpuScene: SwapTextures: {} and {} textures", a.size(), b.size());
    const TextureSet& textures = m_impl->scene->materials->Textures();
    for (const std::span<const uint32_t> list : {a, b})
        for (const uint32_t texture : list)
            if (!textures.Exists(texture))
                throw MakeError(ErrorKind::Usage, "GpuScene: SwapTextures: there is no texture {}", texture);
    WithMemoryErrors("SwapTextures", [&] { m_impl->scene->SwapTextures(a, b); });
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

SceneMemory GpuScene::Memory() const {
    const SceneObjects& scene = *m_impl->scene;
    SceneMemory memory;
    const std::span<const InstanceSet::Placement> placements = scene.instances.Placements();
    for (uint32_t i = 0; i < placements.size(); ++i) {
        if (placements[i].group == InstanceSet::kNoGroup) continue;
        if (!scene.instances.IsVisible(placements[i].instance)) continue;
        const GroupResources& group = scene.geometry->groups[placements[i].group];
        const auto triangles = static_cast<uint32_t>(group.triangleCount);
        memory.placements.push_back({.record = i,
                                     .primitives = group.kind.isRound ? group.capsuleCount : triangles,
                                     .flags = WideFlagsOf(group.kind)});
    }
    for (const GroupResources& group : scene.geometry->groups)
        if (group.streams) memory.streams.push_back(&group.streams);
    if (scene.geometry->deform) memory.streams.push_back(&scene.geometry->deform->streams);
    const TextureSet& textures = scene.materials->Textures();
    for (uint32_t i = 0; i < textures.Size(); ++i)
        if (textures.Exists(i))
            memory.textures.push_back({textures.Slot(i), &textures.Image(i).Shown(), textures.SamplerOf(i)});
    return memory;
}

bool GpuScene::IsSettled() const {
    return m_impl->scene->IsSettled() && m_impl->context.builder.Statistics().pending == 0 &&
           m_impl->streams.IsDone();
}

// --- Calls that add objects and remove them: their checks, and their rollback on an Error ---

namespace {

[[noreturn]] void RejectRemoval(const char* what, uint32_t index, uint32_t count, const char* users) {
    throw MakeError(ErrorKind::Usage, "GpuScene: {} {} cannot be removed: {} {} use it", what, index, count,
                    users);
}

void RequireStream(const HostMesh& mesh, const char* name, const HostStream& stream, uint64_t count,
                   uint64_t bytes) {
    if (!stream) return;
    const uint64_t size = stream.buffer->Size();
    if (stream.offset % 4 == 0 && stream.offset <= size && count <= (size - stream.offset) / bytes) return;
    throw MakeError(
        ErrorKind::Usage,
        "GpuScene: AddMesh: '{}': {} of {} bytes from byte {} of a buffer of {}, and a multiple of 4",
        mesh.name, name, count * bytes, stream.offset, size);
}

void RequireStreams(const HostMesh& mesh) {
    const uint64_t vertices = mesh.vertexCount;
    RequireStream(mesh, "positions", mesh.positions, vertices, sizeof(glm::vec3));
    RequireStream(mesh, "indices", mesh.indices, uint64_t{3} * mesh.triangleCount, sizeof(uint32_t));
    RequireStream(mesh, "normals", mesh.normals, vertices, sizeof(glm::vec3));
    RequireStream(mesh, "tangents", mesh.tangents, vertices, sizeof(glm::vec4));
    RequireStream(mesh, "uv0", mesh.uv0, vertices, sizeof(glm::vec2));
    RequireStream(mesh, "uv1", mesh.uv1, vertices, sizeof(glm::vec2));
    RequireStream(mesh, "colors", mesh.colors, vertices, sizeof(glm::vec4));
    if (!mesh.positions || !mesh.indices || mesh.triangleCount == 0)
        throw MakeError(ErrorKind::Usage, "GpuScene: AddMesh: '{}' has no triangles", mesh.name);
}

void RequireBounds(const char* call, const scene::Bounds& bounds) {
    if (bounds.IsEmpty() || !scene::IsFinite(bounds.min) || !scene::IsFinite(bounds.max))
        throw MakeError(ErrorKind::Usage, "GpuScene: {}: the bounds are empty or not finite", call);
}

}  // namespace

AddedPart GpuScene::Add(PreparedScene&& part) {
    m_impl->RequireNoFrame("Add");
    return WithMemoryErrors("Add", [&] { return m_impl->streams.Add(std::move(part), *m_impl->scene); });
}

AddedPart GpuScene::Add(scene::SceneData&& part) {
    m_impl->RequireNoFrame("Add");
    return Add(PreparedScene(std::move(part), m_impl->Preparing(), "Add"));
}

void GpuScene::SetGround(const scene::Bounds& bounds) {
    std::optional<Impl::Ground>& ground = m_impl->ground;
    if (!ground && bounds.IsEmpty()) return;
    if (ground && ground->bounds.min == bounds.min && ground->bounds.max == bounds.max) return;
    if (bounds.IsEmpty()) {
        Remove(ground->part);
        ground.reset();
        return;
    }
    scene::SceneData data = scene::GroundUnder(bounds);
    if (!ground) {
        ground = {Add(std::move(data)), bounds};
        return;
    }
    const scene::Instance& place = data.instances.front();
    SetTransform(ground->part.instances.front(),
                 scene::PlacedTransform{place.objectToWorld, place.translationResidual});
    ground->bounds = bounds;
}

std::shared_ptr<const AddedPart> GpuScene::Stream(PreparedScene&& part) {
    m_impl->RequireNoFrame("Stream");
    return WithMemoryErrors("Stream",
                            [&] { return m_impl->streams.Stream(std::move(part), *m_impl->scene); });
}

StreamProgress GpuScene::Streaming() const {
    return m_impl->streams.Streaming();
}

void GpuScene::Remove(const AddedPart& part) {
    m_impl->RequireNoFrame("Remove");
    const AddedPart removed = part;  // a copy, since `part` may be the stream's own
    m_impl->streams.Stop(removed.owner);
    WithMemoryErrors("Remove", [&] { m_impl->scene->Remove(removed); });
}

uint32_t GpuScene::AddInstance(uint32_t mesh, const scene::PlacedTransform& objectToWorld, bool isVisible) {
    m_impl->RequireNoFrame("AddInstance");
    m_impl->scene->RequireMesh(mesh);
    if (!m_impl->scene->CanBePlaced(mesh))
        throw MakeError(ErrorKind::Usage, "GpuScene: AddInstance: mesh {} is there as deformed copies alone",
                        mesh);
    const scene::PlacedTransform shown = scene::CheckedPlacement(
        objectToWorld, m_impl->scene->instances.BoundsOf(mesh), "GpuScene: AddInstance");
    return WithMemoryErrors("AddInstance", [&] {
        const uint32_t number = m_impl->scene->AddInstance(mesh, shown, isVisible);
        if (m_impl->scene->owners.meshes.Of(mesh) == kOwnedByNone && m_impl->scene->Emits(mesh))
            m_impl->context.environment.Sources().instances.insert(number);
        return number;
    });
}

uint32_t GpuScene::AddMesh(scene::Mesh&& mesh) {
    m_impl->RequireNoFrame("AddMesh");
    return WithMemoryErrors("AddMesh", [&] { return m_impl->scene->AddMesh(std::move(mesh)); });
}

uint32_t GpuScene::AddMesh(const HostMesh& mesh) {
    m_impl->RequireNoFrame("AddMesh");
    m_impl->scene->RequireMaterial(mesh.material);
    RequireStreams(mesh);
    RequireBounds("AddMesh", mesh.bounds);
    return WithMemoryErrors("AddMesh", [&] { return m_impl->scene->AddMesh(mesh); });
}

void GpuScene::MarkChanged(uint32_t mesh, const scene::Bounds& bounds) {
    m_impl->RequireNoFrame("MarkChanged");
    m_impl->scene->RequireMesh(mesh);
    if (!m_impl->scene->IsHostMesh(mesh))
        throw MakeError(ErrorKind::Usage, "GpuScene: MarkChanged: mesh {} is not one of the host's", mesh);
    RequireBounds("MarkChanged", bounds);
    WithMemoryErrors("MarkChanged", [&] { m_impl->scene->MarkChanged(mesh, bounds); });
}

uint32_t GpuScene::AddMaterial(const scene::Material& material) {
    m_impl->RequireNoFrame("AddMaterial");
    scene::Check(material, "GpuScene: AddMaterial");
    const uint32_t textureCount = m_impl->scene->materials->Textures().Size();
    for (const uint32_t texture : TexturesOf(material)) {
        RequireIndex("texture", texture, textureCount);
        m_impl->scene->RequireTexture(texture);
    }
    return WithMemoryErrors("AddMaterial", [&] {
        std::vector<uint32_t> numbers(textureCount);
        for (uint32_t i = 0; i < textureCount; ++i)
            numbers[i] = m_impl->scene->materials->Textures().Exists(i) ? i : scene::kNone;
        return m_impl->scene->AddMaterial(material, numbers);
    });
}

uint32_t GpuScene::AddTexture(const HostTexture& texture) {
    m_impl->RequireNoFrame("AddTexture");
    if (!texture.texture) throw Error(ErrorKind::Usage, "GpuScene: AddTexture: there is no texture");
    return WithMemoryErrors("AddTexture", [&] { return m_impl->scene->AddTexture(texture); });
}

uint32_t GpuScene::AddLight(const scene::Light& light, bool isVisible) {
    m_impl->RequireNoFrame("AddLight");
    return WithMemoryErrors("AddLight", [&] {
        const uint32_t number = m_impl->scene->AddLight(light, isVisible, LightOwner::OfHost);
        m_impl->context.environment.Sources().lights.insert(number);
        return number;
    });
}

void GpuScene::RemoveInstance(uint32_t instance) {
    m_impl->RequireNoFrame("RemoveInstance");
    m_impl->scene->RequireInstance(instance);
    if (m_impl->scene->IsDeformed(instance))
        throw MakeError(ErrorKind::Usage, "GpuScene: instance {} is deformed: it goes with the scene alone",
                        instance);
    WithMemoryErrors("RemoveInstance", [&] { m_impl->scene->RemoveInstance(instance); });
}

void GpuScene::RemoveMesh(uint32_t mesh) {
    m_impl->RequireNoFrame("RemoveMesh");
    m_impl->scene->RequireMesh(mesh);
    const MeshResources& removed = m_impl->scene->geometry->meshes[mesh];
    if (removed.isDeformed)
        throw MakeError(ErrorKind::Usage, "GpuScene: mesh {} is deformed: it goes with the scene alone",
                        mesh);
    if (removed.instanceCount > 0) RejectRemoval("mesh", mesh, removed.instanceCount, "instances");
    m_impl->streams.RequireComplete("mesh", mesh, m_impl->scene->owners.meshes);
    m_impl->scene->ReleaseMesh(mesh);
    ++m_impl->context.revisions.geometry;
}

void GpuScene::RemoveMaterial(uint32_t material) {
    m_impl->RequireNoFrame("RemoveMaterial");
    m_impl->scene->RequireMaterial(material);
    if (const uint32_t count = m_impl->scene->materials->PartCount(material); count > 0)
        RejectRemoval("material", material, count, "primitives");
    m_impl->streams.RequireComplete("material", material, m_impl->scene->owners.materials);
    m_impl->scene->RemoveMaterial(material);
}

void GpuScene::RemoveTexture(uint32_t texture) {
    m_impl->RequireNoFrame("RemoveTexture");
    m_impl->scene->RequireTexture(texture);
    if (const uint32_t count = m_impl->scene->materials->MaterialCount(texture); count > 0)
        RejectRemoval("texture", texture, count, "materials");
    m_impl->streams.RequireComplete("texture", texture, m_impl->scene->owners.textures);
    WithMemoryErrors("RemoveTexture", [&] { m_impl->scene->RemoveTexture(texture); });
}

void GpuScene::RemoveLight(uint32_t light) {
    m_impl->RequireNoFrame("RemoveLight");
    m_impl->scene->RequireLight(light);
    WithMemoryErrors("RemoveLight", [&] { m_impl->scene->RemoveLight(light); });
}

// --- Poses: everything that an animation has changed is applied as by the setters above ---

void GpuScene::SetJointMatrices(uint32_t skin, std::span<const glm::mat4x3> matrices) {
    m_impl->RequireNoFrame("SetJointMatrices");
    m_impl->scene->RequireMatrices("SetJointMatrices", skin, matrices.size());
    if (m_impl->scene->deform->SetJointMatrices(skin, matrices)) ++m_impl->context.revisions.shapes;
}

void GpuScene::SetMorphWeights(uint32_t instance, std::span<const float> weights) {
    m_impl->RequireNoFrame("SetMorphWeights");
    m_impl->scene->RequireWeights("SetMorphWeights", instance, weights.size());
    if (m_impl->scene->deform->SetMorphWeights(instance, weights)) ++m_impl->context.revisions.shapes;
}

void GpuScene::SetPose(const scene::SceneData& posed, const scene::PoseApplier& applier,
                       const scene::PoseChanges& changes) {
    m_impl->RequireNoFrame("SetPose");
    const auto require = [](const char* what, size_t given, size_t there) {
        if (given != there)
            throw MakeError(ErrorKind::Usage, "GpuScene: SetPose: {} {}, the scene has {}", given, what,
                            there);
    };
    require("instances", posed.instances.size(), m_impl->scene->setInstances);
    require("materials", posed.materials.size(), m_impl->scene->setMaterials);
    require("lights", posed.lights.size(), m_impl->scene->setLights);
    const DeformResources* const deform = m_impl->scene->geometry->deform.get();
    if (!changes.skins.empty()) require("skins", posed.skins.size(), deform ? deform->skins.size() : 0);
    for (const uint32_t i : changes.skins)
        m_impl->scene->RequireMatrices("SetPose", i, applier.JointMatricesOf(i).size());
    // A mesh may have weights without targets, which then move nothing
    const auto isMorphed = [&](uint32_t i) { return scene::HasTargets(posed, posed.instances[i]); };
    for (const uint32_t i : changes.reweighted)
        if (isMorphed(i))
            m_impl->scene->RequireWeights("SetPose", i,
                                          scene::MorphWeights(posed, posed.instances[i]).size());

    const auto isOwnedByScene = [](const Owners& owners, uint32_t i) {
        return owners.Of(i) == kOwnedByScene;
    };
    std::vector<uint32_t> moved, shown, hidden;
    std::vector<scene::PlacedTransform> places;
    WithMemoryErrors("SetPose", [&] {
        for (const uint32_t i : changes.instances) {
            if (!isOwnedByScene(m_impl->scene->owners.instances, i)) continue;
            moved.push_back(i);
            places.push_back({posed.instances[i].objectToWorld, posed.instances[i].translationResidual});
        }
        for (const uint32_t i : changes.shown)
            if (isOwnedByScene(m_impl->scene->owners.instances, i))
                (applier.IsVisible(i) ? shown : hidden).push_back(i);
    });
    SetTransforms(moved, places);
    SetVisible(shown, true);
    SetVisible(hidden, false);
    for (const uint32_t i : changes.materials)
        if (isOwnedByScene(m_impl->scene->owners.materials, i)) SetMaterial(i, posed.materials[i]);
    for (const uint32_t i : changes.lights)
        WithMemoryErrors("SetPose", [&] {
            if (!isOwnedByScene(m_impl->scene->owners.lights, i) ||
                m_impl->scene->lights.Punctual(i) == posed.lights[i])
                return;
            m_impl->scene->lights.SetPunctual(i, posed.lights[i], LightOwner::OfNode);
            ++m_impl->context.revisions.lights;
        });
    LightSources& sources = m_impl->context.environment.Sources();
    for (const uint32_t i : changes.lightsShown) {
        if (!isOwnedByScene(m_impl->scene->owners.lights, i)) continue;
        SetLightVisible(i, applier.IsLightVisible(i));
        if (i < m_impl->scene->firstExtendedLight) continue;
        if (applier.IsLightVisible(i))
            sources.lights.insert(i);
        else
            sources.lights.erase(i);
    }
    for (const uint32_t i : changes.skins)
        if (m_impl->scene->deform->FollowJoints(i, applier.JointMatricesOf(i)))
            ++m_impl->context.revisions.shapes;
    for (const uint32_t i : changes.reweighted)
        if (isMorphed(i)) SetMorphWeights(i, scene::MorphWeights(posed, posed.instances[i]));
}

void GpuScene::SetPose(const scene::SceneData& posed, const scene::PoseApplier& applier) {
    const auto numbers = [](size_t count) {
        std::vector<uint32_t> all(count);
        std::iota(all.begin(), all.end(), 0u);
        return all;
    };
    scene::PoseChanges all;
    WithMemoryErrors("SetPose", [&] {
        all.instances = all.shown = numbers(posed.instances.size());
        all.materials = numbers(posed.materials.size());
        all.lights = all.lightsShown = numbers(posed.lights.size());
        for (uint32_t i = 0; i < posed.skins.size(); ++i)
            if (!applier.JointMatricesOf(i).empty()) all.skins.push_back(i);
        for (uint32_t i = 0; i < posed.instances.size(); ++i)
            if (posed.instances[i].isDeformed) all.reweighted.push_back(i);
    });
    SetPose(posed, applier, all);
    m_impl->scene->RestartOrigin();
}

void GpuScene::Extend(const scene::SceneData& posed) {
    m_impl->RequireNoFrame("Extend");
    if (m_impl->ground) {  // it makes room for their indices
        const scene::Bounds bounds = m_impl->ground->bounds;
        SetGround({});
        try {
            Extend(posed);
        } catch (...) {
            SetGround(bounds);
            throw;
        }
        return SetGround(bounds);
    }
    SceneObjects& scene = *m_impl->scene;
    const size_t firstInstance = scene.setInstances, firstLight = scene.setLights;
    if (posed.instances.size() < firstInstance || posed.lights.size() < firstLight)
        throw Error(ErrorKind::Usage, "GpuScene: Extend: the outline has fewer objects than the scene");
    const auto require = [](uint32_t index, size_t expected) {
        if (index != expected)
            throw Error(ErrorKind::Usage,
                        "GpuScene: Extend: objects have been added or removed, so that indices differ");
    };
    std::vector<scene::PlacedTransform> places;
    for (size_t i = firstInstance; i < posed.instances.size(); ++i) {
        const scene::Instance& instance = posed.instances[i];
        scene.RequireMesh(instance.mesh);
        if (instance.isDeformed || !scene.CanBePlaced(instance.mesh))
            throw MakeError(ErrorKind::Usage, "GpuScene: Extend: instance {} is deformed", i);
        places.push_back(scene::CheckedPlacement({instance.objectToWorld, instance.translationResidual},
                                                 scene.instances.BoundsOf(instance.mesh),
                                                 Text("GpuScene: Extend: instance {}", i)));
    }
    WithMemoryErrors("Extend", [&] {
        scene.owners.instances.Reserve(posed.instances.size());
        scene.owners.lights.Reserve(posed.lights.size());
        std::vector<uint32_t> instances, lights;
        try {
            for (size_t i = firstInstance; i < posed.instances.size(); ++i) {
                instances.push_back(
                    scene.AddInstance(posed.instances[i].mesh, places[i - firstInstance], false));
                require(instances.back(), i);
                scene.owners.instances.Set(instances.back(), kOwnedByScene);
            }
            for (size_t i = firstLight; i < posed.lights.size(); ++i) {
                lights.push_back(scene.AddLight(posed.lights[i], false, LightOwner::OfNode));
                require(lights.back(), i);
                scene.owners.lights.Set(lights.back(), kOwnedByScene);
            }
        } catch (...) {
            for (; !lights.empty(); lights.pop_back()) scene.RemoveLight(lights.back());
            for (; !instances.empty(); instances.pop_back()) scene.RemoveInstance(instances.back());
            throw;
        }
        scene.setInstances = posed.instances.size();
        scene.setLights = posed.lights.size();
    });
}

}  // namespace raygraph

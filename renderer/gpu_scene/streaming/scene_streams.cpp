#include "renderer/gpu_scene/streaming/scene_streams.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "base/text.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/materials/scene_materials.h"
#include "renderer/scene/model/variants.h"

namespace raygraph {
namespace {

// The cost of an instance in a frame's budget, in bytes.
constexpr uint64_t kInstanceCost = 256;

void Charge(uint64_t& budget, uint64_t cost) {
    budget -= std::min(cost, budget);
}

[[noreturn]] void Reject(const char* call, const std::string& why) {
    throw MakeError(ErrorKind::Usage, "GpuScene: {}: {}", call, why);
}

// Throws Error{Usage} for content that a part must not have.
void RequirePart(const char* call, const scene::SceneData& part) {
    for (size_t i = 0; i < part.instances.size(); ++i)
        if (part.instances[i].isDeformed)
            Reject(call, Text("instances[{}] is deformed; only SetScene takes those", i));
    for (size_t i = 0; i < part.lights.size(); ++i)
        if (part.lights[i].profile != scene::kNone)
            Reject(call, Text("lights[{}] has a profile; only SetScene takes those", i));
}

}  // namespace

SceneStreams::Part SceneStreams::Begin(const char* call, PreparedScene&& part, rhi::Uploader& with,
                                       const SceneObjects& scene) {
    scene::SceneData& data = part.m_content->data;
    RequirePart(call, data);
    CheckLimits(m_context.device, *part.m_content);
    for (PackedMesh& mesh : part.m_content->meshes) DropVariants(mesh);
    const auto added = std::make_shared<AddedPart>();
    added->owner = ++m_lastOwner;
    added->textures.assign(data.textures.size(), scene::kNone);
    added->materials.assign(data.materials.size(), scene::kNone);
    added->meshes.assign(data.meshes.size(), scene::kNone);
    added->instances.assign(data.instances.size(), scene::kNone);
    added->lights.assign(data.lights.size(), scene::kNone);
    uint64_t used = scene.materials->Textures().Bytes();
    for (const Part& before : m_parts) used += before.textures.PendingBytes();
    const uint64_t whole = m_context.statistics.textureBudget;
    TextureUpload textures(m_context.device, with, data,
                           m_context.TextureSettings(whole - std::min(used, whole)));
    if (const std::string& warning = textures.Reduction(); !warning.empty())
        m_context.device.Log().Send(LogLevel::Warning, log_category::kScene, warning);
    MeshUpload meshes(m_context, with, part.m_content->meshes, added->materials);
    if (part.m_content->hasOwnLight) m_context.environment.Sources().parts.insert(added->owner);
    return {.content = std::move(part.m_content),
            .added = added,
            .textures = std::move(textures),
            .meshes = std::move(meshes),
            .isVisible = scene::VisibleNodes(data)};
}

bool SceneStreams::ContinueTexture(Part& part, SceneObjects& scene, uint32_t texture, uint64_t& budget) {
    uint32_t& number = part.added->textures[texture];
    if (number != scene::kNone) return true;
    if (!part.textures.Continue(texture, budget, !part.isStreamed)) return false;
    const SceneTexture made = part.textures.Get(texture);
    scene.owners.textures.Reserve(scene.materials->Textures().Size() + size_t{1});
    number = scene.materials->AddTextures({&made, 1}).front();
    scene.owners.textures.Set(number, part.added->owner);
    return true;
}

bool SceneStreams::ContinueMaterial(Part& part, SceneObjects& scene, uint32_t material, uint64_t& budget) {
    uint32_t& number = part.added->materials[material];
    if (number != scene::kNone) return true;
    const scene::Material& values = part.content->data.materials[material];
    for (const uint32_t texture : TexturesOf(values))
        if (!ContinueTexture(part, scene, texture, budget)) return false;
    scene.owners.materials.Reserve(scene.materials->Size() + 1);
    number = scene.AddMaterial(values, part.added->textures);
    scene.owners.materials.Set(number, part.added->owner);
    return true;
}

bool SceneStreams::ContinueMesh(Part& part, SceneObjects& scene, uint32_t mesh, uint64_t& budget) {
    uint32_t& number = part.added->meshes[mesh];
    if (number != scene::kNone) return true;
    for (const PackedGroup& group : part.content->meshes[mesh].groups)
        for (const GroupPart& groupPart : group.parts)
            if (!ContinueMaterial(part, scene, groupPart.material, budget)) return false;
    // Its first groups are built in this frame: building all in a later one would make that frame long
    scene.blases.MarkUnbuilt();
    if (!part.meshes.Continue(mesh, budget, !part.isStreamed)) return false;
    scene.owners.meshes.Reserve(scene.geometry->meshes.size() + 1);
    number = scene.AddMesh(part.meshes.Take());
    scene.owners.meshes.Set(number, part.added->owner);
    return true;
}

bool SceneStreams::Continue(Part& part, SceneObjects& scene, uint64_t& budget) {
    const scene::SceneData& data = part.content->data;
    AddedPart& added = *part.added;
    for (; part.light < data.lights.size(); ++part.light) {
        const scene::Light& light = data.lights[part.light];
        scene.owners.lights.Reserve(scene.lights.PunctualCount() + size_t{1});
        const uint32_t number =
            scene.AddLight(light, scene::IsVisible(part.isVisible, light.node), LightOwner::OfNode);
        scene.owners.lights.Set(added.lights[part.light] = number, added.owner);
    }
    for (; part.instance < data.instances.size(); ++part.instance) {
        const scene::Instance& instance = data.instances[part.instance];
        if (budget == 0 || !ContinueMesh(part, scene, instance.mesh, budget)) return false;
        scene.owners.instances.Reserve(scene.instances.Count() + size_t{1});
        const uint32_t number = scene.AddInstance(added.meshes[instance.mesh],
                                                  {instance.objectToWorld, instance.translationResidual},
                                                  scene::IsVisible(part.isVisible, instance));
        scene.owners.instances.Set(added.instances[part.instance] = number, added.owner);
        Charge(budget, kInstanceCost);
    }
    for (; part.mesh < added.meshes.size(); ++part.mesh)
        if (!ContinueMesh(part, scene, part.mesh, budget)) return false;
    for (; part.material < added.materials.size(); ++part.material)
        if (!ContinueMaterial(part, scene, part.material, budget)) return false;
    for (; part.texture < added.textures.size(); ++part.texture)
        if (!ContinueTexture(part, scene, part.texture, budget)) return false;
    added.isComplete = true;
    return true;
}

void SceneStreams::End(Parts::iterator part) {
    if (part->textures.IsBusy()) m_ended.push_back(std::move(part->textures));
    std::unique_ptr<PreparedContent> content = std::move(part->content);
    m_parts.erase(part);
    m_context.disposer.Dispose(std::move(content));
    if (m_parts.empty()) m_endedBytes = 0;
}

void SceneStreams::Stop(uint32_t owner) {
    const auto part = std::ranges::find_if(m_parts, [&](const Part& p) { return p.added->owner == owner; });
    if (part != m_parts.end()) End(part);
}

void SceneStreams::StopAll() {
    while (!m_parts.empty()) End(m_parts.begin());
}

void SceneStreams::RequireComplete(const char* what, uint32_t index, const Owners& owners) const {
    const uint32_t owner = owners.Of(index);
    if (std::ranges::any_of(m_parts, [&](const Part& part) { return part.added->owner == owner; }))
        throw MakeError(ErrorKind::Usage, "GpuScene: {} {} cannot be removed: its part is on its way", what,
                        index);
}

AddedPart SceneStreams::Add(PreparedScene&& part, SceneObjects& scene) {
    Part added = Begin("Add", std::move(part), m_context.uploader, scene);
    try {
        uint64_t budget = UINT64_MAX;
        m_context.uploader.FlushAfter([&] { Continue(added, scene, budget); });
        m_context.builder.Reserve();
    } catch (...) {
        scene.Remove(*added.added);
        throw;
    }
    return std::move(*added.added);
}

std::shared_ptr<const AddedPart> SceneStreams::Stream(PreparedScene&& part, SceneObjects& scene) {
    m_parts.push_back(Begin("Stream", std::move(part), FrameUploader(), scene));
    m_parts.back().isStreamed = true;
    return m_parts.back().added;
}

StreamProgress SceneStreams::Streaming() const {
    StreamProgress progress{.bytes = m_endedBytes, .of = m_endedBytes};
    for (const Part& part : m_parts) {
        progress.bytes += part.CopiedBytes();
        progress.of += part.Bytes();
    }
    // A part without bytes is in progress, too
    if (!m_parts.empty()) progress.of += 1;
    return progress;
}

rhi::Uploader& SceneStreams::FrameUploader() {
    // A frame fills one of four pieces, while the other three may be in flight
    constexpr uint32_t kPieces = 4;
    if (!m_uploader)
        m_uploader.emplace(m_context.device,
                           rhi::UploaderDesc{.name = "stream",
                                             .queue = rhi::QueueKind::Transfer,  // beside the last frame
                                             .stagingBytes = kPieces * m_context.desc.streamBudget,
                                             .chunkCount = kPieces,
                                             .allocatesAhead = true});
    return *m_uploader;
}

std::shared_ptr<SceneUpload> SceneStreams::Upload(PreparedScene&& scene) {
    CheckLimits(m_context.device, *scene.m_content);
    auto impl = std::make_unique<SceneUpload::Impl>(m_context, FrameUploader(), *scene.m_content);
    const std::shared_ptr<SceneUpload> upload(new SceneUpload(std::move(scene.m_content), std::move(impl)));
    m_uploads.push_back(upload);
    return upload;
}

bool SceneStreams::ContinueStream(Part& part, SceneObjects& scene, uint64_t& budget) {
    bool isDone = false;
    try {
        isDone = Continue(part, scene, budget);
        m_context.builder.Reserve();
    } catch (...) {
        // Other parts may use what has been copied, so that its data has to arrive
        m_uploader->Flush();
        throw;
    }
    m_uploader->Flush();
    return isDone;
}

std::shared_ptr<SceneUpload> SceneStreams::NextUpload() const {
    for (; !m_uploads.empty(); m_uploads.pop_front())
        if (std::shared_ptr<SceneUpload> upload = m_uploads.front().lock(); upload && !upload->IsReady())
            return upload;
    return nullptr;
}

// The frame is that of another scene, so that SetScene throws an Error of the upload.
void SceneStreams::ContinueUpload(SceneUpload& upload, SceneObjects& scene, uint64_t& budget) {
    try {
        scene.blases.MarkUnbuilt();
        upload.m_impl->Continue(budget, false);
        m_context.builder.Reserve();
    } catch (...) {
        upload.m_error = std::current_exception();
    }
    m_uploader->Flush();
    if (!upload.m_error) return;
    // Its BLASes must not stay in the builder, which would build them
    End(*upload.m_impl);
    upload.m_impl.reset();
}

void SceneStreams::Continue(SceneObjects& scene) {
    m_ended.remove_if([](const TextureUpload& textures) { return !textures.IsBusy(); });
    uint64_t budget = m_context.desc.streamBudget;
    while (const std::shared_ptr<SceneUpload> upload = NextUpload()) {
        if (budget == 0 || m_uploader->WouldBlock()) return;
        ContinueUpload(*upload, scene, budget);
        if (!upload->IsReady()) return;
    }
    while (!m_parts.empty() && budget > 0 && !m_uploader->WouldBlock()) {
        Part& part = m_parts.front();
        try {
            if (!ContinueStream(part, scene, budget)) return;
        } catch (...) {
            const std::shared_ptr<AddedPart> added = part.added;
            End(m_parts.begin());
            scene.Remove(*added);
            *added = {};
            throw;
        }
        m_endedBytes += part.Bytes();
        End(m_parts.begin());
    }
}

}  // namespace raygraph

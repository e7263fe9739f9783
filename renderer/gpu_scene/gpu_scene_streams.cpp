// Parts and scenes on their way to the device, at once or over frames.
#include <algorithm>
#include <exception>
#include <utility>

#include "base/text.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/gpu_scene/material_records.h"
#include "renderer/scene/variants.h"

namespace raygraph {
namespace {

// An instance counts as much of a frame's budget as so many bytes that are copied.
constexpr uint64_t kInstanceCost = 256;

void Charge(uint64_t& budget, uint64_t cost) {
    budget -= std::min(cost, budget);
}

[[noreturn]] void Refuse(const char* call, const std::string& why) {
    throw MakeError(ErrorKind::Usage, "GpuScene: {}: {}", call, why);
}

// What only a scene can have.
void RequirePart(const char* call, const scene::SceneData& part) {
    for (size_t i = 0; i < part.instances.size(); ++i)
        if (part.instances[i].isDeformed)
            Refuse(call, Text("instances[{}] is deformed; only SetScene takes those", i));
    for (size_t i = 0; i < part.lights.size(); ++i)
        if (part.lights[i].profile != scene::kNone)
            Refuse(call, Text("lights[{}] has a profile; only SetScene takes those", i));
}

}  // namespace

PartUpload GpuScene::Impl::BeginPart(const char* call, PreparedScene&& part, rhi::Uploader& with) {
    scene::SceneData& data = part.m_content->data;
    RequirePart(call, data);
    CheckLimits(device, *part.m_content);
    PartUpload upload{.content = std::move(part.m_content),
                      .added = std::make_shared<AddedPart>(),
                      .uploader = &with,
                      .textures = {},
                      .isVisible = scene::VisibleNodes(data)};
    for (PackedMesh& mesh : upload.content->meshes) DropVariants(mesh);
    if (!data.textures.empty()) {
        uint64_t used = materials->Textures().Bytes();
        for (const PartUpload& before : streams)
            if (before.textures) used += before.textures->BytesToCome();
        const uint64_t budget = statistics.textureBudget - std::min(used, statistics.textureBudget);
        upload.textures.emplace(device, with, data, TextureSettings(budget));
        if (const std::string& warning = upload.textures->Reduction(); !warning.empty())
            device.Log().Send(LogLevel::Warning, log_category::kScene, warning);
        upload.bytes += upload.textures->Bytes();
    }
    for (const PackedMesh& mesh : upload.content->meshes) upload.bytes += mesh.Bytes();
    upload.added->owner = ++lastOwner;
    if (upload.content->hasOwnLight) environment.Sources().parts.insert(upload.added->owner);
    upload.added->textures.assign(data.textures.size(), scene::kNone);
    upload.added->materials.assign(data.materials.size(), scene::kNone);
    upload.added->meshes.assign(data.meshes.size(), scene::kNone);
    upload.added->instances.assign(data.instances.size(), scene::kNone);
    upload.added->lights.assign(data.lights.size(), scene::kNone);
    return upload;
}

bool GpuScene::Impl::BringTexture(PartUpload& part, uint32_t texture, uint64_t& budget) {
    uint32_t& number = part.added->textures[texture];
    if (number != scene::kNone) return true;
    if (!part.textures->Make(texture, budget, !part.isStreamed)) return false;
    const SceneTexture made = part.textures->Get(texture);
    owners.textures.Reserve(materials->Textures().Size() + size_t{1});
    number = materials->AddTextures({&made, 1}).front();
    owners.textures.Set(number, part.added->owner);
    return true;
}

bool GpuScene::Impl::BringMaterial(PartUpload& part, uint32_t material, uint64_t& budget) {
    uint32_t& number = part.added->materials[material];
    if (number != scene::kNone) return true;
    const scene::Material& values = part.content->data.materials[material];
    for (const uint32_t texture : TexturesOf(values))
        if (!BringTexture(part, texture, budget)) return false;
    owners.materials.Reserve(materials->Size() + 1);
    number = AddMaterial(values, part.added->textures);
    owners.materials.Set(number, part.added->owner);
    return true;
}

bool GpuScene::Impl::BringMesh(PartUpload& part, uint32_t mesh, uint64_t& budget) {
    uint32_t& number = part.added->meshes[mesh];
    if (number != scene::kNone) return true;
    if (!part.meshUpload) {
        PackedMesh& packed = part.content->meshes[mesh];
        for (const PackedGroup& group : packed.groups)
            for (const GroupPart& groupPart : group.parts)
                if (!BringMaterial(part, groupPart.material, budget)) return false;
        RenumberMaterials(packed, part.added->materials);
        part.meshUpload.emplace(std::exchange(packed, {}));
    }
    if (part.isStreamed && part.uploader->WouldWait()) return false;
    // Its first groups are built in this frame, too: all at once would hold a frame for long
    hasUnbuiltBlases = true;
    if (!part.meshUpload->Continue(device, *part.uploader, builder, disposer, budget)) return false;
    part.meshBytes += part.meshUpload->CopiedBytes();
    owners.meshes.Reserve(geometry->meshes.size() + 1);
    number = AddMesh(part.meshUpload->Take());
    owners.meshes.Set(number, part.added->owner);
    part.meshUpload.reset();
    return true;
}

bool GpuScene::Impl::Continue(PartUpload& part, uint64_t& budget) {
    const scene::SceneData& data = part.content->data;
    AddedPart& added = *part.added;
    for (; part.light < data.lights.size(); ++part.light) {
        const scene::Light& light = data.lights[part.light];
        owners.lights.Reserve(lights->PunctualCount() + size_t{1});
        const uint32_t number =
            AddLight(light, scene::IsVisible(part.isVisible, light.node), LightPlace::OfNode);
        owners.lights.Set(added.lights[part.light] = number, added.owner);
    }
    for (; part.instance < data.instances.size(); ++part.instance) {
        const scene::Instance& instance = data.instances[part.instance];
        if (budget == 0 || !BringMesh(part, instance.mesh, budget)) return false;
        owners.instances.Reserve(instances->Count() + size_t{1});
        const uint32_t number =
            AddInstance(added.meshes[instance.mesh], {instance.objectToWorld, instance.translationRest},
                        scene::IsVisible(part.isVisible, instance));
        owners.instances.Set(added.instances[part.instance] = number, added.owner);
        Charge(budget, kInstanceCost);
    }
    for (; part.mesh < added.meshes.size(); ++part.mesh)
        if (!BringMesh(part, part.mesh, budget)) return false;
    for (; part.material < added.materials.size(); ++part.material)
        if (!BringMaterial(part, part.material, budget)) return false;
    for (; part.texture < added.textures.size(); ++part.texture)
        if (!BringTexture(part, part.texture, budget)) return false;
    added.isComplete = true;
    return true;
}

void GpuScene::Impl::EndStream(std::list<PartUpload>::iterator part) {
    if (part->textures && part->textures->IsBusy()) endedTextures.push_back(std::move(*part->textures));
    part->textures.reset();
    disposer.Dispose(std::move(part->content));
    streams.erase(part);
    if (streams.empty()) streamedBytes = 0;
}

bool GpuScene::Impl::ContinueStream(PartUpload& part, uint64_t& budget) {
    bool isDone = false;
    try {
        isDone = Continue(part, budget);
        builder.Reserve();
    } catch (...) {
        // Others may use what is there: its data has to arrive
        streamUploader->Flush();
        throw;
    }
    streamUploader->Flush();
    return isDone;
}

std::shared_ptr<SceneUpload> GpuScene::Impl::NextUpload() {
    for (; !uploads.empty(); uploads.pop_front())
        if (std::shared_ptr<SceneUpload> upload = uploads.front().lock(); upload && !upload->IsReady())
            return upload;
    return nullptr;
}

// The frame is that of another scene: an Error is for SetScene.
void GpuScene::Impl::ContinueUpload(SceneUpload::Content& content, uint64_t& budget) {
    try {
        hasUnbuiltBlases = true;
        content.isDone = content.resources->Continue(budget, false);
        builder.Reserve();
    } catch (...) {
        content.error = std::current_exception();
        content.isDone = true;
    }
    streamUploader->Flush();
    if (!content.error) return;
    // The builder would build them
    endedTextures.push_back(content.resources->TakeTextures());
    content.resources.reset();
}

void GpuScene::Impl::ContinueStreams() {
    endedTextures.remove_if([](const TextureUpload& textures) { return !textures.IsBusy(); });
    uint64_t budget = desc.streamBudget;
    while (const std::shared_ptr<SceneUpload> upload = NextUpload()) {
        if (budget == 0 || streamUploader->WouldWait()) return;
        ContinueUpload(*upload->m_content, budget);
        if (!upload->IsReady()) return;
    }
    while (!streams.empty() && budget > 0 && !streamUploader->WouldWait()) {
        PartUpload& part = streams.front();
        try {
            if (!ContinueStream(part, budget)) return;
        } catch (...) {
            const std::shared_ptr<AddedPart> added = part.added;
            EndStream(streams.begin());
            Remove(*added);
            *added = {};
            throw;
        }
        streamedBytes += part.bytes;
        EndStream(streams.begin());
    }
}

}  // namespace raygraph

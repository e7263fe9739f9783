// The calls by which objects of a GpuScene come and go: what they refuse, and what they undo.
#include <algorithm>
#include <utility>

#include "base/out_of_memory.h"
#include "base/text.h"
#include "renderer/gpu_scene/alpha_bounds.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/gpu_scene/host_objects.h"
#include "renderer/gpu_scene/material_records.h"
#include "renderer/scene/check.h"

namespace raygraph {
namespace {

[[noreturn]] void RefuseRemoval(const char* what, uint32_t index, uint32_t count, const char* users) {
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

VkDeviceAddress AddressOf(const HostStream& stream) {
    return stream ? stream.buffer->Address() + stream.offset : 0;
}

}  // namespace

AddedPart GpuScene::Add(PreparedScene&& part) {
    m_impl->RequireNoFrame("Add");
    return WithMemoryErrors("Add", [&] { return m_impl->Add(std::move(part)); });
}

AddedPart GpuScene::Add(scene::SceneData&& part) {
    m_impl->RequireNoFrame("Add");
    return Add(PreparedScene(std::move(part), m_impl->Preparing(), "Add"));
}

AddedPart GpuScene::Impl::Add(PreparedScene&& part) {
    PartUpload upload = BeginPart("Add", std::move(part), uploader);
    try {
        uint64_t budget = UINT64_MAX;
        uploader.FlushAfter([&] { Continue(upload, budget); });
        builder.Reserve();
    } catch (...) {
        Remove(*upload.added);
        throw;
    }
    return std::move(*upload.added);
}

std::shared_ptr<const AddedPart> GpuScene::Stream(PreparedScene&& part) {
    m_impl->RequireNoFrame("Stream");
    return WithMemoryErrors("Stream", [&] { return m_impl->Stream(std::move(part)); });
}

std::shared_ptr<const AddedPart> GpuScene::Impl::Stream(PreparedScene&& part) {
    streams.push_back(BeginPart("Stream", std::move(part), StreamUploader()));
    streams.back().isStreamed = true;
    return streams.back().added;
}

rhi::Uploader& GpuScene::Impl::StreamUploader() {
    // Of four pieces, at most three are in flight while one is filled: in each frame one
    constexpr uint32_t kPieces = 4;
    if (!streamUploader)
        streamUploader.emplace(device, rhi::UploaderDesc{.name = "stream",
                                                         .stagingBytes = kPieces * desc.streamBudget,
                                                         .chunkCount = kPieces,
                                                         .allocatesAhead = true});
    return *streamUploader;
}

StreamProgress GpuScene::Streaming() const {
    StreamProgress progress;
    for (const PartUpload& part : m_impl->streams) {
        progress.bytes += part.CopiedBytes();
        progress.of += part.bytes;
    }
    // A part without bytes streams, too
    if (!m_impl->streams.empty()) progress.of += 1;
    progress.bytes += m_impl->streamedBytes;
    progress.of += m_impl->streamedBytes;
    return progress;
}

void GpuScene::Remove(const AddedPart& part) {
    m_impl->RequireNoFrame("Remove");
    const auto stream = std::ranges::find_if(
        m_impl->streams, [&](const PartUpload& upload) { return upload.added->owner == part.owner; });
    const AddedPart removed = part;  // it may be that of the stream
    if (stream != m_impl->streams.end()) m_impl->EndStream(stream);
    WithMemoryErrors("Remove", [&] { m_impl->Remove(removed); });
}

uint32_t GpuScene::AddInstance(uint32_t mesh, const scene::PlacedTransform& objectToWorld, bool isVisible) {
    m_impl->RequireNoFrame("AddInstance");
    m_impl->RequireMesh(mesh);
    if (!m_impl->IsShowable(mesh))
        throw MakeError(ErrorKind::Usage, "GpuScene: AddInstance: mesh {} is there as deformed copies alone",
                        mesh);
    const scene::PlacedTransform shown =
        scene::CheckedPlacement(objectToWorld, m_impl->instances->BoundsOf(mesh), "GpuScene: AddInstance");
    return WithMemoryErrors("AddInstance", [&] {
        const uint32_t number = m_impl->AddInstance(mesh, shown, isVisible);
        if (m_impl->owners.meshes.Of(mesh) == kOwnedByNone && m_impl->Emits(mesh))
            m_impl->environment.Sources().instances.insert(number);
        return number;
    });
}

uint32_t GpuScene::AddMesh(scene::Mesh&& mesh) {
    m_impl->RequireNoFrame("AddMesh");
    return WithMemoryErrors("AddMesh", [&] { return m_impl->AddMesh(std::move(mesh)); });
}

// As a part with the few materials that it has.
uint32_t GpuScene::Impl::AddMesh(scene::Mesh&& mesh) {
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
        packing.textureAlphas.push_back(materials->TextureAlpha(material));
        const gpu::MaterialRecord& record = materials->Records()[material];
        // What a texture may make shine is found, too; its texels are not there any more
        const bool hasTexture = record.emissiveTexture != gpu::kNoTexture;
        part.materials.emplace_back().emissiveFactor = hasTexture ? glm::vec3(1.0f) : record.emission;
    }
    part.meshes.push_back(std::move(mesh));
    scene::Check(part, "GpuScene: AddMesh");
    EmitterFinder finder(part);
    PackedMesh packed =
        PackMesh(part.meshes.front(), packing,
                 {.tree = traversal == Traversal::Own ? WideUse::Tree : WideUse::None}, finder);
    RenumberMaterials(packed, used);
    std::optional<uint32_t> number;
    try {
        uploader.FlushAfter(
            [&] { number = AddMesh(UploadMesh(device, uploader, builder, disposer, std::move(packed))); });
    } catch (...) {
        if (number) ForgetMesh(*number);
        throw;
    }
    ReserveBuilds(*number);
    return *number;
}

uint32_t GpuScene::AddMesh(const HostMesh& mesh) {
    m_impl->RequireNoFrame("AddMesh");
    m_impl->RequireMaterial(mesh.material);
    RequireStreams(mesh);
    RequireBounds("AddMesh", mesh.bounds);
    return WithMemoryErrors("AddMesh", [&] { return m_impl->AddMesh(mesh); });
}

uint32_t GpuScene::Impl::AddMesh(const HostMesh& mesh) {
    UploadedMesh uploaded;
    GroupResources& group = uploaded.groups.emplace_back();
    group.parts.push_back(
        {.material = mesh.material,
         .lowestAlpha = (mesh.colors ? mesh.lowestAlpha : 1.0f) * materials->TextureAlpha(mesh.material)});
    group.kind = KindOf(group.parts, materials->Records());
    group.record.positions = AddressOf(mesh.positions);
    group.record.indices = AddressOf(mesh.indices);
    group.triangleCount = mesh.triangleCount;
    group.bounds = mesh.bounds;
    uploaded.records.push_back({.normals = AddressOf(mesh.normals),
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
        group.blas = builder.Add(blas);
    }
    const uint32_t number = AddMesh(std::move(uploaded));
    ReserveBuilds(number);
    return number;
}

void GpuScene::MarkChanged(uint32_t mesh, const scene::Bounds& bounds) {
    m_impl->RequireNoFrame("MarkChanged");
    m_impl->RequireMesh(mesh);
    if (!m_impl->IsOfHost(mesh))
        throw MakeError(ErrorKind::Usage, "GpuScene: MarkChanged: mesh {} is not one of the host's", mesh);
    RequireBounds("MarkChanged", bounds);
    WithMemoryErrors("MarkChanged", [&] { m_impl->MarkChanged(mesh, bounds); });
}

uint32_t GpuScene::AddMaterial(const scene::Material& material) {
    m_impl->RequireNoFrame("AddMaterial");
    scene::Check(material, "GpuScene: AddMaterial");
    const uint32_t textureCount = m_impl->materials->Textures().Size();
    for (const uint32_t texture : TexturesOf(material)) {
        RequireIndex("texture", texture, textureCount);
        m_impl->RequireTexture(texture);
    }
    return WithMemoryErrors("AddMaterial", [&] {
        std::vector<uint32_t> numbers(textureCount);
        for (uint32_t i = 0; i < textureCount; ++i)
            numbers[i] = m_impl->materials->Textures().Exists(i) ? i : scene::kNone;
        return m_impl->AddMaterial(material, numbers);
    });
}

uint32_t GpuScene::AddTexture(const HostTexture& texture) {
    m_impl->RequireNoFrame("AddTexture");
    if (!texture.texture) throw Error(ErrorKind::Usage, "GpuScene: AddTexture: there is no texture");
    return WithMemoryErrors("AddTexture", [&] { return m_impl->AddTexture(texture); });
}

uint32_t GpuScene::AddLight(const scene::Light& light, bool isVisible) {
    m_impl->RequireNoFrame("AddLight");
    return WithMemoryErrors("AddLight", [&] {
        const uint32_t number = m_impl->AddLight(light, isVisible, LightPlace::OfHost);
        m_impl->environment.Sources().lights.insert(number);
        return number;
    });
}

void GpuScene::RemoveInstance(uint32_t instance) {
    m_impl->RequireNoFrame("RemoveInstance");
    m_impl->RequireInstance(instance);
    if (m_impl->IsDeformed(instance))
        throw MakeError(ErrorKind::Usage, "GpuScene: instance {} is deformed: it goes with the scene alone",
                        instance);
    WithMemoryErrors("RemoveInstance", [&] { m_impl->RemoveInstance(instance); });
}

void GpuScene::RemoveMesh(uint32_t mesh) {
    m_impl->RequireNoFrame("RemoveMesh");
    m_impl->RequireMesh(mesh);
    const MeshResources& removed = m_impl->geometry->meshes[mesh];
    if (removed.isDeformed)
        throw MakeError(ErrorKind::Usage, "GpuScene: mesh {} is deformed: it goes with the scene alone",
                        mesh);
    if (removed.instanceCount > 0) RefuseRemoval("mesh", mesh, removed.instanceCount, "instances");
    m_impl->RequireArrived("mesh", mesh, m_impl->owners.meshes);
    m_impl->ForgetMesh(mesh);
    ++m_impl->revisions.geometry;
}

void GpuScene::RemoveMaterial(uint32_t material) {
    m_impl->RequireNoFrame("RemoveMaterial");
    m_impl->RequireMaterial(material);
    if (const uint32_t count = m_impl->materials->PartCount(material); count > 0)
        RefuseRemoval("material", material, count, "primitives");
    m_impl->RequireArrived("material", material, m_impl->owners.materials);
    m_impl->RemoveMaterial(material);
}

void GpuScene::RemoveTexture(uint32_t texture) {
    m_impl->RequireNoFrame("RemoveTexture");
    m_impl->RequireTexture(texture);
    if (const uint32_t count = m_impl->materials->MaterialCount(texture); count > 0)
        RefuseRemoval("texture", texture, count, "materials");
    m_impl->RequireArrived("texture", texture, m_impl->owners.textures);
    WithMemoryErrors("RemoveTexture", [&] { m_impl->RemoveTexture(texture); });
}

void GpuScene::RemoveLight(uint32_t light) {
    m_impl->RequireNoFrame("RemoveLight");
    m_impl->RequireLight(light);
    WithMemoryErrors("RemoveLight", [&] { m_impl->RemoveLight(light); });
}

}  // namespace raygraph

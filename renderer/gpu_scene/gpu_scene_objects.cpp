// The calls that add objects to a GpuScene and remove them: their checks, and their rollback on an Error.
#include <algorithm>
#include <utility>

#include "base/out_of_memory.h"
#include "base/text.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/gpu_scene/host_objects.h"
#include "renderer/gpu_scene/materials/material_records.h"
#include "renderer/scene/model/check.h"

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

}  // namespace

AddedPart GpuScene::Add(PreparedScene&& part) {
    m_impl->RequireNoFrame("Add");
    return WithMemoryErrors("Add", [&] { return m_impl->streams.Add(std::move(part), *m_impl->scene); });
}

AddedPart GpuScene::Add(scene::SceneData&& part) {
    m_impl->RequireNoFrame("Add");
    return Add(PreparedScene(std::move(part), m_impl->Preparing(), "Add"));
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
    if (removed.instanceCount > 0) RefuseRemoval("mesh", mesh, removed.instanceCount, "instances");
    m_impl->streams.RequireComplete("mesh", mesh, m_impl->scene->owners.meshes);
    m_impl->scene->ForgetMesh(mesh);
    ++m_impl->context.revisions.geometry;
}

void GpuScene::RemoveMaterial(uint32_t material) {
    m_impl->RequireNoFrame("RemoveMaterial");
    m_impl->scene->RequireMaterial(material);
    if (const uint32_t count = m_impl->scene->materials->PartCount(material); count > 0)
        RefuseRemoval("material", material, count, "primitives");
    m_impl->streams.RequireComplete("material", material, m_impl->scene->owners.materials);
    m_impl->scene->RemoveMaterial(material);
}

void GpuScene::RemoveTexture(uint32_t texture) {
    m_impl->RequireNoFrame("RemoveTexture");
    m_impl->scene->RequireTexture(texture);
    if (const uint32_t count = m_impl->scene->materials->MaterialCount(texture); count > 0)
        RefuseRemoval("texture", texture, count, "materials");
    m_impl->streams.RequireComplete("texture", texture, m_impl->scene->owners.textures);
    WithMemoryErrors("RemoveTexture", [&] { m_impl->scene->RemoveTexture(texture); });
}

void GpuScene::RemoveLight(uint32_t light) {
    m_impl->RequireNoFrame("RemoveLight");
    m_impl->scene->RequireLight(light);
    WithMemoryErrors("RemoveLight", [&] { m_impl->scene->RemoveLight(light); });
}

}  // namespace raygraph

// Objects of a GpuScene that come and go. Each is added by a function that leaves everything as it was where
// it fails. The structures of added meshes still have to be reserved.
#include <algorithm>
#include <utility>

#include "base/text.h"
#include "renderer/gpu_scene/gpu_scene_impl.h"
#include "renderer/gpu_scene/host_objects.h"

namespace raygraph {

void GpuScene::Impl::RequireInstance(uint32_t instance) const {
    RequireIndex("instance", instance, instances->Count());
    if (!instances->Exists(instance))
        throw MakeError(ErrorKind::Usage, "GpuScene: instance {} has been removed", instance);
}

void GpuScene::Impl::RequireMesh(uint32_t mesh) const {
    RequireIndex("mesh", mesh, geometry->meshes.size());
    if (!geometry->HasMesh(mesh) || geometry->meshes[mesh].isCopy)
        throw MakeError(ErrorKind::Usage, "GpuScene: mesh {} has been removed", mesh);
}

void GpuScene::Impl::RequireMaterial(uint32_t material) const {
    RequireIndex("material", material, materials->Size());
    if (!materials->Exists(material))
        throw MakeError(ErrorKind::Usage, "GpuScene: material {} has been removed", material);
}

void GpuScene::Impl::RequireTexture(uint32_t texture) const {
    RequireIndex("texture", texture, materials->Textures().Size());
    if (!materials->Textures().Exists(texture))
        throw MakeError(ErrorKind::Usage, "GpuScene: texture {} has been removed", texture);
}

void GpuScene::Impl::RequireLight(uint32_t light) const {
    RequireIndex("light", light, lights->PunctualCount());
    if (!lights->HasPunctual(light))
        throw MakeError(ErrorKind::Usage, "GpuScene: light {} has been removed", light);
}

bool GpuScene::Impl::IsDeformed(uint32_t instance) const {
    return geometry->meshes[instances->MeshOf(instance)].isDeformed && deform && deform->IsDeformed(instance);
}

bool GpuScene::Impl::IsShowable(uint32_t mesh) const {
    return std::ranges::all_of(geometry->GroupsOf(geometry->meshes[mesh]),
                               [](const GroupResources& group) { return group.blas || group.hostBlas != 0; });
}

bool GpuScene::Impl::Emits(uint32_t mesh) const {
    for (const GroupResources& group : geometry->GroupsOf(geometry->meshes[mesh]))
        for (const GroupPart& part : group.parts)
            if (materials->Records()[part.material].emission != glm::vec3(0.0f)) return true;
    return false;
}

// --- Adding one thing.

uint32_t GpuScene::Impl::AddMaterial(const scene::Material& material, std::span<const uint32_t> textures) {
    const uint32_t number = materials->Add({&material, 1}, textures).front();
    try {
        lights->AddMaterial(number, material.EmittedRadiance());
    } catch (...) {
        materials->Remove(number);
        throw;
    }
    ++revisions.materials;
    return number;
}

void GpuScene::Impl::ReserveBuilds(uint32_t mesh) {
    try {
        builder.Reserve();
    } catch (...) {
        ForgetMesh(mesh);
        throw;
    }
}

uint32_t GpuScene::Impl::AddMesh(UploadedMesh&& uploaded) {
    const uint32_t number = geometry->AddMesh(std::move(uploaded), *materials);
    const MeshResources& mesh = geometry->meshes[number];
    try {
        instances->AddMesh(number);
        for (uint32_t i = mesh.firstGroup; i < mesh.firstGroup + mesh.groupCount; ++i) {
            GroupResources& group = geometry->groups[i];
            lights->AddGroup(i, std::move(group.emitters), group.emitterVariants, false);
            areDrawNumbersDue |= !draws.Add(group);
        }
    } catch (...) {
        ForgetMesh(number);
        throw;
    }
    hasUnbuiltBlases = areDrawsDue = true;
    ++revisions.geometry;
    return number;
}

uint32_t GpuScene::Impl::AddInstance(uint32_t mesh, const scene::PlacedTransform& objectToWorld,
                                     bool isVisible) {
    std::vector<uint32_t>* const placing = IsOfHost(mesh) ? &hostPlacements[mesh] : nullptr;
    if (placing) ReserveMore(*placing, 1);
    const bool isFirst = instances->Reach().IsEmpty();
    const uint32_t number = instances->Add(mesh, objectToWorld, isVisible);
    try {
        const MeshResources& placed = geometry->meshes[mesh];
        const uint32_t firstPlacement = instances->FirstPlacement(number);
        for (uint32_t i = 0; i < placed.groupCount; ++i)
            lights->AddPlacement(firstPlacement + i, number, placed.firstGroup + i,
                                 instances->DeviceTransform(number), isVisible);
    } catch (...) {
        lights->RemovePlacements(number);
        instances->Remove(number);
        throw;
    }
    if (placing) placing->push_back(number);
    if (isFirst) RestartOrigin();
    ++geometry->meshes[mesh].instanceCount;
    areDrawsDue = true;
    ++revisions.geometry;
    return number;
}

uint32_t GpuScene::Impl::AddLight(const scene::Light& light, bool isVisible, LightPlace place) {
    const uint32_t number = lights->AddPunctual(light, isVisible, place);
    ++revisions.lights;
    return number;
}

// --- Removing one thing that nothing uses.

void GpuScene::Impl::RemoveInstance(uint32_t instance) {
    const uint32_t mesh = instances->MeshOf(instance);
    lights->ReserveRemoval(instance);
    instances->Remove(instance);
    lights->RemovePlacements(instance);
    if (const auto placing = hostPlacements.find(mesh); placing != hostPlacements.end())
        std::erase(placing->second, instance);
    owners.instances.Forget(instance);
    environment.Sources().instances.erase(instance);
    --geometry->meshes[mesh].instanceCount;
    areDrawsDue = true;
    ++revisions.geometry;
}

void GpuScene::Impl::ForgetMesh(uint32_t number) noexcept {
    const MeshResources& mesh = geometry->meshes[number];
    for (uint32_t i = mesh.firstGroup; i < mesh.firstGroup + mesh.groupCount; ++i) {
        lights->RemoveGroup(i);
        draws.Remove(geometry->groups[i]);
    }
    std::erase(changedHostMeshes, number);
    hostPlacements.erase(number);
    owners.meshes.Forget(number);
    geometry->RemoveMesh(number, *materials);
    areDrawsDue = true;
}

void GpuScene::Impl::RemoveLight(uint32_t light) {
    lights->RemovePunctual(light);
    owners.lights.Forget(light);
    environment.Sources().lights.erase(light);
    ++revisions.lights;
}

void GpuScene::Impl::RemoveMaterial(uint32_t material) {
    materials->Remove(material);
    owners.materials.Forget(material);
    ++revisions.materials;
}

void GpuScene::Impl::RemoveTexture(uint32_t texture) {
    materials->RemoveTexture(texture);
    owners.textures.Forget(texture);
}

bool GpuScene::Impl::IsMeshUsed(uint32_t mesh) const {
    return geometry->meshes[mesh].instanceCount > 0 || geometry->meshes[mesh].isDeformed;
}

// Of what it names, what is still its own, and as far as nothing else uses it.
void GpuScene::Impl::Remove(const AddedPart& part) {
    if (part.owner <= kOwnedByScene) return;
    environment.Sources().parts.erase(part.owner);
    for (const uint32_t light : part.lights)
        if (owners.lights.Of(light) == part.owner) RemoveLight(light);
    for (const uint32_t instance : part.instances)
        if (owners.instances.Of(instance) == part.owner) RemoveInstance(instance);
    for (const uint32_t mesh : part.meshes)
        if (owners.meshes.Of(mesh) == part.owner && !IsMeshUsed(mesh)) ForgetMesh(mesh);
    for (const uint32_t material : part.materials)
        if (owners.materials.Of(material) == part.owner && materials->PartCount(material) == 0)
            RemoveMaterial(material);
    for (const uint32_t texture : part.textures)
        if (owners.textures.Of(texture) == part.owner && materials->MaterialCount(texture) == 0)
            RemoveTexture(texture);
}

bool GpuScene::Impl::IsOnItsWay(uint32_t owner) const {
    return owner > kOwnedByScene &&
           std::ranges::any_of(streams, [&](const PartUpload& part) { return part.added->owner == owner; });
}

bool GpuScene::Impl::IsOfHost(uint32_t mesh) const {
    const MeshResources& found = geometry->meshes[mesh];
    return found.groupCount == 1 && !found.isDeformed && !geometry->groups[found.firstGroup].streams;
}

uint32_t GpuScene::Impl::AddTexture(const HostTexture& texture) {
    const auto image = std::make_shared<SceneImage>(
        SceneImage{.hostTexture = texture.texture, .lowestAlpha = texture.lowestAlpha});
    const SceneTexture added{image, texture.sampler};
    return materials->AddTextures({&added, 1}).front();
}

void GpuScene::Impl::MarkChanged(uint32_t mesh, const scene::Bounds& bounds) {
    GroupResources& group = geometry->groups[geometry->meshes[mesh].firstGroup];
    const std::vector<uint32_t>& placing = hostPlacements[mesh];
    const bool isRebuilt = group.blas && group.blas->Desc().kind == rhi::BlasKind::Deforming;
    if (isRebuilt) {
        if (std::ranges::find(changedHostMeshes, mesh) == changedHostMeshes.end() && group.blas->IsBuilt())
            changedHostMeshes.push_back(mesh);
    } else if (group.blas) {
        std::shared_ptr<rhi::Blas> blas = builder.Add(group.blas->Desc());
        builder.Reserve();
        group.blas = std::move(blas);
        hasUnbuiltBlases = areAddressesDue = true;
    } else {
        instances->MarkRefitted();
    }
    group.bounds = bounds;
    draws.SetBounds(group);
    instances->MarkDeformed(mesh, placing);
    ++revisions.geometry;
}

}  // namespace raygraph

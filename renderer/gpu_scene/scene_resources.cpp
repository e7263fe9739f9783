#include "renderer/gpu_scene/scene_resources.h"

#include <algorithm>
#include <span>
#include <utility>

#include "renderer/gpu_scene/deform_resources.h"
#include "renderer/gpu_scene/group_kinds.h"
#include "renderer/gpu_scene/material_records.h"
#include "renderer/gpu_scene/mesh_upload.h"
#include "renderer/gpu_scene/scene_content.h"
#include "renderer/gpu_scene/texture_upload.h"

namespace raygraph {

scene::Bounds BoundsOf(const SceneResources& resources, const MeshResources& mesh) {
    scene::Bounds bounds;
    for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groupCount; ++group)
        bounds.Extend(resources.groups[group].bounds);
    return bounds;
}

uint64_t TriangleCount(const SceneResources& resources) {
    uint64_t count = 0;
    for (const MeshResources& mesh : resources.meshes) count += mesh.isCopy ? 0 : mesh.triangleCount;
    return count;
}
uint64_t TriangleCount(const SceneResources& resources, std::span<const scene::Instance> instances) {
    uint64_t count = 0;
    for (const scene::Instance& instance : instances) count += resources.meshes[instance.mesh].triangleCount;
    return count;
}

SceneResources::SceneResources() = default;
SceneResources::~SceneResources() = default;

// Each part of a mesh counts once for each of its materials.
void SceneResources::CountParts(const MeshResources& mesh, int uses) noexcept {
    for (uint32_t i = mesh.firstGroup; i < mesh.firstGroup + mesh.groupCount; ++i)
        for (const GroupPart& part : groups[i].parts) {
            if (part.variants.empty()) materialUses[part.material].partCount += uses;
            for (const PartVariant& other : part.variants) materialUses[other.material].partCount += uses;
        }
}

uint32_t SceneResources::AddMesh(UploadedMesh&& mesh) {
    const auto groupCount = static_cast<uint32_t>(mesh.groups.size());
    const auto geometryCount = static_cast<uint32_t>(mesh.records.size());
    const uint32_t number = m_meshSlots.Allocate(1);
    uint32_t firstGroup = scene::kNone, firstGeometry = scene::kNone;
    try {
        firstGroup = m_groupSlots.Allocate(groupCount);
        firstGeometry = m_geometrySlots.Allocate(geometryCount);
        meshes.resize(std::max<size_t>(meshes.size(), m_meshSlots.End()), {.exists = false});
        groups.resize(std::max<size_t>(groups.size(), m_groupSlots.End()));
        geometries.Grow(m_geometrySlots.End());
    } catch (...) {
        m_meshSlots.Free(number, 1);
        if (firstGroup != scene::kNone) m_groupSlots.Free(firstGroup, groupCount);
        if (firstGeometry != scene::kNone) m_geometrySlots.Free(firstGeometry, geometryCount);
        throw;
    }
    MeshResources& added = meshes[number] = {.firstGroup = firstGroup, .groupCount = groupCount};
    for (uint32_t i = 0; i < groupCount; ++i) {
        GroupResources& group = groups[firstGroup + i] = std::move(mesh.groups[i]);
        group.record.firstGeometry += firstGeometry;
        added.triangleCount += group.triangleCount;
    }
    geometries.Write(firstGeometry, mesh.records);
    for (const gpu::GeometryRecord& record : mesh.records) {
        hasVertexColors |= record.colors != 0;
        tangentSets |= record.tangentSet;
    }
    geometryBytes += mesh.bytes;
    CountParts(added, 1);
    return number;
}

void SceneResources::RemoveMesh(uint32_t mesh) noexcept {
    MeshResources& removed = meshes[mesh];
    CountParts(removed, -1);
    for (uint32_t i = removed.firstGroup; i < removed.firstGroup + removed.groupCount; ++i) {
        GroupResources& group = groups[i];
        const auto parts = static_cast<uint32_t>(group.parts.size());
        m_geometrySlots.Free(group.record.firstGeometry, parts);
        if (group.streams) geometryBytes -= group.streams.Size();
        group = {};
    }
    m_groupSlots.Free(removed.firstGroup, removed.groupCount);
    removed = {.exists = false};
    m_meshSlots.Free(mesh, 1);
}

std::vector<uint32_t> SceneResources::AddMaterials(std::span<const scene::Material> added,
                                                   std::span<const uint32_t> textureNumbers) {
    std::vector<uint32_t> slots, numbers;
    for (const uint32_t texture : textureNumbers)
        slots.push_back(texture == scene::kNone ? 0 : textures->Slot(texture));
    const std::vector<gpu::MaterialRecord> records = MaterialRecords(added, slots);
    std::vector<MaterialUse> uses;
    for (const scene::Material& material : added) {
        MaterialUse& use = uses.emplace_back();
        for (const uint32_t texture : TexturesOf(material)) use.textures.push_back(textureNumbers[texture]);
        if (!material.baseColorTexture.IsPresent()) continue;
        const auto baseColor = static_cast<size_t>(material.baseColorTexture.texture);
        use.textureAlpha = textures->Image(textureNumbers[baseColor]).lowestAlpha;
    }
    numbers.reserve(added.size());
    try {
        for (size_t i = 0; i < added.size(); ++i) numbers.push_back(m_materialSlots.Allocate(1));
        materials.Grow(m_materialSlots.End());
        materialUses.resize(materials.Size(), {.exists = false});
    } catch (...) {
        for (const uint32_t number : numbers) m_materialSlots.Free(number, 1);
        throw;
    }
    for (size_t i = 0; i < added.size(); ++i) {
        for (const uint32_t texture : uses[i].textures) ++textureUses[texture];
        materials.Edit(numbers[i]) = records[i];
        materialUses[numbers[i]] = std::move(uses[i]);
    }
    return numbers;
}

void SceneResources::RemoveMaterial(uint32_t material) noexcept {
    for (const uint32_t texture : materialUses[material].textures) --textureUses[texture];
    materialUses[material] = {.exists = false};
    m_materialSlots.Free(material, 1);
}

std::vector<uint32_t> SceneResources::AddTextures(std::span<const SceneTexture> added) {
    textureUses.reserve(textures->Size() + added.size());
    std::vector<uint32_t> numbers = textures->Add(added);
    textureUses.resize(textures->Size());
    return numbers;
}

void SceneResources::RemoveTexture(uint32_t texture) {
    textures->Remove(texture);
}

void SceneResources::TakeSlots() {
    m_meshSlots.Allocate(static_cast<uint32_t>(meshes.size()) - m_meshSlots.End());
    m_groupSlots.Allocate(static_cast<uint32_t>(groups.size()) - m_groupSlots.End());
    m_geometrySlots.Allocate(static_cast<uint32_t>(geometries.Size()) - m_geometrySlots.End());
}

}  // namespace raygraph

#include "renderer/gpu_scene/geometry/scene_geometry.h"

#include <algorithm>
#include <span>
#include <utility>

#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/materials/scene_materials.h"

namespace raygraph {

SceneGeometry::SceneGeometry() = default;
SceneGeometry::SceneGeometry(rhi::Device& device) : records(device, "geometries", "UploadGeometries") {}
SceneGeometry::SceneGeometry(SceneGeometry&&) noexcept = default;
SceneGeometry::~SceneGeometry() = default;

uint32_t SceneGeometry::AddMesh(std::vector<GroupResources>&& mesh, SceneMaterials& materials) {
    const auto groupCount = static_cast<uint32_t>(mesh.size());
    uint32_t recordCount = 0;
    for (const GroupResources& group : mesh) recordCount += static_cast<uint32_t>(group.records.size());
    const uint32_t number = m_meshSlots.Allocate(1);
    uint32_t firstGroup = scene::kNone, firstRecord = scene::kNone;
    try {
        firstGroup = m_groupSlots.Allocate(groupCount);
        firstRecord = m_recordSlots.Allocate(recordCount);
        meshes.resize(std::max<size_t>(meshes.size(), m_meshSlots.End()), {.exists = false});
        groups.resize(std::max<size_t>(groups.size(), m_groupSlots.End()));
        records.Grow(m_recordSlots.End());
    } catch (...) {
        m_meshSlots.Free(number, 1);
        if (firstGroup != scene::kNone) m_groupSlots.Free(firstGroup, groupCount);
        if (firstRecord != scene::kNone) m_recordSlots.Free(firstRecord, recordCount);
        throw;
    }
    MeshResources& added = meshes[number] = {.firstGroup = firstGroup, .groupCount = groupCount};
    for (uint32_t i = 0; i < groupCount; ++i) {
        GroupResources& group = groups[firstGroup + i] = std::move(mesh[i]);
        group.record.firstGeometry = firstRecord;
        records.Write(firstRecord, group.records);
        firstRecord += static_cast<uint32_t>(group.records.size());
        for (const gpu::GeometryRecord& record : std::exchange(group.records, {})) {
            hasVertexColors |= record.colors != 0;
            tangentSets |= record.tangentSet;
        }
        added.triangleCount += group.triangleCount;
        if (group.streams) streamBytes += group.streams.Size();
    }
    materials.CountUsers(GroupsOf(added), 1);
    return number;
}

void SceneGeometry::RemoveMesh(uint32_t mesh, SceneMaterials& materials) noexcept {
    MeshResources& removed = meshes[mesh];
    materials.CountUsers(GroupsOf(removed), -1);
    for (GroupResources& group : GroupsOf(removed)) {
        const auto parts = static_cast<uint32_t>(group.parts.size());
        m_recordSlots.Free(group.record.firstGeometry, parts);
        if (group.streams) streamBytes -= group.streams.Size();
        group = {};
    }
    m_groupSlots.Free(removed.firstGroup, removed.groupCount);
    removed = {.exists = false};
    m_meshSlots.Free(mesh, 1);
}

void SceneGeometry::AllocateSlots() {
    m_meshSlots.Allocate(static_cast<uint32_t>(meshes.size()) - m_meshSlots.End());
    m_groupSlots.Allocate(static_cast<uint32_t>(groups.size()) - m_groupSlots.End());
    m_recordSlots.Allocate(static_cast<uint32_t>(records.Size()) - m_recordSlots.End());
}

}  // namespace raygraph

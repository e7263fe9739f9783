#include "renderer/gpu_scene/deform/deform_set.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "renderer/gpu_scene/device_array.h"
#include "renderer/scene/model/check.h"

namespace raygraph {
namespace {

// The push constants of shaders/scene/deform.comp.
struct DeformConstants {
    uint32_t taskCount;
    uint32_t groupCount;
};

uint32_t GroupsOf(const gpu::DeformRecord& record) {
    return (record.vertexCount + gpu::kDeformGroupSize - 1) / gpu::kDeformGroupSize;
}

}  // namespace

DeformSet::DeformSet(rhi::Device& device, SceneGeometry& geometry, InstanceSet& instances)
    : m_device(device), m_geometry(geometry), m_deform(*geometry.deform), m_instances(instances) {
    m_tasks.reserve(m_deform.records.size());  // frames must not allocate memory for it
}

bool DeformSet::SetJointMatrices(uint32_t skin, std::span<const glm::mat4x3> matrices) {
    for (const glm::mat4x3& matrix : matrices)
        if (!scene::IsFinite(matrix))
            throw MakeError(ErrorKind::Usage,
                            "GpuScene: SetJointMatrices: skin {} has numbers that are not "
                            "finite",
                            skin);
    return FollowJoints(skin, matrices);
}

bool DeformSet::FollowJoints(uint32_t skin, std::span<const glm::mat4x3> matrices) {
    SkinMatrices& range = m_deform.skins[skin];
    RG_CHECK_EQ(matrices.size(), range.count);
    bool isChanged = false;
    for (size_t i = 0; i < matrices.size(); ++i) {
        glm::mat4x3& old = m_deform.matrices[range.first + i];
        // The identity, not the joint's last matrix: the picture must not depend on what was shown before
        const glm::mat4x3 matrix = scene::IsFinite(matrices[i]) ? matrices[i] : glm::mat4x3(1.0f);
        if (matrix == old) continue;
        old = matrix;
        isChanged = true;
    }
    if (!isChanged) return false;
    range.isDue = true;
    bool isSeen = false;
    for (DeformedMesh& mesh : m_deform.meshes) {
        if (mesh.skin != skin) continue;
        mesh.poseDirty = true;
        isSeen |= IsVisible(mesh);
    }
    return isSeen;
}

bool DeformSet::IsDeformed(uint32_t instance) const {
    // Instances that were added later are never deformed
    return instance < m_deform.meshOf.size() && m_deform.meshOf[instance] != scene::kNone;
}

uint32_t DeformSet::WeightCount(uint32_t instance) const {
    return IsDeformed(instance) ? m_deform.meshes[m_deform.meshOf[instance]].weightCount : 0;
}

bool DeformSet::SetMorphWeights(uint32_t instance, std::span<const float> weights) {
    RG_CHECK_EQ(weights.size(), WeightCount(instance));
    if (weights.empty()) return false;
    if (!std::ranges::all_of(weights, [](float weight) { return std::isfinite(weight); }))
        throw MakeError(ErrorKind::Usage,
                        "GpuScene: SetMorphWeights: instance {} has numbers that are not finite", instance);
    DeformedMesh& mesh = m_deform.meshes[m_deform.meshOf[instance]];
    const auto old = m_deform.weights.begin() + mesh.firstWeight;
    if (std::equal(weights.begin(), weights.end(), old)) return false;
    std::ranges::copy(weights, old);
    mesh.weightsDirty = mesh.poseDirty = true;
    return IsVisible(mesh);
}

bool DeformSet::IsVisible(const DeformedMesh& mesh) const {
    return std::ranges::any_of(mesh.instances, [&](uint32_t i) { return m_instances.IsVisible(i); });
}

bool DeformSet::IsPoseDirty(const DeformedMesh& mesh) const {
    return mesh.poseDirty && (IsVisible(mesh) || mesh.deformPending);
}

bool DeformSet::HasWork() const {
    return std::ranges::any_of(m_deform.meshes, [&](const DeformedMesh& mesh) {
        return IsPoseDirty(mesh) || mesh.deformPending ||
               std::ranges::any_of(mesh.groups, &DeformedGroup::refitPending);
    });
}

void DeformSet::Follow(DeformedMesh& mesh, LightSet& lights, DrawTable& draws) {
    m_deform.Follow(mesh, m_geometry);
    m_instances.MarkDeformed(mesh.mesh, mesh.instances);
    for (DeformedGroup& deformed : mesh.groups) {
        const GroupResources& group = m_geometry.groups[deformed.group];
        lights.SetPose(deformed.group, deformed.pose);
        draws.SetBounds(group);
    }
    mesh.poseDirty = false;  // This is last: if memory runs out before, the next frame repeats all of it
}

void DeformSet::DeclareDeformation(Renderer& renderer, SceneIds& ids, LightSet& lights, DrawTable& draws) {
    for (DeformedMesh& mesh : m_deform.meshes)
        if (IsPoseDirty(mesh)) Follow(mesh, lights, draws);
    ids.deformedStreams = renderer.Import("deformedStreams", m_deform.streams, m_streamsState);
    m_tasks.clear();
    m_groupCount = 0;
    for (const DeformedMesh& mesh : m_deform.meshes) {
        if (!mesh.deformPending) continue;
        for (uint32_t i = 0; i < mesh.recordCount; ++i) {
            m_tasks.push_back({.record = mesh.firstRecord + i, .firstGroup = m_groupCount});
            m_groupCount += GroupsOf(m_deform.records[mesh.firstRecord + i]);
        }
    }
    if (m_tasks.empty()) return;
    m_taskIds = renderer.Import("deformTasks", m_deform.taskBuffer, m_tasksState);
    m_matrices = renderer.Import("jointMatrices", m_deform.matrixBuffer, m_matricesState);
    m_weights = renderer.Import("morphWeights", m_deform.weightBuffer, m_weightsState);
    DeclareUpload(renderer);
    DeclareDeform(renderer, ids);
}

void DeformSet::DeclareUpload(Renderer& renderer) {
    renderer.AddPass(
        "UploadPoses", PassKind::Transfer,
        [&](PassBuilder& pass) {
            m_taskIds = pass.CopiesTo(m_taskIds);
            m_matrices = pass.CopiesTo(m_matrices);
            m_weights = pass.CopiesTo(m_weights);
        },
        [this](CommandList& commands) {
            RecordUpload(commands);
            commands.OnSubmitted([this] {
                for (SkinMatrices& skin : m_deform.skins) skin.isDue = false;
                for (DeformedMesh& mesh : m_deform.meshes) mesh.weightsDirty = false;
            });
        });
}

void DeformSet::RecordUpload(CommandList& commands) {
    std::vector<TableCopy> copies{{std::as_bytes(std::span(std::as_const(m_tasks))), m_deform.taskBuffer, 0}};
    for (const SkinMatrices& skin : m_deform.skins)
        if (skin.isDue)
            copies.push_back(
                {std::as_bytes(std::span(std::as_const(m_deform.matrices)).subspan(skin.first, skin.count)),
                 m_deform.matrixBuffer, skin.first * sizeof(glm::mat4x3)});
    for (const DeformedMesh& mesh : m_deform.meshes)
        if (mesh.weightsDirty && mesh.weightCount > 0)
            copies.push_back({std::as_bytes(m_deform.WeightsOf(mesh)), m_deform.weightBuffer,
                              mesh.firstWeight * sizeof(float)});
    RecordCopies(commands, m_device, "pose staging", copies);
}

void DeformSet::DeclareDeform(Renderer& renderer, SceneIds& ids) {
    renderer.AddPass(
        "Deform", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("scene/deform.comp");
            pass.Reads("deformRecords",
                       renderer.Import("deformRecords", m_deform.recordBuffer, m_recordsState));
            pass.Reads("deformTasks", m_taskIds);
            pass.Reads("jointMatrices", m_matrices);
            pass.Reads("morphWeights", m_weights);
            ids.deformedStreams = pass.WritesByAddress(ids.deformedStreams);
            pass.Constants(DeformConstants{static_cast<uint32_t>(m_tasks.size()), m_groupCount});
        },
        [this](CommandList& commands) {
            const uint32_t rows = (m_groupCount + gpu::kDeformRowGroups - 1) / gpu::kDeformRowGroups;
            commands.Dispatch(std::min(m_groupCount, gpu::kDeformRowGroups), rows);
            commands.OnSubmitted([this] {
                for (DeformedMesh& mesh : m_deform.meshes) mesh.deformPending = false;
                ++m_deformCount;
            });
        });
}

std::vector<DeformedGroup*> DeformSet::UnbuiltGroups() {
    std::vector<DeformedGroup*> unbuilt;
    for (DeformedMesh& mesh : m_deform.meshes)
        for (DeformedGroup& group : mesh.groups)
            if (!m_geometry.groups[group.group].blas->IsBuilt()) unbuilt.push_back(&group);
    return unbuilt;
}

void DeformSet::MarkBuilt(std::span<DeformedGroup* const> groups) noexcept {
    for (DeformedGroup* group : groups) {
        group->refitPending = group->rebuildPending = false;
        group->quality.OnBuild();
    }
}

void DeformSet::DeclareRefits(Renderer& renderer, SceneIds& ids, rhi::BlasBuilder& builder) {
    std::vector<DeformedGroup*> due;
    for (DeformedMesh& mesh : m_deform.meshes)
        for (DeformedGroup& group : mesh.groups)
            if (group.refitPending && m_geometry.groups[group.group].blas->IsBuilt()) due.push_back(&group);
    if (due.empty()) return;
    m_instances.MarkRefitted();
    renderer.AddPass(
        "RefitBlas", PassKind::AccelerationStructure,
        [&](PassBuilder& pass) {
            pass.BuildsFrom(ids.deformedStreams);
            ids.blases = pass.Refits(ids.blases);
        },
        [this, due = std::move(due), &builder](CommandList& commands) {
            std::vector<rhi::BlasBuilder::RefitRequest> requests;
            for (const DeformedGroup* group : due)
                requests.push_back({.blas = m_geometry.groups[group->group].blas.get(),
                                    .desc = {},
                                    .rebuilds = group->rebuildPending});
            builder.RecordRefits(commands, requests);
            commands.OnSubmitted([due] {
                for (DeformedGroup* group : due) {
                    if (group->rebuildPending) group->quality.OnBuild();
                    group->refitPending = group->rebuildPending = false;
                }
            });
        });
}

}  // namespace raygraph

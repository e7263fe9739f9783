#include "renderer/gpu_scene/geometry/blas_set.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/geometry/mesh_packing.h"
#include "renderer/scene/model/mesh_data.h"
#include "rhi/command_list.h"

namespace raygraph {

void BlasSet::MarkVerticesDirty(uint32_t mesh) {
    GroupResources& group = m_geometry.groups[m_geometry.meshes[mesh].firstGroup];
    if (!group.blas) return m_instances.MarkRefitted();
    if (group.blas->Desc().kind == rhi::BlasKind::Deforming) {
        if (std::ranges::find(m_rebuilt, mesh) == m_rebuilt.end() && group.blas->IsBuilt())
            m_rebuilt.push_back(mesh);
        return;
    }
    std::shared_ptr<rhi::Blas> blas = m_builder.Add(group.blas->Desc());
    m_builder.Reserve();
    group.blas = std::move(blas);
    MarkReplaced();
}

void BlasSet::Declare(Renderer& renderer, SceneIds& ids, DeformSet* deform) {
    const bool hasCompactions = m_builder.Poll();
    // The addresses are known once the passes record, and the instances are written after that
    if (hasCompactions) m_instances.MarkStructuresChanged();
    if (m_unbuilt)
        renderer.AddPass(
            "BuildBlas", PassKind::AccelerationStructure,
            [&](PassBuilder& pass) {
                if (deform) pass.BuildsFrom(ids.deformedStreams);
                ids.blases = pass.Builds(ids.blases);
            },
            [this, deform](CommandList& commands) {
                std::vector<DeformedGroup*> deformed;
                if (deform) deformed = deform->UnbuiltGroups();
                m_structuresUsed = true;
                m_builder.RecordBuilds(commands);
                commands.OnSubmitted([this, deformed = std::move(deformed)] {
                    m_unbuilt = false;
                    DeformSet::MarkBuilt(deformed);
                });
            });
    if (deform) deform->DeclareRefits(renderer, ids, m_builder);
    if (!m_rebuilt.empty()) DeclareRebuilds(renderer, ids);
    if (hasCompactions)
        renderer.AddPass(
            "CompactBlas", PassKind::AccelerationStructure,
            [&](PassBuilder& pass) { ids.blases = pass.Builds(ids.blases); },
            [this](CommandList& commands) { m_builder.RecordCompaction(commands); });
}

void BlasSet::DeclareRebuilds(Renderer& renderer, SceneIds& ids) {
    m_instances.MarkRefitted();
    renderer.AddPass(
        "RebuildHostBlas", PassKind::AccelerationStructure,
        [&](PassBuilder& pass) { ids.blases = pass.Refits(ids.blases); },
        [this](CommandList& commands) {
            std::vector<rhi::BlasBuilder::RefitRequest> requests;
            for (const uint32_t mesh : m_rebuilt)
                requests.push_back({.blas = m_geometry.groups[m_geometry.meshes[mesh].firstGroup].blas.get(),
                                    .desc = {},
                                    .rebuilds = true});
            m_builder.RecordRefits(commands, requests);
            commands.OnSubmitted([this] { m_rebuilt.clear(); });
        });
}

namespace {

std::vector<uint32_t> OrderOf(std::span<const glm::vec3> corners) {
    std::vector<glm::vec3> centers(corners.size() / 3);
    for (size_t i = 0; i < centers.size(); ++i)
        centers[i] = (corners[3 * i] + corners[3 * i + 1] + corners[3 * i + 2]) / 3.0f;
    return SpatialOrder(centers);
}

double SurfaceArea(const scene::Bounds& bounds) {
    const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

// Adds the areas of the boxes of the balanced tree over these triangles, and returns its root.
scene::Bounds AddAreas(std::span<const uint32_t> order, std::span<const glm::vec3> corners, double& sum) {
    scene::Bounds bounds;
    if (order.size() == 1) {
        for (size_t i = 0; i < 3; ++i) bounds.Extend(corners[size_t{3} * order[0] + i]);
    } else {
        const size_t half = order.size() / 2;
        bounds = AddAreas(order.first(half), corners, sum);
        bounds.Extend(AddAreas(order.subspan(half), corners, sum));
    }
    sum += SurfaceArea(bounds);
    return bounds;
}

double Cost(std::span<const uint32_t> order, std::span<const glm::vec3> corners) {
    double sum = 0.0;
    AddAreas(order, corners, sum);
    return sum;
}

}  // namespace

float RefitQuality::Follow(std::span<const glm::vec3> corners) {
    m_currentOrder = OrderOf(corners);
    m_order.reserve(m_currentOrder.size());  // OnBuild must not allocate
    if (m_order.empty()) return 1.0f;
    const double rebuilt = Cost(m_currentOrder, corners);
    return rebuilt > 0.0 ? static_cast<float>(Cost(m_order, corners) / rebuilt) : 1.0f;
}

void RefitQuality::OnBuild() noexcept {
    m_order = m_currentOrder;
}

}  // namespace raygraph

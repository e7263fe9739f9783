#include "renderer/gpu_scene/geometry/blas_set.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "renderer/gpu_scene/deform/deform_set.h"
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

}  // namespace raygraph

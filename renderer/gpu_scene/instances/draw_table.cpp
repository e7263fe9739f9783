#include "renderer/gpu_scene/instances/draw_table.h"

#include <algorithm>
#include <span>
#include <utility>

#include "shaders/shared/draw_records.h"

namespace raygraph {

DrawKind KindOf(const GroupKind& group) {
    if (group.isOpaque) return group.isBackCulled ? DrawKind::Opaque : DrawKind::OpaqueTwoSided;
    return group.isBackCulled ? DrawKind::AlphaTested : DrawKind::AlphaTestedTwoSided;
}

DrawTable::DrawTable(rhi::Device& device, SceneGeometry& geometry, const InstanceSet& instances)
    : m_draws(device, "draws", "UploadDraws") {
    Number(geometry, 1);
    Count(geometry, instances);
}

void DrawTable::Upload(rhi::Uploader& uploader) {
    m_draws.Upload(uploader);
}

void DrawTable::Number(SceneGeometry& geometry, uint32_t roomFactor) {
    decltype(m_kinds) kinds;
    for (const GroupResources& group : geometry.groups)
        if (group.IsDrawn()) ++kinds[static_cast<size_t>(KindOf(group.kind))].room;
    uint32_t first = 0;
    for (Kind& kind : kinds) {
        kind.first = first;
        kind.room *= roomFactor;
        first += kind.room;
        kind.taken.Free(kind.taken.Allocate(kind.room), kind.room);  // so that Add allocates no memory
    }
    m_draws.Assign(std::vector<gpu::DrawRecord>(first));
    // Nothing fails from here on: the numbers always match the records
    m_kinds = std::move(kinds);
    for (GroupResources& group : geometry.groups) Add(group);
}

void DrawTable::Add(GroupResources& group) {
    group.record.draw = gpu::kNotDrawn;
    m_countsDirty = true;
    if (!group.IsDrawn()) return;
    Kind& kind = m_kinds[static_cast<size_t>(KindOf(group.kind))];
    if (kind.taken.TakenCount() < kind.room)
        group.record.draw = kind.first + kind.taken.Allocate(1);
    else
        m_numbersDirty = true;
}

void DrawTable::Remove(const GroupResources& group) {
    m_countsDirty = true;
    if (group.record.draw == gpu::kNotDrawn) return;
    for (Kind& kind : m_kinds)
        if (group.record.draw - kind.first < kind.room) kind.taken.Free(group.record.draw - kind.first, 1);
}

void DrawTable::Refresh(SceneGeometry& geometry, InstanceSet& instances) {
    if (m_numbersDirty) {
        instances.MarkGroupsChanged();
        Number(geometry, 2);
    }
    if (m_numbersDirty || m_countsDirty) Count(geometry, instances);
}

void DrawTable::Count(const SceneGeometry& geometry, const InstanceSet& instances) {
    for (uint32_t i = 0; i < m_draws.Size(); ++i) m_draws.Edit(i) = {};
    m_chunkCount = 0;
    for (uint32_t i = 0; i < geometry.groups.size(); ++i) {
        const GroupResources& group = geometry.groups[i];
        if (group.record.draw == gpu::kNotDrawn) continue;
        gpu::DrawRecord& record = m_draws.Edit(group.record.draw);
        record.vertexCount = static_cast<uint32_t>(3 * group.triangleCount);
        record.firstSlot = instances.PlacementsOf(i);
        SetBounds(group);
        m_chunkCount +=
            record.firstSlot * ((group.triangleCount + gpu::kChunkTriangles - 1) / gpu::kChunkTriangles);
    }
    uint32_t slots = 0;
    for (uint32_t i = 0; i < m_draws.Size(); ++i) slots += std::exchange(m_draws.Edit(i).firstSlot, slots);
    m_numbersDirty = m_countsDirty = false;
}

void DrawTable::SetBounds(const GroupResources& group) {
    if (group.record.draw == gpu::kNotDrawn) return;  // a round primitive, or one without a number
    gpu::DrawRecord& record = m_draws.Edit(group.record.draw);
    record.boundsMin = group.bounds.min;
    record.boundsMax = group.bounds.max;
}

void DrawTable::Declare(Renderer& renderer, SceneIds& ids) {
    ids.draws = m_draws.Declare(renderer);
    for (size_t kind = 0; kind < kDrawKindCount; ++kind)
        ids.drawsOfKind[kind] = {.first = m_kinds[kind].first, .count = m_kinds[kind].taken.End()};
    ids.chunkCount = m_chunkCount;
}

}  // namespace raygraph

#include "renderer/gpu_scene/draw_table.h"

#include <algorithm>

#include "renderer/gpu_scene/device_limits.h"
#include "shaders/shared/chunk_records.h"

namespace raygraph {

DrawKind KindOf(const GroupKind& group) {
    if (group.isOpaque) return group.isBackCulled ? DrawKind::Opaque : DrawKind::OpaqueTwoSided;
    return group.isBackCulled ? DrawKind::AlphaTested : DrawKind::AlphaTestedTwoSided;
}

DrawTable MakeDrawTable(rhi::Device& device, rhi::Uploader& uploader, SceneResources& resources,
                        std::span<const InstanceSet::Placement> placements) {
    std::vector<uint32_t> placementsOf(resources.groups.size());
    for (const InstanceSet::Placement& placement : placements) placementsOf[placement.group]++;

    DrawTable table;
    std::vector<gpu::DrawRecord> records;
    for (size_t kind = 0; kind < kDrawKindCount; ++kind) {
        table.drawsOfKind[kind].first = static_cast<uint32_t>(records.size());
        for (size_t i = 0; i < resources.groups.size(); ++i) {
            GroupResources& group = resources.groups[i];
            if (group.kind.isRound || KindOf(group.kind) != static_cast<DrawKind>(kind)) continue;
            group.record.draw = static_cast<uint32_t>(records.size());
            records.push_back({.boundsMin = group.bounds.min,
                               .vertexCount = static_cast<uint32_t>(3 * group.triangleCount),
                               .boundsMax = group.bounds.max,
                               .firstSlot = table.placementCount});
            table.placementCount += placementsOf[i];
            table.chunkCount +=
                placementsOf[i] * ((group.triangleCount + gpu::kChunkTriangles - 1) / gpu::kChunkTriangles);
        }
        table.drawsOfKind[kind].count = static_cast<uint32_t>(records.size()) - table.drawsOfKind[kind].first;
    }
    for (size_t i = 0; i < resources.groups.size(); ++i) {
        if (!resources.groups[i].kind.isRound) continue;
        resources.groups[i].record.draw = gpu::kNotDrawn;
        table.placementCount += placementsOf[i];
    }
    if (records.empty()) records.emplace_back();  // an empty buffer cannot be bound
    RequireBindable(device, "draws", records.size(), sizeof(records[0]));
    const auto bytes = std::as_bytes(std::span<const gpu::DrawRecord>(records));
    table.records = device.CreateBuffer({.name = "draws",
                                         .size = bytes.size(),
                                         .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopySource |
                                                  rhi::BufferUsage::CopyDestination});
    uploader.UploadBuffer(table.records, 0, bytes);
    table.onHost = std::move(records);
    return table;
}

}  // namespace raygraph

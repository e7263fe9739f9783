// The scene as a list of draws: one for each group of triangles, whatever the number of its placements. Round
// primitives are not drawn: raster views find them by rays.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/instance_set.h"
#include "renderer/gpu_scene/scene_resources.h"
#include "shaders/shared/draw_records.h"

namespace raygraph {

struct DrawTable {
    rhi::Buffer records;  // gpu::DrawRecord[]
    std::vector<gpu::DrawRecord> onHost;
    std::array<DrawRange, kDrawKindCount> drawsOfKind{};
    uint32_t placementCount = 0;
    uint64_t chunkCount = 0;  // of all placements, see shaders/shared/chunk_records.h
};

DrawKind KindOf(const GroupKind& group);

// Uploads the table, and gives each group's record the number of its draw.
DrawTable MakeDrawTable(rhi::Device& device, rhi::Uploader& uploader, SceneResources& resources,
                        std::span<const InstanceSet::Placement> placements);

}  // namespace raygraph

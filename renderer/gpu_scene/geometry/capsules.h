// The round primitives of a group in the layout of its BLAS. Threads: pure functions of their arguments.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

struct GroupCapsules {
    std::vector<gpu::CapsuleRecord> records;
    std::vector<scene::Bounds> boxes;  // input of rhi::AabbGeometry
    // By capsule: its primitive within the group; empty if there is only one primitive.
    std::vector<uint32_t> geometries;
    std::vector<uint32_t> originals;      // by capsule: its index in its primitive
    std::vector<uint32_t> firstVertices;  // by primitive
};

// Merges the capsules of all primitives into one list in spatial order. Moves positions, indices and radii
// out of the primitives.
GroupCapsules MergeCapsules(std::span<scene::Primitive* const> primitives);

}  // namespace raygraph

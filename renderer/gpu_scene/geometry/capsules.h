// The round primitives of a group, as its BLAS has them. Threads: pure functions of their arguments.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

struct GroupCapsules {
    std::vector<gpu::CapsuleRecord> records;
    std::vector<scene::Bounds> boxes;  // as rhi::AabbGeometry has them
    std::vector<uint32_t> geometries;  // a capsule's primitive within the group; empty if there is one only
    std::vector<uint32_t> originals;   // a capsule's index in its primitive
    std::vector<uint32_t> firstVertices;  // by primitive
};

// One list of all, in spatial order. Takes positions, indices and radii.
GroupCapsules MergeCapsules(std::span<scene::Primitive* const> primitives);

}  // namespace raygraph

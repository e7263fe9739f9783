#include "renderer/gpu_scene/geometry/capsules.h"

#include "renderer/gpu_scene/geometry/spatial_order.h"
#include "renderer/scene/geometry/round_primitives.h"

namespace raygraph {

static_assert(sizeof(scene::Bounds) == 6 * sizeof(float));

GroupCapsules MergeCapsules(std::span<scene::Primitive* const> primitives) {
    GroupCapsules listed, sorted;
    std::vector<glm::vec3> centers;
    uint32_t firstVertex = 0;
    for (uint32_t p = 0; p < primitives.size(); ++p) {
        scene::Primitive& primitive = *primitives[p];
        sorted.firstVertices.push_back(firstVertex);
        for (uint32_t i = 0; i < primitive.radii.size(); ++i) {
            const uint32_t first = primitive.indices[2 * i], second = primitive.indices[2 * i + 1];
            const glm::vec3 p0 = primitive.positions[first], p1 = primitive.positions[second];
            listed.records.push_back({.p0 = p0,
                                      .radius = primitive.radii[i],
                                      .p1 = p1,
                                      .first = firstVertex + first,
                                      .second = firstVertex + second});
            listed.geometries.push_back(p);
            listed.originals.push_back(i);
            centers.push_back(0.5f * p0 + 0.5f * p1);
        }
        firstVertex += static_cast<uint32_t>(primitive.positions.size());
        primitive.positions = {};
        primitive.indices = {};
        primitive.radii = {};
    }
    for (const uint32_t source : SpatialOrder(centers)) {
        const gpu::CapsuleRecord& record = listed.records[source];
        sorted.records.push_back(record);
        sorted.boxes.push_back(scene::RoundBox(record.p0, record.p1, record.radius));
        if (primitives.size() > 1) sorted.geometries.push_back(listed.geometries[source]);
        sorted.originals.push_back(listed.originals[source]);
    }
    return sorted;
}

}  // namespace raygraph

#include "renderer/gpu_scene/spatial_order.h"

#include <meshoptimizer.h>

namespace raygraph {

std::vector<uint32_t> SpatialOrder(std::span<const glm::vec3> points) {
    std::vector<uint32_t> order(points.size());
    if (points.empty()) return order;
    std::vector<uint32_t> remap(points.size());
    meshopt_spatialSortRemap(remap.data(), &points[0].x, points.size(), sizeof(glm::vec3));
    for (uint32_t i = 0; i < points.size(); ++i) order[remap[i]] = i;
    return order;
}

std::vector<uint32_t> SortTriangles(std::span<const glm::vec3> positions, std::vector<uint32_t>& indices) {
    const size_t triangleCount = indices.size() / 3;
    std::vector<uint32_t> order;
    {
        std::vector<glm::vec3> centroids(triangleCount);
        for (size_t i = 0; i < triangleCount; ++i)
            centroids[i] =
                (positions[indices[3 * i]] + positions[indices[3 * i + 1]] + positions[indices[3 * i + 2]]) /
                3.0f;
        order = SpatialOrder(centroids);
    }
    bool isMoved = false;
    std::vector<uint32_t> sorted(indices.size());
    for (size_t i = 0; i < triangleCount; ++i) {
        const size_t source = order[i];
        isMoved |= source != i;
        for (size_t corner = 0; corner < 3; ++corner) sorted[3 * i + corner] = indices[3 * source + corner];
    }
    if (!isMoved) return {};
    indices = std::move(sorted);
    return order;
}

}  // namespace raygraph

#include "renderer/gpu_scene/geometry/refit_quality.h"

#include "renderer/gpu_scene/geometry/spatial_order.h"
#include "renderer/scene/model/mesh_data.h"

namespace raygraph {
namespace {

std::vector<uint32_t> OrderOf(std::span<const glm::vec3> corners) {
    std::vector<glm::vec3> centers(corners.size() / 3);
    for (size_t i = 0; i < centers.size(); ++i)
        centers[i] = (corners[3 * i] + corners[3 * i + 1] + corners[3 * i + 2]) / 3.0f;
    return SpatialOrder(centers);
}

double Area(const scene::Bounds& bounds) {
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
    sum += Area(bounds);
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

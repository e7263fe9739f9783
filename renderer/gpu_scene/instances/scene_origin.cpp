#include "renderer/gpu_scene/instances/scene_origin.h"

#include <algorithm>
#include <cmath>

namespace raygraph {

glm::dvec3 ChooseSceneOrigin(const glm::dvec3& current, const glm::dvec3& eye, const scene::Bounds& scene) {
    if (scene.IsEmpty()) return current;
    const glm::dvec3 nearest = glm::clamp(eye, glm::dvec3(scene.min), glm::dvec3(scene.max));
    bool isFar = false;
    for (int axis = 0; axis < 3; ++axis) {
        if (!std::isfinite(nearest[axis])) return current;
        isFar |= std::abs(nearest[axis] - current[axis]) > kOriginGrid;
    }
    return isFar ? kOriginGrid * glm::round(nearest / kOriginGrid) : current;
}

bool OriginHysteresis::Moves(const glm::dvec3& current, const glm::dvec3& wanted) {
    if (current == wanted) {
        m_farCount = 0;
        return false;
    }
    ++m_farCount;
    const glm::dvec3 way = glm::abs(wanted - current);
    const bool isBeyondReach = std::max({way.x, way.y, way.z}) > kOriginReach;
    if (!isBeyondReach && m_farCount < kFarViewpointsToMove) return false;
    m_farCount = 0;
    return true;
}

}  // namespace raygraph

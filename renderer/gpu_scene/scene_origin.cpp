#include "renderer/gpu_scene/scene_origin.h"

#include <cmath>

namespace raygraph {

glm::dvec3 ChooseSceneOrigin(const glm::dvec3& current, const glm::dvec3& eye, const scene::Bounds& scene) {
    if (scene.IsEmpty()) return current;
    const glm::dvec3 nearest = glm::clamp(eye, glm::dvec3(scene.min), glm::dvec3(scene.max));
    bool isFar = false;
    for (int axis = 0; axis < 3; axis++) {
        if (!std::isfinite(nearest[axis])) return current;
        isFar |= std::abs(nearest[axis] - current[axis]) > kOriginGrid;
    }
    return isFar ? kOriginGrid * glm::round(nearest / kOriginGrid) : current;
}

}  // namespace raygraph

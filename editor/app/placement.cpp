#include "editor/app/placement.h"

#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace raygraph::editor {

namespace {

glm::quat Turn(const Placement& placed) {
    return glm::quat(glm::radians(placed.degrees));
}

}  // namespace

Placement PlacementOf(const glm::mat4x3& local) {
    Placement placed;
    placed.translation = local[3];
    glm::mat3 turn(1.0f);
    for (int i = 0; i < 3; ++i) {
        placed.scale[i] = glm::length(local[i]);
        if (placed.scale[i] > 0.0f) turn[i] = local[i] / placed.scale[i];
    }
    if (glm::determinant(turn) < 0.0f) {
        placed.scale.x = -placed.scale.x;
        turn[0] = -turn[0];
    }
    // This orthonormal frame turns with the matrix, and scaling along its axes does not change it
    const glm::vec3 normal = glm::cross(turn[0], turn[1]);
    if (glm::length(normal) > 1e-6f) {
        turn[2] = glm::normalize(normal);
        turn[1] = glm::cross(turn[2], turn[0]);
    }
    placed.degrees = glm::degrees(glm::eulerAngles(glm::normalize(glm::quat_cast(turn)))) +
                     0.0f;  // adding 0 turns -0 into 0
    return placed;
}

glm::mat4x3 Placed(const glm::mat4x3& local, const Placement& before, const Placement& after) {
    glm::mat3 axes(local);
    if (after.degrees != before.degrees)
        axes = glm::mat3_cast(Turn(after) * glm::conjugate(Turn(before))) * axes;
    for (int i = 0; i < 3; ++i) {
        if (after.scale[i] == before.scale[i]) continue;
        if (before.scale[i] != 0.0f)
            axes[i] *= after.scale[i] / before.scale[i];
        else
            axes[i] = after.scale[i] * glm::mat3_cast(Turn(after))[i];
    }
    return {axes[0], axes[1], axes[2], after.translation};
}

}  // namespace raygraph::editor

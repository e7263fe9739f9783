#include "renderer/scene/geometry/transform_parts.h"

#include "renderer/scene/geometry/linear_map.h"

namespace raygraph::scene {
namespace {

glm::mat4x3 Matrix(const TransformParts& parts) {
    Node node;
    node.translation = parts.translation;
    node.rotation = parts.rotation;
    node.scale = parts.scale;
    return node.LocalTransform();
}

// Within rounding of products of such matrices.
bool IsNear(const glm::mat4x3& a, const glm::mat4x3& b) {
    for (int column = 0; column < 4; ++column) {
        const float size = glm::length(a[column]) + glm::length(b[column]);
        if (glm::length(a[column] - b[column]) > 4e-6f * size) return false;
    }
    return true;
}

}  // namespace

std::optional<TransformParts> PartsOf(const glm::mat4x3& local, const Node& own) {
    TransformParts parts{own.translation, own.rotation, own.scale};
    parts.translation = local[3];
    if (IsNear(Matrix(parts), local)) return parts;
    const auto turned = [&](const glm::vec3& scale) {
        glm::mat3 turn(local);
        for (int i = 0; i < 3; ++i) turn[i] /= scale[i];
        return glm::normalize(glm::quat_cast(turn));
    };
    if (own.scale.x != 0.0f && own.scale.y != 0.0f && own.scale.z != 0.0f) {
        parts.rotation = turned(own.scale);
        if (IsNear(Matrix(parts), local)) return parts;
    }
    glm::vec3 scale(glm::length(local[0]), glm::length(local[1]), glm::length(local[2]));
    if (IsMirrored(local)) scale.x = -scale.x;
    for (int i = 0; i < 3; ++i)
        if (scale[i] == 0.0f) return std::nullopt;
    parts.scale = scale;
    parts.rotation = own.rotation;
    if (IsNear(Matrix(parts), local)) return parts;
    parts.rotation = turned(scale);
    if (IsNear(Matrix(parts), local)) return parts;
    return std::nullopt;
}

}  // namespace raygraph::scene

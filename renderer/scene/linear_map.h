// What the three columns of a transform's linear part say about it. Threads: pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>

namespace raygraph::scene {

// The determinant times the inverse transpose, which is finite where there is no inverse: it carries normals
// over, and the lengths of its columns are the areas of the faces of the unit cube's image.
template <typename T>
glm::mat<3, 3, T> Cofactors(const glm::mat<3, 3, T>& m) {
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

// Whether the transform turns the winding of triangles around. In double, whose range the products of three
// floats do not leave.
inline bool IsMirrored(const glm::mat4x3& transform) {
    return glm::determinant(glm::dmat3(transform)) < 0.0;
}

}  // namespace raygraph::scene

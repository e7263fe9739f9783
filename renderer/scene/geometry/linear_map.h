// Properties of the linear part of a transform, computed from its three columns. Threads: pure functions, for
// any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace raygraph::scene {

// The determinant times the inverse transpose, which is finite where there is no inverse: it carries normals
// over, and the lengths of its columns are the areas of the faces of the unit cube's image.
template <typename T>
glm::mat<3, 3, T> Cofactors(const glm::mat<3, 3, T>& m) {
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

// Returns whether the transform turns the winding of triangles around. In double, whose range the products of
// three floats do not leave.
inline bool IsMirrored(const glm::mat4x3& transform) {
    return glm::determinant(glm::dmat3(transform)) < 0.0;
}

inline double SquareOf(const glm::dmat3& m) {
    return glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]);
}

// The two greater singular values, of the square of a matrix and the area of its cofactors. Where s3 is 0,
// their squares are s1^2 + s2^2 and s1^2 s2^2.
struct Widths {
    double s1 = 0.0, s2 = 0.0;
};
inline Widths WidthsOf(double square, double area) {
    const double half = 0.5 * square;
    const double s1 = std::sqrt(half + std::sqrt(std::max(half * half - area * area, 0.0)));
    return {s1, s1 > 0.0 ? area / s1 : 0.0};
}

// Returns approximately s3 / s2 where that is far below 1; 0 if s2 is 0.
inline double Flatness(const glm::mat4x3& transform) {
    const glm::dmat3 linear(transform);
    const double area = std::sqrt(SquareOf(Cofactors(linear)));
    const double s2 = WidthsOf(SquareOf(linear), area).s2;
    return s2 > 0.0 ? std::abs(glm::determinant(linear)) / (area * s2) : 0.0;
}

}  // namespace raygraph::scene

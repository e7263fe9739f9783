// Transforms of instances: flat ones are given a thickness, and any is measured or taken apart into
// translation, rotation and scale. Positions in double precision as pairs of floats. Threads: pure functions,
// for any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Holds a position in double precision as the sum of two floats.
struct FloatPair {
    glm::vec3 rounded{0.0f};  // to float
    glm::vec3 rest{0.0f};     // the remainder of the rounding
};
RAYGRAPH_API FloatPair ToFloatPair(const glm::dvec3& position);

// --- Flat transforms ---
// They squeeze a mesh into a plane: a scale of 0 on one axis, in a node or in one above it, or so little
// that float cannot tell it from 0. Devices invert the transforms of instances, so a flat one is shown with
// a thickness, too small to be seen and large enough for rays.
//
// With the singular values s1 >= s2 >= s3 of the matrix M, the unit normal n of the plane and the unit
// direction m of object space that M squeezes, the matrix becomes M + (s - s3) n m^T: only s3 is another
// one. Normals are carried over by its inverse transpose and so become n, and areas stay.
//
// A transform that is almost flat is thickened, too, if m is not along an axis and s3 is less than rays need:
// they would hit the mesh elsewhere. It mirrors as before. Along an axis any s3 will do that float can tell
// from 0.
//
// The front of the mesh is in front as it would be with a small positive scale in place of 0. A matrix by
// itself does not tell that: it counts as not mirrored.

// The thickness that a flattened mesh gets, relative to the square root of the area of its box in the plane:
// the first one if it is squeezed along one of its axes, up to the second one along other directions. The
// first one has to be several steps of float at the distance of a ray, or hits of the two sides come in the
// wrong order: a box of 2 m gets half a millimeter, 32 steps at 200 m. Along other directions rays in the
// mesh's space come from very far away along m, where all of their coordinates are rounded to a step of
// float: at the second thickness hits are off by 6e-5 of their distance (root mean square), a tenth of a
// pixel of a view of 60 degrees that is 1920 pixels wide.
inline constexpr double kFlatThickness = 1.0 / 4096.0, kObliqueThickness = 1.0 / 1024.0;

// Returns true where s3 / s1 is below 2^-30, or where float cannot tell the sign of the determinant: where it
// is less than 2^-21 of the sum of its terms' sizes, whichever axes are scaled.
RAYGRAPH_API bool IsFlat(const glm::mat4x3& transform);

// Returns whether WithThickness may return another transform: it is flat, or flatter than kObliqueThickness.
RAYGRAPH_API bool MayGainThickness(const glm::mat4x3& transform);

// Returns the transform with which an instance of a mesh with this box (object space) is shown: `placed`, bit
// for bit, unless it is flat, or almost so and oblique. A flattened box has its middle in the plane, so its
// shape may be far from its origin. Nothing if no area is left, or what is left has no inverse in float
// (CanInvert): a scale of 0 on two axes or more, numbers that are not finite.
RAYGRAPH_API std::optional<PlacedTransform> WithThickness(const PlacedTransform& placed, const Bounds& mesh,
                                                          bool isMirrored = false);

// Thickens an instance of a scene; `placed` is the transform by its node, or by its skin.
RAYGRAPH_API std::optional<PlacedTransform> WithThickness(const SceneData& scene, const Instance& instance,
                                                          const PlacedTransform& placed);

// Returns the transform of a node for what only has directions, a camera or a light: where the node is flat,
// the axis that is squeezed keeps the direction that it has with a small positive scale.
RAYGRAPH_API PlacedTransform WithDirections(const SceneData& scene, uint32_t node,
                                            const PlacedTransform& nodeToWorld);

// Returns the factor by which the transform scales lengths on average over the directions that it does not
// squeeze: the cube root of the volume of the unit cube's image; of a flat one, the square root of the
// greatest area that the image of a unit square has.
RAYGRAPH_API double MeanScale(const glm::mat4x3& transform);

// --- Properties of the linear part of a transform, computed from its three columns ---

// Returns the determinant times the inverse transpose, which is finite where there is no inverse: it carries
// normals over, and the lengths of its columns are the areas of the faces of the unit cube's image.
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

// Holds the two greater singular values, of the square of a matrix and the area of its cofactors. Where s3 is
// 0, their squares are s1^2 + s2^2 and s1^2 s2^2.
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

// Describes a local transform as translation, rotation and scale, as a node without a matrix has it.
struct TransformParts {
    glm::vec3 translation{0.0f};
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};  // unit length
    glm::vec3 scale{1.0f};
};

// Returns the parts that make `local` but for rounding of products of such matrices, as many as may be the
// node's own to the bit; nothing if it shears, or is flat.
RAYGRAPH_API std::optional<TransformParts> PartsOf(const glm::mat4x3& local, const Node& own);

}  // namespace raygraph::scene

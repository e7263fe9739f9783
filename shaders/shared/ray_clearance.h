// The distance from a triangle's plane at which a ray must start or end so that it does not hit the triangle:
// a bound of all rounding from its vertices to a point in world space, and back to the intersection test. One
// source for C++ and GLSL.
#ifndef RAYGRAPH_SHARED_RAY_CLEARANCE_H
#define RAYGRAPH_SHARED_RAY_CLEARANCE_H

#include "unit_vector.h"

#ifdef __cplusplus

#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::abs;
using glm::cross;
using glm::dot;
using glm::mat3;
using glm::max;
using glm::min;
using glm::vec3;
#define RAYGRAPH_CONSTANT inline constexpr
#define RAYGRAPH_INLINE   inline
#else
#define RAYGRAPH_CONSTANT const
#define RAYGRAPH_INLINE
#endif

// A bit above 2^-24, half a step of float, for terms of higher order and for the rounding of the
// bound itself.
RAYGRAPH_CONSTANT float kRoundoff = 6.0e-8f;
// In the same units. A device transforms a ray into object space by an inverse of the transform that it made
// in float: of a million random transforms the worst is off by 5.5 times the sizes of the sums' terms.
RAYGRAPH_CONSTANT float kInverseRoundings = 6.0f;
// The error of the intersection test, in the same units and relative to the triangle's extent.
RAYGRAPH_CONSTANT float kIntersectionRoundings = 8.0f;
// The error of the test grows as a triangle becomes a sliver. It is limited to this: slivers would offset
// rays farther than they are wide.
RAYGRAPH_CONSTANT float kMaxSliver = 64.0f;

// Returns the terms of cross(a, b), added up whatever their signs; none of a and b is negative.
RAYGRAPH_INLINE vec3 CrossOfSizes(vec3 a, vec3 b) {
    return vec3(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x);
}

RAYGRAPH_INLINE float SumOfSizes(vec3 v) {
    return abs(v.x) + abs(v.y) + abs(v.z);
}

// Returns the error of the intersection test along the normal of a triangle with these edges, in roundings
// and times the length of normal = cross(e1, e2). The weights of the vertices have errors, which move a hit
// in the plane by a share of the edges, and so along each ray that is not at a right angle to the plane.
RAYGRAPH_INLINE float TestError(vec3 e1, vec3 e2, vec3 normal) {
    vec3 extent1 = abs(e1), extent2 = abs(e2), extent = max(extent1, extent2);
    float sliver = min(SumOfSizes(CrossOfSizes(extent1, extent2)), kMaxSliver * SumOfSizes(normal));
    return kIntersectionRoundings * max(extent.x, max(extent.y, extent.z)) * sliver;
}

// The triangle has the vertices p0, p0 + e1 and p0 + e2 in object space; linear and translation place it; p
// is a point of it that was computed as p0 + b1 e1 + b2 e2. The result is meters in the world. Its bound
// covers the rounding of p (2 roundings of the vertices' sizes, 3 of the edges'), of its place linear * p +
// translation, of the place moved by the result along the unit normal, and what the device does then.
//
// Running error bounds: N. Higham 2002, "Accuracy and Stability of Numerical Algorithms", chapter 3; for
// rays: M. Pharr, W. Jakob and G. Humphreys 2023, "Physically Based Rendering", 4th edition, section 6.8. The
// bound includes the transforms in both directions: C. Wächter and N. Binder 2019, "A Fast and Robust Method
// for Avoiding Self-Intersection". Everything here is times the length of `across`, until the end: so the
// object's errors need no division by the determinant.
RAYGRAPH_INLINE float RayClearance(mat3 linear, vec3 translation, vec3 p0, vec3 e1, vec3 e2, vec3 p) {
    vec3 x = linear[0];
    vec3 y = linear[1];
    vec3 z = linear[2];
    vec3 yz = cross(y, z);
    vec3 normal = cross(e1, e2);
    vec3 across = normal.x * yz + normal.y * cross(z, x) + normal.z * cross(x, y);  // normal in the world
    vec3 sizeX = abs(x), sizeY = abs(y), sizeZ = abs(z), sizeN = abs(normal);
    vec3 placed = sizeX * abs(p.x) + sizeY * abs(p.y) + sizeZ * abs(p.z);
    vec3 position = x * p.x + y * p.y + z * p.z + translation;
    vec3 worldError = 3.0f * placed + 2.0f * abs(position);
    vec3 sizes = abs(position) + abs(translation);
    // inverseError is sizeN times the matrix of the inverse's terms, whose rows are CrossOfSizes of two
    // columns, times `sizes`
    vec3 ofX = CrossOfSizes(sizeX, sizes), ofY = CrossOfSizes(sizeY, sizes);
    float inverseError = dot(sizeZ, sizeN.x * ofY + sizeN.y * ofX) + sizeN.z * dot(sizeY, ofX);
    vec3 objectError = 2.0f * max(abs(p0), max(abs(p0 + e1), abs(p0 + e2))) + 3.0f * max(abs(e1), abs(e2));
    float determinant = abs(dot(x, yz));
    // The ray meets the triangle in object space or, in a tree of one level, in the world. Neither error
    // bounds the other: a transform that squeezes an axis carries the first one over as next to nothing.
    float testError = max(determinant * TestError(e1, e2, normal),
                          TestError(x * e1.x + y * e1.y + z * e1.z, x * e2.x + y * e2.y + z * e2.z, across));
    float bound = dot(abs(across), worldError) + kInverseRoundings * inverseError +
                  determinant * dot(sizeN, objectError) + testError;
    // A triangle without area has no plane: a ray may leave it in any direction. This is a choice, not a
    // branch: devices would fetch nothing of the surface until all of this is done
    float inAnyDirection = SumOfSizes(worldError) + kInverseRoundings * SumOfSizes(sizes);
    float inverse = InverseLength(across);
    return kRoundoff * (inverse > 0.0f ? bound * inverse : inAnyDirection);
}

#undef RAYGRAPH_CONSTANT
#undef RAYGRAPH_INLINE

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

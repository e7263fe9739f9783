// Directions and lengths of vectors of any size: the cross product of two edges is in square meters, and its
// square overflows where they are longer than 4e9 m, and vanishes where they are shorter than 1e-10 m. One
// source for C++ and GLSL.
#ifndef RAYGRAPH_SHARED_UNIT_VECTOR_H
#define RAYGRAPH_SHARED_UNIT_VECTOR_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::abs;
using glm::dot;
using glm::floatBitsToUint;
using glm::inversesqrt;
using glm::max;
using glm::uintBitsToFloat;
using glm::vec3;
using uint = uint32_t;
#define RAYGRAPH_INLINE inline
#else
#define RAYGRAPH_INLINE
#endif

// 1 / length; 0 where v has no direction: it is zero or denormal, it has a NaN, or a component of 2^127 or
// more. (Of denormal ones 1 / length may be infinite, and devices may take them for zero.) A power of two
// brings the largest component to between 1 and 2 first. Products with it are exact: where v may be squared
// as it is, the bits are those of inversesqrt(dot(v, v)).
RAYGRAPH_INLINE float InverseLength(vec3 v) {
    float largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    uint exponent = floatBitsToUint(largest) & 0x7f800000u;
    float scale = uintBitsToFloat(0x7f000000u - exponent);
    v *= scale;
    float square = dot(v, v);
    return exponent != 0u && square > 0.0f && square < 16.0f ? scale * inversesqrt(square) : 0.0f;
}

// `otherwise` where v has no direction.
RAYGRAPH_INLINE vec3 UnitOr(vec3 v, vec3 otherwise) {
    float inverse = InverseLength(v);
    return inverse > 0.0f ? v * inverse : otherwise;
}

#undef RAYGRAPH_INLINE

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

// Where a ray that leaves a surface starts, so that it does not hit the surface again. Wächter and Binder
// 2019, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, chapter 6: the origin
// moves along the normal by a number of float steps of its own coordinates, and by a constant distance near
// the planes through the world's origin, where float steps are smaller than the error of the hit point.
#ifndef RAYGRAPH_CORE_RAY_OFFSET_GLSL
#define RAYGRAPH_CORE_RAY_OFFSET_GLSL

#include "core/glue.h"

SHADING_BEGIN

CONST float kRayOffsetOrigin = 0.03125f;               // 1 / 32: below this a coordinate moves by a constant.
CONST float kRayOffsetFloatScale = 1.52587890625e-5f;  // 1 / 65536
CONST float kRayOffsetIntScale = 256.0f;

INLINE float OffsetCoordinate(float p, float n) {
    // Away from zero adds to the bits of either sign, so a negative coordinate takes the steps with their
    // sign turned. In uint, where the sum may wrap on its way: its result is then not the one used.
    int steps = int(kRayOffsetIntScale * n);
    uint moved = floatBitsToUint(p) + uint(p < 0.0f ? -steps : steps);
    return abs(p) < kRayOffsetOrigin ? p + kRayOffsetFloatScale * n : uintBitsToFloat(moved);
}

// p: a point on the surface, from the vertices and barycentrics (not from origin + t * direction). n: the
// unit geometric normal on the side the new ray goes to. Finite p and n; world units from about 1e-3 to 1e6.
INLINE vec3 OffsetRayOrigin(vec3 p, vec3 n) {
    return vec3(OffsetCoordinate(p.x, n.x), OffsetCoordinate(p.y, n.y), OffsetCoordinate(p.z, n.z));
}

SHADING_END

#endif

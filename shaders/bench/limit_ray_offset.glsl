// The ray offset of version 1 of the limits: do not change it, so that their numbers can be compared over the
// years. Wächter and Binder 2019, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing
// Gems, chapter 6: the origin moves along the normal by a number of float steps of its own coordinates, and
// by a constant distance near the planes through the world's origin.
#ifndef RAYGRAPH_BENCH_LIMIT_RAY_OFFSET_GLSL
#define RAYGRAPH_BENCH_LIMIT_RAY_OFFSET_GLSL

const float kRayOffsetOrigin = 0.03125f;               // 1 / 32: below this a coordinate moves by a constant
const float kRayOffsetFloatScale = 1.52587890625e-5f;  // 1 / 65536
const float kRayOffsetIntScale = 256.0f;

float OffsetCoordinate(float p, float n) {
    // Away from zero adds to the bits of either sign, so a negative coordinate takes the steps with their
    // sign turned. In uint, where the sum may wrap on its way: its result is then not the one used.
    int steps = int(kRayOffsetIntScale * n);
    uint moved = floatBitsToUint(p) + uint(p < 0.0f ? -steps : steps);
    return abs(p) < kRayOffsetOrigin ? p + kRayOffsetFloatScale * n : uintBitsToFloat(moved);
}

vec3 OffsetLimitRay(vec3 p, vec3 n) {
    return vec3(OffsetCoordinate(p.x, n.x), OffsetCoordinate(p.y, n.y), OffsetCoordinate(p.z, n.z));
}

#endif

// Constants and scalar helpers that more than one file needs.
#ifndef RAYGRAPH_CORE_MATH_GLSL
#define RAYGRAPH_CORE_MATH_GLSL

#include "core/glue.h"
#include "shared/unit_vector.h"

#ifdef __cplusplus
namespace raygraph::shading {
using gpu::InverseLength;
using gpu::UnitOr;
}  // namespace raygraph::shading
#endif

SHADING_BEGIN

CONST float kPi = 3.14159265358979f;
CONST float kTwoPi = 6.28318530717959f;
CONST float kPiOver2 = 1.57079632679490f;
CONST float kPiOver4 = 0.785398163397448f;
CONST float kInvPi = 0.318309886183791f;
CONST float kInv2Pi = 0.159154943091895f;
CONST float kInv4Pi = 0.0795774715459477f;

INLINE float Sqr(float x) { return x * x; }

// Returns the root of a value that rounding may have left just below zero.
INLINE float SafeSqrt(float x) { return sqrt(max(x, 0.0f)); }

INLINE float MaxComponent(vec3 v) { return max(v.x, max(v.y, v.z)); }

// Returns whether x is neither NaN nor infinite; by its bits, which no optimization for finite numbers takes
// away.
INLINE bool IsFinite(float x) { return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u; }
INLINE bool IsFinite(vec3 v) { return IsFinite(v.x) && IsFinite(v.y) && IsFinite(v.z); }

// Returns (cos x, sin x) for |x| <= pi / 4, to one unit in the last place: S. Moshier's polynomials (Cephes,
// sinf and cosf). Shading uses these where it can, since GLSL's own may be off by 2^-11, and by different
// amounts on each device.
INLINE vec2 CosSinOctant(float x) {
    float x2 = x * x;
    float c = ((2.443315711809948e-5f * x2 - 1.388731625493765e-3f) * x2 + 4.166664568298827e-2f) * x2;
    float s = ((-1.9515295891e-4f * x2 + 8.3321608736e-3f) * x2 - 1.6666654611e-1f) * x2;
    return vec2(1.0f + (c - 0.5f) * x2, x + s * x);
}

// Returns (cos, sin) of so many whole turns, 0 <= turn <= 1.
INLINE vec2 CosSinTurn(float turn) {
    float quarter = floor(4.0f * turn + 0.5f);
    vec2 cs = CosSinOctant(kTwoPi * (turn - 0.25f * quarter));
    uint quadrant = uint(int(quarter)) & 3u;
    bool isSwapped = (quadrant & 1u) != 0u;
    float c = isSwapped ? cs.y : cs.x;
    float s = isSwapped ? cs.x : cs.y;
    return vec2(quadrant == 1u || quadrant == 2u ? -c : c, quadrant >= 2u ? -s : s);
}

SHADING_END

#endif

// Constants and the few scalar helpers that more than one file needs.
#ifndef RAYGRAPH_CORE_MATH_GLSL
#define RAYGRAPH_CORE_MATH_GLSL

#include "core/glue.h"

SHADING_BEGIN

CONST float kPi = 3.14159265358979f;
CONST float kTwoPi = 6.28318530717959f;
CONST float kPiOver2 = 1.57079632679490f;
CONST float kPiOver4 = 0.785398163397448f;
CONST float kInvPi = 0.318309886183791f;
CONST float kInv2Pi = 0.159154943091895f;
CONST float kInv4Pi = 0.0795774715459477f;

INLINE float Sqr(float x) { return x * x; }

// The root of a value that rounding may have left just below zero.
INLINE float SafeSqrt(float x) { return sqrt(max(x, 0.0f)); }

INLINE float MaxComponent(vec3 v) { return max(v.x, max(v.y, v.z)); }

SHADING_END

#endif

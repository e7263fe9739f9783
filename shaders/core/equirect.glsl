// Equirectangular environment maps in glTF's axes (right-handed, +y up). Without rotation: +x at u = 0.5, +z
// at u = 0.75, -z at u = 0.25, -x at the seam; v = 0 is +y, the first row of the image. `rotation` turns the
// environment about +y, counter-clockwise seen from above, in radians: at pi/2 the direction +x moves to -z.
#ifndef RAYGRAPH_CORE_EQUIRECT_GLSL
#define RAYGRAPH_CORE_EQUIRECT_GLSL

#include "core/math.glsl"

SHADING_BEGIN

// u = 0.5 + atan2(z, x) / 2 pi in [0, 1), v = acos(y) / pi in [0, 1]; d need not be of unit length. The polar
// angle is taken by atan2, exact near the poles where acos is not.
INLINE vec2 EquirectFromDirection(vec3 d, float rotation) {
    float u = fract(0.5f + (atan(d.z, d.x) + rotation) * kInv2Pi);
    float v = atan(sqrt(d.x * d.x + d.z * d.z), d.y) * kInvPi;
    // A turn of just below zero rounds to 1.
    return vec2(u < 1.0f ? u : 0.0f, v);
}

INLINE vec3 DirectionFromEquirect(vec2 uv, float rotation) {
    vec2 azimuth = CosSinTurn(fract(uv.x - 0.5f - rotation * kInv2Pi));
    vec2 polar = CosSinTurn(0.5f * uv.y);
    return vec3(polar.y * azimuth.x, polar.x, polar.y * azimuth.y);
}

// Returns a density over uv (integral 1 over the unit square) as one over solid angle; 0 at the poles, where
// none exists.
INLINE float EquirectSolidAnglePDF(float uvPDF, float v) {
    float sinTheta = CosSinTurn(0.5f * v).y;
    return sinTheta > 0.0f ? uvPDF * kInv2Pi * kInvPi / sinTheta : 0.0f;
}

SHADING_END

#endif

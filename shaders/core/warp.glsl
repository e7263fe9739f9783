// Maps from the unit square to the shapes that light transport samples, each with its density. The arguments
// u are in [0, 1); all maps are continuous except for one seam, so stratified points stay stratified. PDFs
// are with respect to area (disk, triangle in barycentrics) or solid angle (sphere, hemispheres about +z).
#ifndef RAYGRAPH_CORE_WARP_GLSL
#define RAYGRAPH_CORE_WARP_GLSL

#include "core/math.glsl"

SHADING_BEGIN

// Returns a point of the unit disk, uniform by area. Shirley and Chiu 1997, "A Low Distortion Map Between
// Disk and Square".
INLINE vec2 SampleUniformDiskConcentric(vec2 u) {
    float a = 2.0f * u.x - 1.0f;
    float b = 2.0f * u.y - 1.0f;
    bool isXMajor = abs(a) > abs(b);
    float radius = isXMajor ? a : b;
    if (radius == 0.0f) return vec2(0.0f, 0.0f);
    // This is the angle from the nearer axis, at most pi / 4.
    vec2 cs = CosSinOctant(kPiOver4 * ((isXMajor ? b : a) / radius));
    return vec2(radius * (isXMajor ? cs.x : cs.y), radius * (isXMajor ? cs.y : cs.x));
}

INLINE float UniformDiskPDF() { return kInvPi; }

// Returns a direction about +z with density cos(theta) / pi: the disk lifted to the hemisphere (Malley).
// Directions on the rim (z = 0, density 0) occur with u.x = 0 or u.y = 0: callers test the pdf before they
// divide by it.
INLINE vec3 SampleCosineHemisphere(vec2 u) {
    vec2 d = SampleUniformDiskConcentric(u);
    return vec3(d.x, d.y, SafeSqrt(1.0f - d.x * d.x - d.y * d.y));
}

INLINE float CosineHemispherePDF(float cosTheta) { return max(cosTheta, 0.0f) * kInvPi; }

// Returns a direction of the whole sphere; u.x runs from +z to -z (Archimedes).
INLINE vec3 SampleUniformSphere(vec2 u) {
    float z = 1.0f - 2.0f * u.x;
    // This is 1 - z^2 without the cancellation at the poles.
    float r = 2.0f * SafeSqrt(u.x * (1.0f - u.x));
    vec2 cs = CosSinTurn(u.y);
    return vec3(r * cs.x, r * cs.y, z);
}

INLINE float UniformSpherePDF() { return kInv4Pi; }

// Returns a direction about +z; u.x is the cosine.
INLINE vec3 SampleUniformHemisphere(vec2 u) {
    float z = u.x;
    float r = SafeSqrt(1.0f - z * z);
    vec2 cs = CosSinTurn(u.y);
    return vec3(r * cs.x, r * cs.y, z);
}

INLINE float UniformHemispherePDF() { return kInv2Pi; }

// Returns barycentric coordinates (weights of vertices 0, 1, 2; sum 1, none below 0), uniform by area. Heitz
// 2019, "A Low-Distortion Map Between Triangle and Square".
INLINE vec3 SampleUniformTriangle(vec2 u) {
    float b0 = 0.0f;
    float b1 = 0.0f;
    if (u.x < u.y) {
        b0 = 0.5f * u.x;
        b1 = u.y - b0;
    } else {
        b1 = 0.5f * u.y;
        b0 = u.x - b1;
    }
    return vec3(b0, b1, max(1.0f - b0 - b1, 0.0f));
}

// Returns the density in (b0, b1): the reference triangle has area 1/2. By area on a triangle of area A the
// density is 1 / A.
INLINE float UniformTrianglePDF() { return 2.0f; }

SHADING_END

#endif

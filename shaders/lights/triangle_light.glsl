// Directions to a triangle, uniform in solid angle; uniform by area where it looks too small or too large
// for that. Which of the two is a function of point and triangle, so that the density of a hit is that of
// a sample.
#ifndef RAYGRAPH_LIGHTS_TRIANGLE_LIGHT_GLSL
#define RAYGRAPH_LIGHTS_TRIANGLE_LIGHT_GLSL

#include "core/warp.glsl"
#include "lights/light_types.glsl"

SHADING_BEGIN

// Between these the map by solid angle is exact enough in float; in steradians.
CONST float kMinTriangleSolidAngle = 3.0e-4f;
CONST float kMaxTriangleSolidAngle = 6.2f;

// A triangle as seen from a point: unit vectors to its corners, and the terms of the solid angle and
// its inversion.
struct SphericalTriangle {
    vec3 v0;
    vec3 v1;
    vec3 v2;
    float determinant;  // |v0 . (v1 x v2)|
    float g1;           // v0 . v2 + v1 . v2
    float g2;           // 1 + v0 . v1
    float solidAngle;
};

// A. van Oosterom and J. Strackee 1983, "The Solid Angle of a Plane Triangle". The determinant is taken from
// differences, which keeps its digits when the triangle is small.
INLINE SphericalTriangle SphericalTriangleFrom(LightRecord light, vec3 position) {
    SphericalTriangle t;
    vec3 a = light.p0 - position;
    t.v0 = normalize(a);
    t.v1 = normalize(a + light.e1);
    t.v2 = normalize(a + light.e2);
    t.determinant = abs(dot(t.v0, cross(t.v1 - t.v0, t.v2 - t.v0)));
    t.g1 = dot(t.v0, t.v2) + dot(t.v1, t.v2);
    t.g2 = 1.0f + dot(t.v0, t.v1);
    t.solidAngle = 2.0f * atan(t.determinant, t.g1 + t.g2);
    return t;
}

// False also where a corner is at the point itself (NaN).
INLINE bool IsSampledBySolidAngle(SphericalTriangle t) {
    return t.solidAngle >= kMinTriangleSolidAngle && t.solidAngle <= kMaxTriangleSolidAngle;
}

// J. Arvo 1995, "Stratified Sampling of Spherical Triangles", with the cut through the triangle found as in
// C. Peters 2021, "BRDF Importance Sampling for Polygonal Lights": u.x chooses v, on the arc from v0 to v2,
// such that (v0, v1, v) has the share u.x of the solid angle; u.y a point of the arc from v1 to v.
INLINE vec3 SampleSphericalTriangle(SphericalTriangle t, vec2 u) {
    vec2 cs = CosSinTurn(u.x * t.solidAngle * kInv4Pi);  // of half the cut's solid angle
    vec3 halfway = (cs.x * t.determinant - cs.y * t.g1) * t.v0 + cs.y * t.g2 * t.v2;
    vec3 v = -t.v0 + (2.0f * dot(t.v0, halfway) / dot(halfway, halfway)) * halfway;
    vec3 across = v - t.v1;
    float height = 0.5f * dot(across, across);  // 1 - cos of the arc
    vec3 tangent = across + height * t.v1;
    float square = dot(tangent, tangent);
    if (!(square > 0.0f)) return t.v1;
    float h = u.y * height;
    return (1.0f - h) * t.v1 + sqrt(h * (2.0f - h) / square) * tangent;
}

INLINE bool EmitsTowards(LightRecord light, vec3 toViewer) {
    float side = dot(cross(light.e1, light.e2), toViewer);
    if ((light.flags & kLightMirrored) != 0u) side = -side;
    return side > 0.0f || (side < 0.0f && (light.flags & kLightDoubleSided) != 0u);
}

// Density per solid angle of the direction wi that meets the triangle at `distance`; 0 where it does
// not emit.
INLINE float TriangleLightPDF(LightRecord light, vec3 position, vec3 wi, float distance) {
    if (!EmitsTowards(light, -wi)) return 0.0f;
    SphericalTriangle t = SphericalTriangleFrom(light, position);
    if (IsSampledBySolidAngle(t)) return 1.0f / t.solidAngle;
    return 2.0f * distance * distance / abs(dot(cross(light.e1, light.e2), wi));
}

// Weights of vertices 1 and 2 of the point sampled.
INLINE vec2 SampleTriangleLight(LightRecord light, SphericalTriangle t, vec3 position, vec2 u) {
    if (!IsSampledBySolidAngle(t)) {
        vec3 weights = SampleUniformTriangle(u);
        return vec2(weights.y, weights.z);
    }
    vec3 wi = SampleSphericalTriangle(t, u);
    vec3 normal = cross(light.e1, light.e2);
    vec3 a = light.p0 - position;
    vec3 q = (dot(a, normal) / dot(wi, normal)) * wi - a;  // from vertex 0
    float scale = 1.0f / dot(normal, normal);
    float b1 = clamp(dot(cross(q, light.e2), normal) * scale, 0.0f, 1.0f);
    float b2 = clamp(dot(cross(light.e1, q), normal) * scale, 0.0f, 1.0f - b1);
    return vec2(b1, b2);
}

SHADING_END

#endif

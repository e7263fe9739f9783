// Directions to a triangle: uniform in its solid angle, or by area where it looks too small for that, or
// uniform in the half-space in which it is, of which some miss, where it looks too large or its corners are
// too nearly on one line through the point. Point and triangle decide which, so that the density of a hit is
// that of a sample.
#ifndef RAYGRAPH_LIGHTS_TRIANGLE_LIGHT_GLSL
#define RAYGRAPH_LIGHTS_TRIANGLE_LIGHT_GLSL

#include "core/frame.glsl"
#include "core/warp.glsl"
#include "lights/light_types.glsl"

SHADING_BEGIN

// The map by solid angle is exact enough in float between these, in steradians, and where determinant and
// denominator, which have roundings of about 1e-7, have at least that sum of squares.
CONST float kMinTriangleSolidAngle = 3.0e-4f;
CONST float kMaxTriangleSolidAngle = 6.2f;
CONST float kMinTangentSquare = 1.0e-7f;

// A triangle as seen from a point: unit vectors to its corners, in the order in which v0 and v2 are the
// farthest apart, and the terms of the solid angle and its inversion. Where v0 and v2 are nearly opposite,
// those terms are small in proportion to `sum`: so they are made of it, and not of cosines near -1, which
// cancel.
struct SphericalTriangle {
    vec3 v0;
    vec3 v1;
    vec3 v2;
    vec3 sum;           // v0 + v2
    float determinant;  // |v0 . (v1 x v2)|
    float denominator;  // 1 + v0 . v1 + v1 . v2 + v2 . v0
    float g;            // 1 + v0 . v1
    float solidAngle;
    float nearest;  // distance of the nearest corner, in meters
    float tilt;     // cross(e1, e2) . unit vector to that corner: negative in front of the plane
};

// A. van Oosterom and J. Strackee 1983, "The Solid Angle of a Plane Triangle". The determinant is taken from
// the edges, which keeps its digits where the triangle is small or seen at a grazing angle.
INLINE SphericalTriangle SphericalTriangleFrom(LightRecord light, vec3 position) {
    vec3 a = light.p0 - position;
    vec3 b = a + light.e1;
    vec3 c = a + light.e2;
    float inverseA = inversesqrt(dot(a, a));
    float inverseB = inversesqrt(dot(b, b));
    float inverseC = inversesqrt(dot(c, c));
    a *= inverseA;
    b *= inverseB;
    c *= inverseC;
    SphericalTriangle t;
    // Of the nearest corner, which lies in the plane with the least rounding
    float inverseNearest = max(inverseA, max(inverseB, inverseC));
    vec3 toNearest = inverseA == inverseNearest ? a : (inverseB == inverseNearest ? b : c);
    t.nearest = 1.0f / inverseNearest;
    t.tilt = dot(cross(light.e1, light.e2), toNearest);
    t.determinant = abs(t.tilt * inverseB) * inverseC * (inverseA * t.nearest);

    float ab = dot(a, b);
    float bc = dot(b, c);
    float ca = dot(c, a);
    bool isAB = ab < bc && ab < ca;
    bool isBC = !isAB && bc < ca;
    t.v0 = isAB ? b : (isBC ? c : a);
    t.v1 = isAB ? c : (isBC ? a : b);
    t.v2 = isAB ? a : (isBC ? b : c);
    t.sum = t.v0 + t.v2;
    t.denominator = dot(t.sum, 0.5f * t.sum + t.v1);
    vec3 sum01 = t.v0 + t.v1;
    t.g = 0.5f * dot(sum01, sum01);
    t.solidAngle = 2.0f * atan(t.determinant, t.denominator);
    return t;
}

// Else by area, as where a corner is at the point itself (NaN).
INLINE bool IsSampledByDirection(SphericalTriangle t) { return t.solidAngle >= kMinTriangleSolidAngle; }

// Else uniformly in the solid angle. Only for what is sampled by direction.
INLINE bool IsSampledByHemisphere(SphericalTriangle t) {
    return t.solidAngle > kMaxTriangleSolidAngle ||
           t.determinant * t.determinant + t.denominator * t.denominator < kMinTangentSquare;
}

// J. Arvo 1995, "Stratified Sampling of Spherical Triangles", with the cut through the triangle found as in
// C. Peters 2021, "BRDF Importance Sampling for Polygonal Lights": u.x chooses v, on the arc from v0 to v2,
// such that (v0, v1, v) has the share u.x of the solid angle; u.y a point of the arc from v1 to v.
INLINE vec3 SampleSphericalTriangle(SphericalTriangle t, vec2 u) {
    vec2 cs = CosSinTurn(u.x * t.solidAngle * kInv4Pi);  // of half the cut's solid angle
    vec3 halfway = (cs.x * t.determinant - cs.y * t.denominator) * t.v0 + cs.y * t.g * t.sum;
    vec3 v = -t.v0 + (2.0f * dot(t.v0, halfway) / dot(halfway, halfway)) * halfway;
    vec3 across = v - t.v1;
    float height = 0.5f * dot(across, across);  // 1 - cos of the arc
    vec3 tangent = across + height * t.v1;
    float square = dot(tangent, tangent);
    if (!(square > 0.0f)) return t.v1;
    float h = u.y * height;
    return (1.0f - h) * t.v1 + sqrt(h * (2.0f - h) / square) * tangent;
}

// `side` is positive in front of the plane of the triangle's vertices, as they are wound.
INLINE bool EmitsTowards(LightRecord light, float side) {
    if ((light.flags & kLightMirrored) != 0u) side = -side;
    return side > 0.0f || (side < 0.0f && (light.flags & kLightDoubleSided) != 0u);
}

// The unit normal on the side of the point.
INLINE vec3 FacingNormal(LightRecord light, SphericalTriangle t) {
    vec3 normal = UnitOr(cross(light.e1, light.e2), vec3(0.0f, 0.0f, 1.0f));
    return t.tilt < 0.0f ? normal : -normal;
}

// Density per solid angle of a direction that meets the triangle at `distance`.
INLINE float TriangleDensity(SphericalTriangle t, float distance) {
    if (!IsSampledByDirection(t)) return 2.0f * distance * distance / abs(t.tilt * (t.nearest / distance));
    return IsSampledByHemisphere(t) ? kInv2Pi : 1.0f / t.solidAngle;
}

// Of a direction that a ray found; 0 where the triangle does not emit.
INLINE float TriangleLightPDF(LightRecord light, vec3 position, float distance) {
    SphericalTriangle t = SphericalTriangleFrom(light, position);
    return EmitsTowards(light, -t.tilt) ? TriangleDensity(t, distance) : 0.0f;
}

struct TrianglePoint {
    vec2 barycentrics;  // weights of vertices 1 and 2
    vec3 wi;            // unit length
    float distance;     // not above 0: a miss
};

// Only for a triangle that emits towards the point.
INLINE TrianglePoint SampleTriangleLight(LightRecord light, SphericalTriangle t, vec3 position, vec2 u) {
    TrianglePoint result;
    vec3 a = light.p0 - position;
    if (!IsSampledByDirection(t)) {
        vec3 weights = SampleUniformTriangle(u);
        result.barycentrics = vec2(weights.y, weights.z);
        vec3 way = a + weights.y * light.e1 + weights.z * light.e2;
        result.distance = length(way);
        result.wi = way / result.distance;
        return result;
    }
    vec3 normal = cross(light.e1, light.e2);
    bool isByHemisphere = IsSampledByHemisphere(t);
    if (isByHemisphere)
        result.wi = FromLocal(FrameFromZ(-FacingNormal(light, t)), SampleUniformHemisphere(u));
    else
        result.wi = SampleSphericalTriangle(t, u);
    // Moeller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection"
    float facing = dot(result.wi, normal);
    float b1 = dot(result.wi, cross(light.e2, a)) / facing;
    float b2 = dot(result.wi, cross(a, light.e1)) / facing;
    result.distance = t.nearest * (t.tilt / facing);
    if (isByHemisphere) {
        float b0 = dot(result.wi, cross(a + light.e1, a + light.e2)) / facing;
        if (!(b0 >= 0.0f && b1 >= 0.0f && b2 >= 0.0f)) result.distance = 0.0f;
    }
    b1 = clamp(b1, 0.0f, 1.0f);
    result.barycentrics = vec2(b1, clamp(b2, 0.0f, 1.0f - b1));
    return result;
}

SHADING_END

#endif

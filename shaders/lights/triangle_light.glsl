// Directions to a triangle: uniform in its solid angle, or by area where that angle is too small, too large
// or too inexact. Point and triangle decide which, so that the density of a hit is that of a sample.
#ifndef RAYGRAPH_LIGHTS_TRIANGLE_LIGHT_GLSL
#define RAYGRAPH_LIGHTS_TRIANGLE_LIGHT_GLSL

#include "core/warp.glsl"
#include "lights/light_types.glsl"

SHADING_BEGIN

// The map by solid angle is exact enough in float between these, in steradians.
CONST float kMinTriangleSolidAngle = 3.0e-4f;
CONST float kMaxTriangleSolidAngle = 6.2f;
// Squares of the tangent's two parts have an error of about 1e-14 times the sum of the denominator's terms.
// Where these cancel, that is at most twice the sum of two of them, gained and lost: this times those leaves
// the angle a relative error of some 1e-4. Elsewhere the denominator itself is large enough. (All three would
// be one more value to keep: that costs shaders on GPUs registers, and 7 % of their speed.)
CONST float kMinTangentSquare = 4.0e-7f;

// Describes a triangle as seen from a point.
struct SphericalTriangle {
    vec3 v0;  // unit vectors to its corners
    vec3 v1;
    vec3 v2;
    float reach;    // (1 + v0 . v1) / length of (determinant, denominator): its angle is half the solid angle
    float volume;   // (p0 - point) . cross(e1, e2), in cubic meters: negative in front of the plane
    float density;  // 1 / solid angle; 0 where the triangle is sampled by area
};

// A. van Oosterom and J. Strackee 1983, "The Solid Angle of a Plane Triangle". The determinant is taken from
// the edges, which keeps its digits where the triangle is small or seen at a grazing angle. The denominator,
// 1 + v0 . v1 + v1 . v2 + v2 . v0, cancels where corners are seen in nearly opposite directions: sums and
// differences of corners take the place of cosines, so that each term keeps its digits.
INLINE SphericalTriangle SphericalTriangleFrom(LightRecord light, vec3 position) {
    vec3 a = light.p0 - position;
    vec3 b = a + light.e1;
    vec3 c = a + light.e2;
    float inverseA = inversesqrt(dot(a, a));
    float inverseB = inversesqrt(dot(b, b));
    float inverseC = inversesqrt(dot(c, c));
    SphericalTriangle t;
    // The nearest corner has the least rounding, and so lies nearest to the plane.
    float inverseNearest = max(inverseA, max(inverseB, inverseC));
    vec3 nearest = inverseA == inverseNearest ? a : (inverseB == inverseNearest ? b : c);
    t.volume = dot(cross(light.e1, light.e2), nearest);
    float determinant = abs(t.volume * inverseA) * inverseB * inverseC;

    t.v0 = a * inverseA;
    t.v1 = b * inverseB;
    t.v2 = c * inverseC;
    vec3 sum02 = t.v0 + t.v2;
    vec3 sum01 = t.v0 + t.v1;
    vec3 difference12 = t.v1 - t.v2;
    float gained = 0.5f * dot(sum01, sum01);
    float lost = 0.5f * dot(difference12, difference12);
    float denominator = 0.5f * dot(sum02, sum02) + (gained - lost);
    float square = determinant * determinant + denominator * denominator;
    float solidAngle = 2.0f * atan(determinant, denominator);
    // All comparisons fail where a corner is at the point itself (NaN).
    bool isExact = solidAngle >= kMinTriangleSolidAngle && solidAngle <= kMaxTriangleSolidAngle &&
                   square >= kMinTangentSquare * (gained + lost);
    t.reach = gained * inversesqrt(square);
    t.density = isExact ? 1.0f / solidAngle : 0.0f;
    return t;
}

// J. Arvo 1995, "Stratified Sampling of Spherical Triangles", with the cut through the triangle found as in
// C. Peters 2021, "BRDF Importance Sampling for Polygonal Lights": u.x chooses v, on the arc from v0 to v2,
// such that (v0, v1, v) has the share u.x of the solid angle; u.y a point of the arc from v1 to v. Peters'
// terms in v0 are written as the sine of what is left of half the solid angle, which does not cancel.
INLINE vec3 SampleSphericalTriangle(SphericalTriangle t, vec2 u) {
    float turn = kInv4Pi / t.density;  // half the solid angle, in turns
    float left = CosSinTurn((1.0f - u.x) * turn).y;
    float right = CosSinTurn(u.x * turn).y * t.reach;
    vec3 halfway = left * t.v0 + right * (t.v0 + t.v2);
    vec3 v = -t.v0 + (2.0f * dot(t.v0, halfway) / dot(halfway, halfway)) * halfway;
    vec3 across = v - t.v1;
    float height = 0.5f * dot(across, across);  // 1 - cos of the arc
    vec3 tangent = across + height * t.v1;
    tangent -= dot(tangent, t.v1) * t.v1;  // what rounding left, where v and v1 are nearly opposite
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

// Returns the unit normal on the side of the point.
INLINE vec3 FacingNormal(LightRecord light, SphericalTriangle t) {
    vec3 normal = UnitOr(cross(light.e1, light.e2), vec3(0.0f, 0.0f, 1.0f));
    return t.volume < 0.0f ? normal : -normal;
}

// Returns the density per solid angle of a direction that meets the triangle at `distance`. By area it is the
// squared distance over area and cosine, which are those of the volume.
INLINE float TriangleDensity(SphericalTriangle t, float distance) {
    if (t.density > 0.0f) return t.density;
    return 2.0f * distance * distance / abs(t.volume / distance);
}

// Returns the density of a direction in which a ray met the triangle; 0 where the triangle does not emit.
INLINE float TriangleLightPDF(LightRecord light, vec3 position, float distance) {
    SphericalTriangle t = SphericalTriangleFrom(light, position);
    return EmitsTowards(light, -t.volume) ? TriangleDensity(t, distance) : 0.0f;
}

struct TrianglePoint {
    vec2 barycentrics;  // weights of vertices 1 and 2
    vec3 wi;            // unit length
    float distance;     // in meters
    float pdf;          // per solid angle; 0: no sample, by rounding
};

// `t` must be a triangle that emits towards the point.
INLINE TrianglePoint SampleTriangleLight(LightRecord light, SphericalTriangle t, vec3 position, vec2 u) {
    TrianglePoint result;
    vec3 a = light.p0 - position;
    if (t.density > 0.0f) {
        result.wi = SampleSphericalTriangle(t, u);
        // Follows Moeller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection"
        float facing = 1.0f / dot(result.wi, cross(light.e1, light.e2));
        float b1 = clamp(dot(result.wi, cross(light.e2, a)) * facing, 0.0f, 1.0f);
        float b2 = clamp(dot(result.wi, cross(a, light.e1)) * facing, 0.0f, 1.0f - b1);
        result.barycentrics = vec2(b1, b2);
        // The distance is that of the place: at a grazing angle, the direction may meet the plane elsewhere.
        result.distance = length(a + b1 * light.e1 + b2 * light.e2);
        result.pdf = t.volume * facing > 0.0f ? t.density : 0.0f;
    } else {
        vec3 weights = SampleUniformTriangle(u);
        result.barycentrics = vec2(weights.y, weights.z);
        vec3 way = a + weights.y * light.e1 + weights.z * light.e2;
        result.distance = length(way);
        result.wi = way / result.distance;
        result.pdf = result.distance > 0.0f ? TriangleDensity(t, result.distance) : 0.0f;
    }
    return result;
}

SHADING_END

#endif

// Shading normals bent so that they always face the viewer.
#ifndef RAYGRAPH_CORE_SHADING_NORMAL_GLSL
#define RAYGRAPH_CORE_SHADING_NORMAL_GLSL

#include "core/math.glsl"

SHADING_BEGIN

// A shading normal, bent just enough for wo to be above it and for the mirror direction of wo about it to be
// above the surface; else a mirror or a normal map would reflect the inside of the body, which is black. ng
// and wo are on one side; all directions of unit length. After Keller, Waechter, Raab et al. 2017, "The Iray
// Light Transport Simulation and Rendering System", section A.3.
INLINE vec3 AdaptShadingNormal(vec3 ns, vec3 ng, vec3 wo) {
    // The least height of the mirror direction; a grazing viewer's own height, so that ng itself is legal
    float least = min(0.9f * dot(wo, ng), 0.01f);
    float facing = max(dot(ns, wo), 0.0f);  // facing away: as if seen edge-on
    vec3 mirrored = 2.0f * facing * ns - wo;
    float height = dot(mirrored, ng);
    if (facing > 0.0f && height >= least) return ns;
    mirrored += (least - height) * ng;
    float square = dot(mirrored, mirrored);
    if (!(square > 0.0f)) return ng;
    vec3 halfway = wo + mirrored * inversesqrt(square);
    float halfwaySquare = dot(halfway, halfway);
    // Nearly opposite directions: the sum is only rounding
    return halfwaySquare > 1e-6f ? halfway * inversesqrt(halfwaySquare) : ng;
}

// `normal` may have any length; a zero normal gives no offset.
INLINE vec3 TangentPlaneOffset(vec3 p, vec3 vertex, vec3 normal) {
    normal = UnitOr(normal, vec3(0.0f));
    return max(dot(vertex - p, normal), 0.0f) * normal;
}

// The offset that lifts a point of a triangle onto the convex surface that its vertex normals describe:
// to the mean of its projections onto the tangent planes at the vertices p0, p1, p2, of those planes
// that lie above it. `weights` are its barycentrics, the normals of any length. Zero at the vertices, on
// flat surfaces and concave ones. Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II,
// chapter 4.
INLINE vec3 ShadowTerminatorOffset(vec3 weights, vec3 p, vec3 p0, vec3 p1, vec3 p2, vec3 n0, vec3 n1,
                                   vec3 n2) {
    return weights.x * TangentPlaneOffset(p, p0, n0) + weights.y * TangentPlaneOffset(p, p1, n1) +
           weights.z * TangentPlaneOffset(p, p2, n2);
}

SHADING_END

#endif

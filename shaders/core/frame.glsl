// Frames of a surface: orthonormal ones, in whose local coordinates the normal is +z; tangent frames of
// maps; and shading normals that face the viewer.
#ifndef RAYGRAPH_CORE_FRAME_GLSL
#define RAYGRAPH_CORE_FRAME_GLSL

#include "core/glue.h"
#include "core/math.glsl"

SHADING_BEGIN

// x, y, z are of unit length, orthogonal and right-handed: cross(x, y) = z.
struct Frame {
    vec3 x;
    vec3 y;
    vec3 z;
};

// Returns the frame about a unit vector; continuous except where z.z changes sign. Duff et al. 2017,
// "Building an Orthonormal Basis, Revisited", JCGT 6(1). No special case: 1 + |z.z| is at least 1.
INLINE Frame FrameFromZ(vec3 z) {
    float s = z.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + z.z);
    float b = z.x * z.y * a;
    Frame frame;
    frame.x = vec3(1.0f + s * z.x * z.x * a, s * b, -s * z.x);
    frame.y = vec3(b, s + z.y * z.y * a, -z.y);
    frame.z = z;
    return frame;
}

// Returns a frame whose x axis is as near as possible to a direction, of any length; FrameFromZ(z) where that
// direction has no component in the plane.
INLINE Frame FrameFromZX(vec3 z, vec3 x) {
    vec3 along = x - dot(x, z) * z;
    float square = dot(along, along);
    if (!(square > 1e-10f * dot(x, x))) return FrameFromZ(z);
    Frame frame;
    frame.x = along * inversesqrt(square);
    frame.y = cross(z, frame.x);
    frame.z = z;
    return frame;
}

INLINE vec3 ToLocal(Frame frame, vec3 v) { return vec3(dot(v, frame.x), dot(v, frame.y), dot(v, frame.z)); }

INLINE vec3 FromLocal(Frame frame, vec3 v) { return v.x * frame.x + v.y * frame.y + v.z * frame.z; }

// --- Tangent frames in which maps whose texels are directions are read ---
// A frame is a unit tangent along which the map's u grows, perpendicular to the normal, and the sign w with
// which cross(normal, tangent) * w points to the image's top, as in glTF's TANGENT.

// Returns the frame of a triangle with the edges e1 and e2 from its first vertex, along which the texture
// coordinates change by uv1 and uv2: the derivative of the position by u, projected into the plane
// perpendicular to the unit vector n. It equals MikkTSpace's before that averages over the triangles around a
// vertex: the sign comes from the coordinates alone, even where n opposes the triangle's winding, so that a
// map is read alike with stored tangents and without. w is 0 where the coordinates or the triangle are
// degenerate.
INLINE vec4 TriangleTangent(vec3 e1, vec3 e2, vec2 uv1, vec2 uv2, vec3 n) {
    float area = uv1.x * uv2.y - uv1.y * uv2.x;
    vec3 along = uv2.y * e1 - uv1.y * e2;
    vec3 sizes = abs(along);
    float size = max(sizes.x, max(sizes.y, sizes.z));
    if (area == 0.0f || !(size > 0.0f)) return vec4(0.0f);
    along /= size;  // keeps its square in the range of float, whatever the unit of the coordinates
    along -= dot(along, n) * n;
    float square = dot(along, along);
    if (!(square > 1e-12f)) return vec4(0.0f);
    float side = area > 0.0f ? 1.0f : -1.0f;  // v points downwards, so a positive area mirrors the image
    along *= side * inversesqrt(square);
    return vec4(along.x, along.y, along.z, -side);
}

// Turns `tangent` about the unit vector n, and mirrors it, as a triangle's frame `to` is turned and mirrored
// relative to its frame `from`. So tangents that are smooth over a mesh stay smooth when the map's
// coordinates are transformed.
INLINE vec4 TurnTangent(vec4 tangent, vec4 from, vec4 to, vec3 n) {
    vec3 t = vec3(tangent.x, tangent.y, tangent.z);
    vec3 a = vec3(from.x, from.y, from.z);
    vec3 b = vec3(to.x, to.y, to.z);
    vec3 turned = dot(a, b) * t + dot(n, cross(a, b)) * cross(n, t);
    return vec4(turned.x, turned.y, turned.z, tangent.w * from.w * to.w);
}

// Returns a shading normal that faces the viewer: bent just enough for wo to be above it and for the mirror
// direction of wo about it to be above the surface; else a mirror or a normal map would reflect the inside
// of the body, which is black. ng and wo are on one side; all directions of unit length. After Keller,
// Waechter, Raab et al. 2017, "The Iray Light Transport Simulation and Rendering System", section A.3.
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
    // For nearly opposite directions, the sum is only rounding
    return halfwaySquare > 1e-6f ? halfway * inversesqrt(halfwaySquare) : ng;
}

// `normal` may have any length; a zero normal gives no offset.
INLINE vec3 TangentPlaneOffset(vec3 p, vec3 vertex, vec3 normal) {
    normal = UnitOr(normal, vec3(0.0f));
    return max(dot(vertex - p, normal), 0.0f) * normal;
}

// Returns the offset that lifts a point of a triangle onto the convex surface that its vertex normals
// describe: to the mean of its projections onto the tangent planes at the vertices p0, p1, p2, of those
// planes that lie above it. `weights` are its barycentrics, the normals of any length. Zero at the vertices,
// on flat surfaces and concave ones. Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II,
// chapter 4.
INLINE vec3 ShadowTerminatorOffset(vec3 weights, vec3 p, vec3 p0, vec3 p1, vec3 p2, vec3 n0, vec3 n1,
                                   vec3 n2) {
    return weights.x * TangentPlaneOffset(p, p0, n0) + weights.y * TangentPlaneOffset(p, p1, n1) +
           weights.z * TangentPlaneOffset(p, p2, n2);
}

SHADING_END

#endif

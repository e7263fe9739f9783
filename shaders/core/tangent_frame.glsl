// Tangent frames in which maps whose texels are directions are read. A frame is a unit tangent along which
// the map's u grows, perpendicular to the normal, and the sign w with which cross(normal, tangent) * w points
// to the image's top, as in glTF's TANGENT.
#ifndef RAYGRAPH_CORE_TANGENT_FRAME_GLSL
#define RAYGRAPH_CORE_TANGENT_FRAME_GLSL

#include "core/glue.h"

SHADING_BEGIN

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

SHADING_END

#endif

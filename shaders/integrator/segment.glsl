// The length of a path's segment, from surface to surface, as media take it.
//
// The distance along a ray does not do: the ray starts off its surface, at a place that is rounded to steps
// of the world's coordinates, which far from their origin may be as large as a pane is thick. Within an
// instance, places are known as well as its vertices are.
#ifndef RAYGRAPH_INTEGRATOR_SEGMENT_GLSL
#define RAYGRAPH_INTEGRATOR_SEGMENT_GLSL

#include "scene/ray.glsl"

SHADING_BEGIN

// Where a segment starts. Its place is the sum of the first two.
struct SegmentStart {
    vec3 instanceOrigin;
    vec3 fromInstance;
    vec3 normal;  // unit length, of the surface; 0: at the camera
};

INLINE SegmentStart StartAtCamera() {
    SegmentStart start;
    start.instanceOrigin = vec3(0.0f);
    start.fromInstance = vec3(0.0f);
    start.normal = vec3(0.0f);
    return start;
}

INLINE SegmentStart StartAtSurface(SurfaceInteraction surface) {
    SegmentStart start;
    start.instanceOrigin = surface.instanceOrigin;
    start.fromInstance = surface.fromInstance;
    start.normal = surface.geometricNormal;
    return start;
}

CONST float kGrazing = 0.1f;  // cosine

// From the plane of the surface where the segment starts to where it ends, along the ray's direction.
// `distance` is the ray's own.
INLINE float SegmentLength(SegmentStart start, SurfaceInteraction end, Ray ray, float distance) {
    if (dot(start.normal, start.normal) == 0.0f) return distance;
    vec3 way = (end.instanceOrigin - start.instanceOrigin) + (end.fromInstance - start.fromInstance);
    float slope = dot(ray.direction, start.normal);
    // A line that is nearly in the plane has no good intersection with it
    return abs(slope) < kGrazing ? length(way) : max(dot(way, start.normal) / slope, 0.0f);
}

SHADING_END

#endif

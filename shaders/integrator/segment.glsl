// The length of a path's segment, from surface to surface, for absorption in media.
//
// The distance along the ray is not precise enough: the ray starts off its surface, at a position that is
// rounded to steps of the world's coordinates, which far from their origin may be as large as a pane is
// thick. Within an instance, positions are as precise as its vertices.
#ifndef RAYGRAPH_INTEGRATOR_SEGMENT_GLSL
#define RAYGRAPH_INTEGRATOR_SEGMENT_GLSL

#include "scene/ray.glsl"

SHADING_BEGIN

// Holds the plane of the surface where a segment starts, as seen from the origin of the segment's ray.
struct SegmentStart {
    vec3 normal;   // unit length; 0: at the camera
    float height;  // height of the plane above the ray's origin, along the normal
};

INLINE SegmentStart StartAtCamera() {
    SegmentStart start;
    start.normal = vec3(0.0f);
    start.height = 0.0f;
    return start;
}

// Returns the vector from the world-space point `origin`, which is near the surface, to the surface. The two
// large terms are subtracted first: the difference of floats this close has no rounding.
INLINE vec3 VectorToSurface(SurfaceInteraction surface, vec3 origin) {
    return (surface.instanceOrigin - origin) + surface.fromInstance;
}

INLINE SegmentStart StartAtSurface(SurfaceInteraction surface, vec3 rayOrigin) {
    SegmentStart start;
    start.normal = surface.geometricNormal;
    start.height = dot(VectorToSurface(surface, rayOrigin), surface.geometricNormal);
    return start;
}

CONST float kGrazing = 0.1f;  // cosine

// Returns the distance of the ray's origin from that plane, along its direction.
INLINE float OriginOffset(SegmentStart start, Ray ray) {
    float slope = dot(ray.direction, start.normal);
    return abs(slope) < kGrazing ? 0.0f : -start.height / slope;
}

// Returns the length along the ray's direction from the plane of the surface where the segment starts to its
// end. `distance` is the ray's own.
INLINE float SegmentLength(SegmentStart start, SurfaceInteraction end, Ray ray, float distance) {
    if (dot(start.normal, start.normal) == 0.0f) return distance;
    vec3 way = VectorToSurface(end, ray.origin);
    float slope = dot(ray.direction, start.normal);
    // A line that is nearly in the plane has no good intersection with it
    return abs(slope) < kGrazing ? length(way) : max((dot(way, start.normal) - start.height) / slope, 0.0f);
}

SHADING_END

#endif

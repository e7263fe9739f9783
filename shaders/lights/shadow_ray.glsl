// The ray that finds out whether a surface sees what a light sample is of. Shared by the path tracer and the
// raster view, whose random numbers for it are of the same dimensions, so that their pictures agree.
#ifndef RAYGRAPH_LIGHTS_SHADOW_RAY_GLSL
#define RAYGRAPH_LIGHTS_SHADOW_RAY_GLSL

#include "core/ray_offset.glsl"
#include "lights/light_types.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

CONST uint kCameraDimensions = 4u;    // 0, 1: film; 2, 3: lens. The first bounce begins after them
// part of the segment to a light that must be unoccluded, less rounding
CONST float kShadowRayFraction = 0.99999f;

// Returns a point off the surface, on the side of its geometric normal if `side` > 0.
INLINE vec3 OffsetOriginToSide(SurfaceInteraction surface, float side) {
    return OffsetRayOrigin(surface.position,
                           side > 0.0f ? surface.geometricNormal : -surface.geometricNormal,
                           surface.clearance);
}

// `distance` becomes the length of the ray that must be unoccluded.
INLINE Ray ShadowRayFrom(vec3 origin, LightSample light, OUT(float) distance) {
    Ray ray;
    ray.origin = origin;
    ray.direction = light.wi;
    distance = kInfinity;
    if (light.distance < kInfinity) {
        // The ray goes from one offset point to another: however close the surfaces are, it hits neither.
        vec3 way = light.target - ray.origin;
        float reach = max(length(way), 1e-20f);
        ray.direction = way / reach;
        distance = reach * kShadowRayFraction;
    }
    return ray;
}

INLINE Ray ShadowRayTo(SurfaceInteraction surface, LightSample light, OUT(float) distance) {
    return ShadowRayFrom(OffsetOriginToSide(surface, dot(light.wi, surface.geometricNormal)), light,
                         distance);
}

SHADING_END

#endif

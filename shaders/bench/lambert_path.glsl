// One path in two forms: traced by a loop in ray generation, as Trace does it, and by recursion from the
// closest hit. Surfaces are Lambert's, of their base color and flat; the environment has one radiance; no
// light is sampled, round primitives are not hit, and only the depth ends a path early. Both forms share this
// source, so that they differ only in where the next ray is traced, and in the consequences.
#ifndef RAYGRAPH_BENCH_LAMBERT_PATH_GLSL
#define RAYGRAPH_BENCH_LAMBERT_PATH_GLSL

#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "core/rng.glsl"
#include "core/warp.glsl"
#include "scene/bindings.glsl"
#include "scene/camera.glsl"
#include "scene/surface.glsl"
#include "shared/lambert_path.h"

#define RAY_MASK kMaskTriangles  // selects the mask in scene/trace_rays.glsl

// Draws dimensions 0 to 3 of the sample; each bounce draws the next two.
Ray StartLambertPath(out Sampler rng) {
    uvec2 pixel = gl_LaunchIDEXT.xy;
    rng = StartPixelSample(pixel, parameters.value.sampleIndex, parameters.value.seed);
    vec2 film = (vec2(pixel) + Get2D(rng)) / vec2(gl_LaunchSizeEXT.xy);
    return CameraRay(parameters.value.camera, film, Get2D(rng));
}

// A path ends at a surface after `depth` bounces: it only emits.
bool EndsLambertPath(SurfaceInteraction surface, uint depth) {
    return depth >= kLambertBounces || (surface.material.flags & kMaterialUnlit) != 0u;
}

// Returns the next ray, sampled by the cosine: its radiance is weighted by the base color.
Ray ScatterLambert(SurfaceInteraction surface, inout Sampler rng) {
    Ray ray;
    ray.origin = OffsetRayOrigin(surface.position, surface.geometricNormal, surface.clearance);
    ray.direction = FromLocal(FrameFromZ(surface.geometricNormal), SampleCosineHemisphere(Get2D(rng)));
    return ray;
}

#endif

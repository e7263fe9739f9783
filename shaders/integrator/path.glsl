// The path integrator: an iterative loop that knows no binding. It talks to the scene over a small bridge,
// which the including file declares beforehand: the device's is scene/*.glsl, the tests' own is a few
// analytic shapes.
//
//     Hit Intersect(Ray ray)                                the nearest surface
//     SurfaceInteraction SurfaceAt(Hit hit, Ray ray)        what is there
//     vec3 EnvironmentRadiance(vec3 direction)              what arrives where nothing is
//
// Sample dimensions: 0 and 1 are the film position; each bounce has kBounceDimensions of its own, so that the
// same decision uses the same dimension on every path.
#ifndef RAYGRAPH_INTEGRATOR_PATH_GLSL
#define RAYGRAPH_INTEGRATOR_PATH_GLSL

#include "bxdf/diffuse.glsl"
#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "core/rng.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

CONST uint kFilmDimensions = 2u;
CONST uint kBounceDimensions = 3u;  // 0, 1: direction; 2: roulette
CONST float kMaxSurvival = 0.99f;   // even a path that loses nothing ends some day

struct PathSettings {
    uint maxDepth;       // bounces
    uint rouletteStart;  // first bounce that roulette may end
};

// A path on its way: made by StartPath, moved on by one ray with ExtendPath until that returns false.
struct PathState {
    Ray ray;  // the next one
    Sampler rng;
    vec3 radiance;    // collected so far: the estimate, once the path has ended
    vec3 throughput;  // share of the light at the path's end that reaches the camera
    uint depth;       // bounces so far
    float alpha;      // 1: the camera ray hit a surface
};

INLINE PathState StartPath(Ray ray, Sampler rng) {
    PathState path;
    path.ray = ray;
    path.rng = rng;
    path.radiance = vec3(0.0f);
    path.throughput = vec3(1.0f);
    path.depth = 0u;
    path.alpha = 0.0f;
    return path;
}

// Traces the path's next ray. False: the path has ended, after depth + 1 rays, and path.radiance is an
// unbiased estimate of the radiance along its first ray (unless maxDepth cuts it).
INLINE bool ExtendPath(INOUT(PathState) path, PathSettings settings) {
    Hit hit = Intersect(path.ray);
    if (!IsHit(hit)) {
        path.radiance += path.throughput * EnvironmentRadiance(path.ray.direction);
        return false;
    }
    path.alpha = 1.0f;
    SurfaceInteraction surface = SurfaceAt(hit, path.ray);
    path.radiance += path.throughput * surface.emission;
    if (path.depth >= settings.maxDepth) return false;

    // Sample the BSDF for the next direction
    path.rng.dimension = kFilmDimensions + path.depth * kBounceDimensions;
    DiffuseBxDF lobe;
    lobe.albedo = surface.albedo;
    Frame frame = FrameFromZ(surface.shadingNormal);
    BSDFSample scattered = Sample_f(lobe, ToLocal(frame, -path.ray.direction), 0.0f, Get2D(path.rng));
    if (scattered.pdf == 0.0f) return false;
    path.throughput *= scattered.f * (abs(scattered.wi.z) / scattered.pdf);
    path.ray.direction = FromLocal(frame, scattered.wi);
    // The shading hemisphere reaches below the surface: no light passes there
    if (dot(path.ray.direction, surface.geometricNormal) <= 0.0f) return false;
    path.ray.origin = OffsetRayOrigin(surface.position, surface.geometricNormal);

    // End the path with a probability that falls with what it carries
    if (path.depth + 1u >= settings.rouletteStart) {
        float survival = min(MaxComponent(path.throughput), kMaxSurvival);
        if (!(Get1D(path.rng) < survival)) return false;  // ends a path of NaN too
        path.throughput /= survival;
    }
    path.depth++;
    return true;
}

SHADING_END

#endif

// The path integrator: an iterative loop that knows no binding. It talks to the scene over a small bridge, which the
// including file declares beforehand: the device's is scene/*.glsl, the tests' own is a few analytic shapes.
//
//     Hit Intersect(Ray ray)                                the nearest surface
//     SurfaceInteraction SurfaceAt(Hit hit, Ray ray)        what is there
//     vec3 EnvironmentRadiance(vec3 direction)              what arrives where nothing is
//
// Sample dimensions: 0 and 1 are the film position; each bounce has kBounceDimensions of its own, so that the same
// decision uses the same dimension on every path.
#ifndef RAYGRAPH_INTEGRATOR_PATH_GLSL
#define RAYGRAPH_INTEGRATOR_PATH_GLSL

#include "bxdf/diffuse.glsl"
#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "core/rng.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

CONST uint kFilmDimensions = 2u;
CONST uint kBounceDimensions = 3u;   // 0, 1: direction; 2: roulette
CONST float kMaxSurvival = 0.99f;    // even a path that loses nothing ends some day

struct PathSettings {
    uint maxDepth;       // bounces
    uint rouletteStart;  // first bounce that roulette may end
};

struct PathSample {
    vec3 radiance;
    float alpha;    // 1: the camera ray hit a surface
    uint rayCount;  // rays traced
};

// One unbiased estimate of the radiance that arrives along -ray.direction (unless maxDepth cuts it).
INLINE PathSample SamplePath(Ray ray, Sampler rng, PathSettings settings) {
    PathSample result;
    result.radiance = vec3(0.0f);
    result.alpha = 0.0f;
    result.rayCount = 0u;
    vec3 throughput = vec3(1.0f);
    for (uint depth = 0u;; depth++) {
        Hit hit = Intersect(ray);
        result.rayCount++;
        if (!IsHit(hit)) {
            result.radiance += throughput * EnvironmentRadiance(ray.direction);
            break;
        }
        result.alpha = 1.0f;
        SurfaceInteraction surface = SurfaceAt(hit, ray);
        result.radiance += throughput * surface.emission;
        if (depth >= settings.maxDepth) break;

        // Sample the BSDF for the next direction
        rng.dimension = kFilmDimensions + depth * kBounceDimensions;
        DiffuseBxDF lobe;
        lobe.albedo = surface.albedo;
        Frame frame = FrameFromZ(surface.shadingNormal);
        BSDFSample scattered = Sample_f(lobe, ToLocal(frame, -ray.direction), 0.0f, Get2D(rng));
        if (scattered.pdf == 0.0f) break;
        throughput *= scattered.f * (abs(scattered.wi.z) / scattered.pdf);
        ray.direction = FromLocal(frame, scattered.wi);
        // The shading hemisphere reaches below the surface: no light passes there
        if (dot(ray.direction, surface.geometricNormal) <= 0.0f) break;
        ray.origin = OffsetRayOrigin(surface.position, surface.geometricNormal);

        // End the path with a probability that falls with what it carries
        float survival = min(MaxComponent(throughput), kMaxSurvival);
        if (depth + 1u >= settings.rouletteStart) {
            if (Get1D(rng) >= survival) break;
            throughput /= survival;
        }
    }
    return result;
}

SHADING_END

#endif

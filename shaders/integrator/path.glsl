// The path integrator: an iterative loop without resource bindings. It accesses the scene through a small
// bridge, which the including file declares beforehand: scene/*.glsl on the device, a few analytic shapes in
// the tests.
//
//     Hit Intersect(Ray ray, uint alphaSeed)                    the nearest surface
//     vec3 UnblockedShare(Ray ray, float distance, float ior, uint alphaSeed)
//         share of light that comes along the ray from there: 0 if anything opaque is nearer, less than 1 if
//         smooth thin walls are. `ior` is of the medium that the ray starts in. A distance of 0 is legal
//     SurfaceInteraction SurfaceAt(Hit hit, Ray ray)            what is there
//     Medium MediumAt(uint material)                            what the surfaces of a material enclose
//     void AddToGroup(vec3 value, uint light)                   what a light (kNoLight: a surface that is
//         none) brought to the camera; asked for if LIGHT_GROUPS is defined
//     and those of lights/lights.glsl and bxdf/energy.glsl
//
// Each vertex adds the light it emits and, by sampling the lights, the light it scatters; multiple importance
// sampling weights both ways to find a light (Veach 1997, chapter 9). Unbiased, except for maxDepth,
// clampIndirect and regularize, which are off by default.
//
// Light that passes straight through a smooth thin wall has not been scattered: to both ways of finding a
// light the wall is a hole for a share of the light, and the remaining paths sample its other lobes.
//
// Sample dimensions: 0 to 3 are the camera's; each bounce has kBounceDimensions of its own, so that the same
// decision uses the same dimension on every path. Straight crossings have dimensions by the ray's number, and
// the path's wavelength has one.
#ifndef RAYGRAPH_INTEGRATOR_PATH_GLSL
#define RAYGRAPH_INTEGRATOR_PATH_GLSL

#include "bxdf/bsdf.glsl"
#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "core/rng.glsl"
#include "core/trace_options.glsl"
#include "integrator/media.glsl"
#include "integrator/path_parts.glsl"
#include "integrator/segment.glsl"
#include "lights/lights.glsl"
#include "lights/shadow_ray.glsl"
#include "scene/ray.glsl"
#include "shared/scene_records.h"

SHADING_BEGIN

// 0: which light; 1, 2: where on it; 3: which lobe; 4, 5: direction; 6: roulette
CONST uint kBounceDimensions = 7u;
CONST uint kStraightDimensions = 0x40000000u;
CONST uint kWavelengthDimension = 0x3fffffffu;
CONST float kMaxSurvival = 0.99f;  // even a path without losses must end
CONST uint kMaxRays = 4096u;       // of one path: a guard against rooms that cannot be left

struct PathSettings {
    uint maxDepth;        // bounces
    uint rouletteStart;   // first bounce at which roulette may end the path
    float survival;       // of a bounce, for roulettes of constant probability
    uint frameDepth;      // bounces of this sample, for Roulette::Frame
    float clampIndirect;  // largest component of one contribution of light scattered twice or more often
    float regularize;     // minimum alpha of the BSDFs after the first bounce
};

// The state of a path: created by StartPath, extended by one ray with ExtendPath until that returns false.
struct PathState {
    Ray ray;  // the next one
    Sampler rng;
    vec3 radiance;         // collected so far: the estimate, once the path has ended
    vec3 throughput;       // share of the light at the path's end that reaches the camera
    float wavelength;      // nm; kNoWavelength: all colors
    float etaScale;        // square of the index of refraction along the path, which roulette must not count
    float scatterPDF;      // of the ray's direction; 0: light sampling cannot make this path
    LightContext scatter;  // where the ray left, for light sampling
    SegmentStart start;    // where the ray left, for media
    MediumStack media;
    uint depth;     // bounces so far
    uint rayCount;  // rays traced
    float alpha;    // 1: the camera ray hit a surface
    PathParts parts;  // of radiance; these two if kKeepsParts
    FirstLobe lobe;   // of the first bounce
};

INLINE PathState StartPath(Ray ray, Sampler rng) {
    PathState path;
    path.ray = ray;
    path.rng = rng;
    path.radiance = vec3(0.0f);
    path.throughput = vec3(1.0f);
    path.wavelength = kNoWavelength;
    path.etaScale = 1.0f;
    path.scatterPDF = 0.0f;
    path.scatter.position = ray.origin;
    path.scatter.normal = vec3(0.0f);
    path.start = StartAtCamera();
    path.media = NoMedia();
    path.depth = 0u;
    path.rayCount = 0u;
    path.alpha = 0.0f;
    if (kKeepsParts) path.parts = NoParts();
    path.lobe = NoLobe();
    return path;
}

// The share of a sample of density `pdf` where `other` is the density of the other strategy for it.
INLINE float MISWeight(float pdf, float other) {
    if (ActiveMis() == kMisBalance) return pdf / (pdf + other);
    float ratio = other / pdf;  // their squares may leave the range of float
    return 1.0f / (1.0f + ratio * ratio);
}

// Weight of light that a BSDF sample of density scatterPDF found, and light sampling would with lightPDF.
INLINE float ScatterWeight(float scatterPDF, float lightPDF) {
    if (!HasTraceFeature(kTraceLightSampling) || scatterPDF == 0.0f || lightPDF == 0.0f) return 1.0f;
    return ActiveMis() == kMisOff ? 0.0f : MISWeight(scatterPDF, lightPDF);
}

INLINE float LightWeight(LightSample light, float scatterPDF) {
    if (light.isDelta != 0u || ActiveMis() == kMisOff) return 1.0f;
    return MISWeight(light.pdf, scatterPDF);
}

#ifndef LIGHT_GROUPS
INLINE void AddToGroup(vec3, uint) {}
#endif

// Adds the contribution `value` of light at vertex `depth` of the path, through `lobe`. `light` is the number
// of the light that it comes from, or kNoLight.
INLINE void Collect(INOUT(PathState) path, vec3 value, uint depth, FirstLobe lobe, uint light,
                    PathSettings settings) {
    if (depth > 1u) {
        float largest = MaxComponent(value);
        if (largest > settings.clampIndirect) value *= settings.clampIndirect / largest;
    }
    path.radiance += value;
    if (kKeepsParts) AddPart(path.parts, value, depth, lobe);
    AddToGroup(value, light);
}

// Light that the path's ray found: `light` is its number, or kNoLight where light sampling cannot find it.
INLINE void CollectFound(INOUT(PathState) path, vec3 radiance, uint light, float distance,
                         PathSettings settings) {
    float lightPDF = 0.0f;
    // The point from which light sampling sampled: straight crossings may have moved the ray's origin
    if (HasTraceFeature(kTraceThinWalls))
        distance += dot(path.ray.origin - path.scatter.position, path.ray.direction);
    if (HasTraceFeature(kTraceLightSampling) && path.scatterPDF > 0.0f && light != kNoLight)
        lightPDF = LightPDF(path.scatter, light, path.ray.direction, distance);
    float weight = ScatterWeight(path.scatterPDF, lightPDF);
    Collect(path, path.throughput * radiance * weight, path.depth, path.lobe, light, settings);
}

// Light from one point of one light, scattered by a surface to the camera, if it is not occluded.
struct DirectLight {
    Ray ray;
    float distance;  // that must be unoccluded
    float ior;       // of the medium on the way
    vec3 radiance;   // 0: no light
    FirstLobe lobe;  // of the path, if kKeepsParts
    uint light;      // its number
};

INLINE DirectLight NoDirectLight() {
    DirectLight direct;
    direct.ray.origin = vec3(0.0f);
    direct.ray.direction = vec3(0.0f, 0.0f, 1.0f);
    direct.distance = 0.0f;
    direct.ior = 1.0f;
    direct.radiance = vec3(0.0f);
    direct.lobe = NoLobe();
    direct.light = kNoLight;
    return direct;
}

// Russian roulette. False: the path is terminated; the weight of survivors keeps the mean.
INLINE bool SurviveRoulette(INOUT(PathState) path, PathSettings settings) {
    float survival = 1.0f;
    if (path.depth + 1u < settings.rouletteStart) return true;
    if (ActiveRoulette() == kRouletteThroughput) {
        survival = min(MaxComponent(path.throughput) * path.etaScale, kMaxSurvival);
        if (!(Get1D(path.rng) < survival)) return false;  // ends a path of NaN too
    } else if (ActiveRoulette() == kRouletteConstant) {
        survival = settings.survival;
        if (!(Get1D(path.rng) < survival)) return false;
    } else if (ActiveRoulette() == kRouletteFrame) {
        survival = settings.survival;
        if (path.depth + 1u > settings.frameDepth) return false;
    }
    path.throughput /= survival;
    return true;
}

// A surface as the path meets it.
struct Vertex {
    SurfaceInteraction surface;
    MediumStack beyond;  // the media on its other side
    SurfaceBSDF bsdf;
    Frame frame;
};

// The contribution of a light, with `scattered` = f |cos| towards it and `scatterPDF` the density of
// its direction.
INLINE DirectLight ScatterLight(PathState path, Vertex vertex, LightSample light, vec3 scattered,
                                float scatterPDF) {
    DirectLight direct;
    float side = dot(light.wi, vertex.surface.geometricNormal);
    direct.ray = ShadowRayTo(vertex.surface, light, direct.distance);
    direct.lobe = path.lobe;
    direct.light = light.light;
    direct.radiance =
        path.throughput * scattered * light.radiance * (LightWeight(light, scatterPDF) / light.pdf);
    direct.ior = 1.0f;
    if (HasTraceFeature(kTraceVolumes)) {
        uint medium = CurrentMedium(side > 0.0f ? path.media : vertex.beyond);
        direct.radiance *= Transmittance(medium, light.distance);
        if (HasTraceFeature(kTraceThinWalls)) direct.ior = MediumIor(medium, path.wavelength);
    }
    return direct;
}

// Gives the path its next ray. `diffuse` is the diffuse part of scattered.f. False: there is none.
INLINE bool Scatter(INOUT(PathState) path, Vertex vertex, BSDFSample scattered, vec3 diffuse,
                    PathSettings settings) {
    if (!(scattered.pdf > 0.0f)) return false;
    if (kKeepsParts && path.depth == 0u)
        path.lobe = FirstLobeOf(scattered.f, diffuse, IsTransmissive(scattered.flags));
    vec3 direction = FromLocal(vertex.frame, scattered.wi);
    float side = dot(direction, vertex.surface.geometricNormal);
    if (side * scattered.wi.z <= 0.0f) return false;  // light leak of the shading normal
    path.throughput *= scattered.f * (abs(scattered.wi.z) / scattered.pdf);
    if (!(MaxComponent(path.throughput) > 0.0f)) return false;
    path.scatterPDF = IsSpecular(scattered.flags) ? 0.0f : scattered.pdf;
    path.ray.direction = direction;
    path.ray.origin = OriginTowards(vertex.surface, side);
    if (HasTraceFeature(kTraceVolumes)) path.start = StartAtSurface(vertex.surface, path.ray.origin);
    if (HasTraceFeature(kTraceTransmission) && IsTransmissive(scattered.flags)) {
        path.etaScale *= scattered.eta * scattered.eta;
        if (HasTraceFeature(kTraceVolumes)) path.media = vertex.beyond;
    }
    if (!SurviveRoulette(path, settings)) return false;
    ++path.depth;
    return true;
}

// Draws a direction to a light and one from the BSDF, and follows both. False: the path ends here.
INLINE bool ScatterBoth(INOUT(PathState) path, Vertex vertex, PathSettings settings,
                        INOUT(DirectLight) direct) {
    path.rng.dimension = kCameraDimensions + path.depth * kBounceDimensions;
    LightSample light = NoLightSample();
    vec3 toLight = vec3(0.0f);
    if (HasTraceFeature(kTraceLightSampling)) {
        float choice = Get1D(path.rng);
        vec2 u = Get2D(path.rng);
        if (IsNonSpecular(vertex.bsdf.flags)) light = SampleLight(path.scatter, choice, u);
        toLight = ToLocal(vertex.frame, light.wi);
        // No light where the shading normal would leak
        if (dot(light.wi, vertex.surface.geometricNormal) * toLight.z <= 0.0f) light.pdf = 0.0f;
    } else {
        path.rng.dimension += 3u;
    }
    float choice = Get1D(path.rng);
    bool isEvaluated = false;
    BSDFSample scattered = SampleDirection(vertex.bsdf, choice, Get2D(path.rng), isEvaluated);
    vec3 diffuse = DiffuseOf(vertex.bsdf, scattered);  // of scattered.f

    if (!HasTraceFeature(kTraceLightSampling)) {
        if (!isEvaluated) scattered.f = Evaluate(vertex.bsdf, scattered.wi, scattered.pdf, diffuse);
        return Scatter(path, vertex, scattered, diffuse, settings);
    }
    // Evaluate the BSDF for both at one call site: a device compiles it for each
    DONT_UNROLL
    for (uint turn = 0u; turn < 2u; ++turn) {
        bool isLight = turn == 0u;
        if (isLight ? !(light.pdf > 0.0f) : isEvaluated) continue;
        float pdf = 0.0f;
        vec3 part = vec3(0.0f);
        vec3 value = Evaluate(vertex.bsdf, isLight ? toLight : scattered.wi, pdf, part);
        if (isLight) {
            direct = ScatterLight(path, vertex, light, value * abs(toLight.z), pdf);
            if (kKeepsParts && path.depth == 0u)
                direct.lobe = FirstLobeOf(value, part, !SameHemisphere(vertex.bsdf.wo, toLight));
        } else {
            scattered.f = value;
            scattered.pdf = pdf;
            diffuse = part;
        }
    }
    return Scatter(path, vertex, scattered, diffuse, settings);
}

// Moves the path's ray to the other side of the surface it has found.
INLINE void PassThrough(INOUT(PathState) path, SurfaceInteraction surface) {
    path.ray.origin = OffsetRayOrigin(surface.position, -surface.geometricNormal, surface.clearance);
    if (HasTraceFeature(kTraceVolumes)) path.start = StartAtSurface(surface, path.ray.origin);
}

// Whether the path passes straight through the smooth thin wall it has found. If not, the wall's transmission
// is removed.
INLINE bool GoesStraight(INOUT(PathState) path, INOUT(Vertex) vertex) {
    float chance = StraightChance(vertex.bsdf);
    path.rng.dimension = kStraightDimensions + path.rayCount;
    if (Get1D(path.rng) < chance) {
        path.throughput *= StraightShare(vertex.bsdf) / chance;
        return true;
    }
    path.throughput /= 1.0f - chance;
    vertex.bsdf = WithoutStraight(vertex.bsdf, chance);
    return false;
}

// At the boundary of a medium that refracts colors differently, a path of all colors goes on as one of a
// single wavelength.
INLINE void ChooseWavelength(INOUT(PathState) path, Boundary boundary) {
    if (path.wavelength != kNoWavelength) return;
    if (!IsDispersive(boundary.here) && !IsDispersive(boundary.there)) return;
    path.rng.dimension = kWavelengthDimension;
    path.wavelength = SampleWavelength(Get1D(path.rng));
    path.throughput *= WavelengthShare(path.wavelength);
}

// Adds the emission that the path's ray found, and scatters the path there. `direct` becomes the light that a
// shadow ray must confirm. False: the path ends here.
INLINE bool ShadeVertex(INOUT(PathState) path, Hit hit, PathSettings settings, INOUT(DirectLight) direct) {
    // The ray's hit: a surface, or the environment
    bool isHit = IsHit(hit);
    SurfaceInteraction surface;
    if (isHit) {
        surface = SurfaceAt(hit, path.ray);
        surface.emission *= EmissionPassed(surface, -path.ray.direction);
    } else {
        surface.emission = EnvironmentRadiance(path.ray.direction);
        surface.light = LightSet().lightCount;
        surface.material.flags = 0u;
    }
    bool isVolume = (surface.material.flags & kMaterialVolume) != 0u;
    Boundary boundary;
    boundary.beyond = path.media;
    boundary.isReal = true;
    float eta = surface.material.ior;
    float distance = isHit ? hit.t : kInfinity;
    if (HasTraceFeature(kTraceVolumes)) {
        float inside = isHit ? SegmentLength(path.start, surface, path.ray, distance) : kInfinity;
        path.throughput *= Transmittance(CurrentMedium(path.media), inside);
        if (isVolume)
            boundary = CrossBoundary(path.media, surface.material.id, surface.isFront);
        else
            eta = surface.material.ior / MediumIor(CurrentMedium(path.media), path.wavelength);
    }
    // Surfaces emit even if a medium of higher priority hides them, as for light sampling
    if (MaxComponent(surface.emission) > 0.0f)
        CollectFound(path, surface.emission, surface.light, distance, settings);
    if (!isHit) return false;
    if (HasTraceFeature(kTraceVolumes) && !boundary.isReal) {
        path.media = boundary.beyond;
        PassThrough(path, surface);
        path.scatterPDF = 0.0f;  // light sampling cannot follow: to its rays, surfaces of volumes are opaque
        return true;
    }
    path.alpha = 1.0f;
    bool isWall = IsSmoothThinWall(surface.material);
    bool isLast = path.depth >= settings.maxDepth;
    if ((isLast && !isWall) || (surface.material.flags & kMaterialUnlit) != 0u) return false;

    if (HasTraceFeature(kTraceVolumes) && isVolume) {
        if (HasTraceFeature(kTraceDispersion)) ChooseWavelength(path, boundary);
        eta = RelativeIor(boundary, path.wavelength);
    }

    // Scattering at the surface
    Vertex vertex;
    vertex.surface = surface;
    vertex.beyond = boundary.beyond;
    vertex.frame = FrameFromZ(surface.shadingNormal);
    float minAlpha = path.depth > 0u && !isWall ? settings.regularize : 0.0f;
    SurfaceSetting setting =
        SettingOf(surface, vertex.frame, eta, minAlpha, AlphaSeed(path.rng, path.rayCount));
    vertex.bsdf = BSDFOf(surface.material, ToLocal(vertex.frame, -path.ray.direction), setting);
    if (isWall) {
        if (GoesStraight(path, vertex)) {
            PassThrough(path, surface);
            return true;
        }
        if (isLast) return false;
    }
    path.scatter.position = surface.position;
    path.scatter.normal = IsTransmissive(vertex.bsdf.flags) ? vec3(0.0f) : surface.geometricNormal;
    return ScatterBoth(path, vertex, settings, direct);
}

// Traces the path's next ray, and a shadow ray from where it ended. False: the path has ended, and
// path.radiance is an unbiased estimate of the radiance along its first ray (unless a named bias is on).
INLINE bool ExtendPath(INOUT(PathState) path, PathSettings settings) {
    DirectLight direct = NoDirectLight();
    uint depth = path.depth;
    ++path.rayCount;
    Hit hit = Intersect(path.ray, AlphaSeed(path.rng, path.rayCount));
    bool isGoingOn = ShadeVertex(path, hit, settings, direct);
    if (HasTraceFeature(kTraceLightSampling)) {
        // Devices run many paths in lockstep. Paths without a light sample trace a ray of no length along
        // with the others: a branch here would make them diverge from then on
        bool isLit = MaxComponent(direct.radiance) > 0.0f;
        if (isLit)
            ++path.rayCount;
        else
            direct = NoDirectLight();
        vec3 share =
            UnblockedShare(direct.ray, direct.distance, direct.ior, AlphaSeed(path.rng, path.rayCount));
        if (isLit && MaxComponent(share) > 0.0f)
            Collect(path, direct.radiance * share, depth + 1u, direct.lobe, direct.light, settings);
    }
    return isGoingOn && path.rayCount < kMaxRays;
}

SHADING_END

#endif

// The path integrator on the CPU: the very text the device runs, over a bridge of one analytic sphere and
// smooth thin walls above it, or sheets of paper in their place.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "scene/ray.glsl"
#include "tests/shading/light_scene.h"
#include "tests/support/energy_bridge.h"

#include "bxdf/bsdf.glsl"

namespace raygraph::shading {

namespace {

// One sphere about the origin, walls without an end in planes of constant z, a triangle that shines, and an
// environment.
struct SphereScene {
    float radius = 1.0f;
    vec3 albedo{0.0f};
    float metallic = 0.0f;
    float roughness = 0.0f;
    vec3 emission{0.0f};
    std::vector<float> walls{};  // heights
    bool hasLamp = false;
    bool arePaper = false;  // the walls pass light diffusely, and are opaque to shadow rays
    bool isMedium = false;  // the sphere transmits light diffusely into a medium
};
thread_local SphereScene scene;
constexpr uint kWall = 1u, kLamp = 2u;  // beside the sphere, 0
// So large that light sampling goes by area
const vec3 kLampCorners[3] = {vec3(-60.0f, -50.0f, 2.5f), vec3(60.0f, -50.0f, 2.5f), vec3(0.0f, 80.0f, 2.5f)};
const vec3 kLampRadiance(4.0f);
const vec3 kWallTint(0.9f, 0.7f, 0.5f);

inline SurfaceMaterial WallMaterial() {
    SurfaceMaterial material{};
    material.baseColor = kWallTint;
    material.specular = 1.0f;
    material.specularColor = vec3(1.0f);
    material.ior = 1.5f;
    material.transmission = 1.0f;
    return material;
}

// Under a rough layer, unless `specular` is 0.
inline SurfaceMaterial PaperMaterial(float transmission, float specular) {
    SurfaceMaterial material = WallMaterial();
    material.transmission = 0.0f;
    material.roughness = 0.6f;
    material.specular = specular;
    material.diffuseTransmission = transmission;
    material.diffuseTransmissionColor = vec3(0.5f, 0.8f, 0.9f);
    return material;
}
thread_local SurfaceMaterial paper{};

// Radiance from everywhere, which the path finds by chance: the light table is left empty.
inline void SetScene(const SphereScene& values, float environment = 0.0f) {
    scene = values;
    testLights = {};
    testLights.environmentTint = vec3(environment);
}

inline Hit Intersect(Ray ray, uint) {
    Hit hit{};
    hit.t = -1.0f;
    const float b = dot(ray.origin, ray.direction);
    const float c = dot(ray.origin, ray.origin) - scene.radius * scene.radius;
    const float discriminant = b * b - c;
    if (discriminant >= 0.0f) {
        const float root = sqrt(discriminant);
        hit.t = -b - root > 0.0f ? -b - root : -b + root;
    }
    const auto meetPlane = [&](float height, uint instance) {
        const float t = (height - ray.origin.z) / ray.direction.z;
        if (!(t > 0.0f) || (hit.t >= 0.0f && t > hit.t)) return;
        const vec3 at = ray.origin + t * ray.direction;
        for (int i = 0; instance == kLamp && i < 3; ++i) {
            const vec3 side = kLampCorners[(i + 1) % 3] - kLampCorners[i];
            if (cross(side, at - kLampCorners[i]).z < 0.0f) return;
        }
        hit.t = t;
        hit.instance = instance;
    };
    for (const float height : scene.walls) meetPlane(height, kWall);
    if (scene.hasLamp) meetPlane(kLampCorners[0].z, kLamp);
    return hit;
}

inline Hit IntersectWithin(Ray ray, float distance, bool, uint alphaSeed) {
    Hit hit = Intersect(ray, alphaSeed);
    if (hit.t > distance) hit.t = -1.0f;
    return hit;
}

inline SurfaceInteraction SurfaceAt(Hit hit, Ray ray) {
    if (hit.instance != 0u) {
        SurfaceInteraction flat{};
        flat.position = ray.origin + hit.t * ray.direction;
        flat.geometricNormal = vec3(0.0f, 0.0f, ray.direction.z < 0.0f ? 1.0f : -1.0f);
        flat.shadingNormal = flat.geometricNormal;
        flat.clearance = 64.0f * gpu::kRoundoff * (1.0f + abs(flat.position.z));
        flat.light = hit.instance == kLamp ? 0u : kNoLight;
        flat.material.ior = 1.5f;
        if (hit.instance == kLamp)
            flat.emission = kLampRadiance;
        else
            flat.material = scene.arePaper ? paper : WallMaterial();
        return flat;
    }
    const vec3 outward = normalize(ray.origin + hit.t * ray.direction);
    const vec3 normal = dot(outward, ray.direction) < 0.0f ? outward : -outward;
    SurfaceInteraction surface{};
    surface.position = scene.radius * outward;
    surface.instanceOrigin = vec3(0.0f);
    surface.fromInstance = surface.position;
    surface.clearance = 16.0f * gpu::kRoundoff * scene.radius;
    surface.geometricNormal = normal;
    surface.shadingNormal = normal;
    surface.coatNormal = normal;
    surface.emission = scene.emission;
    surface.light = kNoLight;
    surface.isFront = normal == outward;
    surface.curvature = (surface.isFront ? 1.0f : -1.0f) / scene.radius;
    surface.material.baseColor = scene.albedo;
    surface.material.metallic = scene.metallic;
    surface.material.roughness = scene.roughness;
    surface.material.ior = 1.5f;
    if (scene.isMedium) {
        surface.material = paper;
        surface.material.flags = kMaterialVolume;
    }
    return surface;
}

inline vec3 ShadowTransmittance(Ray ray, float distance, float ior, uint) {
    vec3 passed(1.0f);
    while (true) {
        const Hit hit = Intersect(ray, 0u);
        if (!IsHit(hit) || hit.t > distance) return passed;
        if (hit.instance != kWall || scene.arePaper) return vec3(0.0f);
        passed *= PassThroughWeight(WallMaterial(), SettingOf(WallMaterial(), 1.5f / ior, 0.0f, 0u),
                                    vec3(std::sqrt(1.0f - Sqr(ray.direction.z)), 0.0f, abs(ray.direction.z)));
        ray.origin += (hit.t + 1e-4f) * ray.direction;
        distance -= hit.t + 1e-4f;
    }
}

thread_local float ballExtinction = 0.0f;
thread_local float mediumIor = 1.0f;

inline Medium MediumAt(uint) {
    return {.extinction = vec3(ballExtinction),
            .scattering = vec3(0.0f),
            .anisotropy = 0.0f,
            .ior = mediumIor,
            .dispersion = 0.0f,
            .priority = 0u};
}

}  // namespace

}  // namespace raygraph::shading

// The bridge is declared: now the integrator over it.
#define SINGLE_TRACE_CALL
#include "integrator/extend_path.glsl"

namespace raygraph::shading {

namespace {

constexpr uint kNoLimit = 0xFFFFFFFFu;

// Other tests find the options as they were.
class PathFixture : public ::testing::Test {
  protected:
    ~PathFixture() override {
        threadTraceFeatures = m_features;
        threadBrdfModel = m_brdf;
        threadMisHeuristic = m_mis;
        threadRoulette = m_roulette;
        threadLoopOptions = m_loop;
    }

  private:
    const TraceFeatures m_features = threadTraceFeatures;
    const BrdfModel m_brdf = threadBrdfModel;
    const MisHeuristic m_mis = threadMisHeuristic;
    const Roulette m_roulette = threadRoulette;
    const uint m_loop = threadLoopOptions;
};

inline void UseOptions(TraceFeatures features, BrdfModel brdf = BrdfModel::Gltf) {
    threadTraceFeatures = features | kTraceMetals | kTraceOpaque | kTraceSmooth;
    threadBrdfModel = brdf;
    threadMisHeuristic = MisHeuristic::Power;
}

// Unbiased, and all materials Lambert's.
inline PathSettings Unbiased(uint maxDepth, uint rouletteStart) {
    UseOptions({}, BrdfModel::Lambert);
    return {.maxDepth = maxDepth,
            .rouletteStart = rouletteStart,
            .survival = 1.0f,
            .frameDepth = 0u,
            .clampIndirect = kInfinity,
            .regularize = 0.0f};
}

struct Mean {
    double radiance = 0.0;
    double standardError = 0.0;
    double rays = 0.0;
};

inline Mean MeanRadiance(Ray ray, PathSettings settings, uint sampleCount) {
    double sum = 0.0, squares = 0.0, rays = 0.0;
    for (uint i = 0; i < sampleCount; ++i) {
        Sampler rng = StartPixelSample(uvec2(7u, 11u), i, 42u);
        PathState path = StartPath(ray, rng);
        while (ExtendPath(path, settings)) {
        }
        sum += path.radiance.y;
        squares += double(path.radiance.y) * path.radiance.y;
        rays += path.rayCount;
    }
    const double n = sampleCount;
    const double mean = sum / n;
    return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / n), rays / n};
}

inline Ray FromCenter() {
    return {.origin = vec3(0.0f), .direction = normalize(vec3(0.3f, -0.5f, 0.7f))};
}

// The sphere from above, in the middle of the picture.
inline Ray FromAbove() {
    return {.origin = vec3(0.0f, 0.0f, 5.0f), .direction = vec3(0.0f, 0.0f, -1.0f)};
}

}  // namespace

}  // namespace raygraph::shading

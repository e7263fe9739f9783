// The path integrator on the CPU: the very text that devices run, over a bridge of a few analytic shapes.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "scene/ray.glsl"
#include "tests/shading/light_scene.h"
#include "tests/support/energy_bridge.h"

#include "bxdf/bsdf.glsl"

namespace raygraph::shading {

// A sphere, an endless plane of constant z, or a triangle in such a plane, whose front is above.
struct Shape {
    enum class Kind { Sphere, Plane, Triangle };
    Kind kind = Kind::Sphere;
    vec3 center{0.0f};
    float radius = 1.0f;
    float height = 0.0f;
    std::vector<vec3> corners{};  // counterclockwise from above
    SurfaceMaterial material{};
    std::function<vec3(vec3 position, bool isFront)> emission = [](vec3, bool) { return vec3(0.0f); };
    uint light = kNoLight;
    Medium medium = {.extinction = vec3(0.0f),
                     .scattering = vec3(0.0f),
                     .anisotropy = 0.0f,
                     .ior = 1.0f,
                     .dispersion = 0.0f,
                     .priority = 0u};
};

// The shapes are instances and materials of the same indices.
inline thread_local std::vector<Shape> shapes;

inline void Meet(const Shape& shape, Ray ray, uint instance, Hit& hit) {
    const auto meet = [&](float t) {
        if (!(t > 0.0f && t < std::numeric_limits<float>::max()) || (hit.t >= 0.0f && t > hit.t)) return;
        hit.t = t;
        hit.instance = instance;
    };
    if (shape.kind == Shape::Kind::Sphere) {
        const vec3 from = ray.origin - shape.center;
        const float b = dot(from, ray.direction);
        const float discriminant = b * b - (dot(from, from) - shape.radius * shape.radius);
        if (discriminant < 0.0f) return;
        meet(-b - sqrt(discriminant));
        meet(-b + sqrt(discriminant));
        return;
    }
    const float t = (shape.height - ray.origin.z) / ray.direction.z;
    const vec3 at = ray.origin + t * ray.direction;
    for (size_t i = 0; i < shape.corners.size(); ++i) {
        const vec3 side = shape.corners[(i + 1) % 3] - shape.corners[i];
        if (!(cross(side, at - shape.corners[i]).z >= 0.0f)) return;
    }
    meet(t);
}

inline Hit Intersect(Ray ray, uint) {
    Hit hit{};
    hit.t = -1.0f;
    for (uint i = 0; i < shapes.size(); ++i) Meet(shapes[i], ray, i, hit);
    return hit;
}

inline Hit IntersectWithin(Ray ray, float distance, bool, uint alphaSeed) {
    Hit hit = Intersect(ray, alphaSeed);
    if (hit.t > distance) hit.t = -1.0f;
    return hit;
}

inline SurfaceInteraction SurfaceAt(Hit hit, Ray ray) {
    const Shape& shape = shapes.at(hit.instance);
    SurfaceInteraction surface{};
    surface.position = ray.origin + hit.t * ray.direction;
    vec3 outward(0.0f, 0.0f, 1.0f);
    if (shape.kind == Shape::Kind::Sphere) {
        outward = normalize(surface.position - shape.center);
        surface.position = shape.center + shape.radius * outward;
        surface.clearance = 16.0f * gpu::kRoundoff * (shape.radius + length(shape.center));
    } else {
        surface.clearance = 64.0f * gpu::kRoundoff * (1.0f + abs(surface.position.z));
    }
    surface.isFront = dot(outward, ray.direction) < 0.0f;
    surface.geometricNormal = surface.isFront ? outward : -outward;
    surface.shadingNormal = surface.geometricNormal;
    surface.coatNormal = surface.geometricNormal;
    surface.fromInstance = surface.position;
    if (shape.kind == Shape::Kind::Sphere)
        surface.curvature = (surface.isFront ? 1.0f : -1.0f) / shape.radius;
    surface.emission = shape.emission(surface.position, surface.isFront);
    surface.light = shape.light;
    surface.material = shape.material;
    surface.material.id = hit.instance;
    return surface;
}

// Smooth thin walls, which are planes, dim shadow rays; all else stops them.
inline vec3 ShadowTransmittance(Ray ray, float distance, float ior, uint) {
    vec3 passed(1.0f);
    while (true) {
        const Hit hit = Intersect(ray, 0u);
        if (!IsHit(hit) || hit.t > distance) return passed;
        const SurfaceMaterial& wall = shapes[hit.instance].material;
        if (!IsSmoothThinWall(wall)) return vec3(0.0f);
        passed *= PassThroughWeight(wall, SettingOf(wall, 1.5f / ior, 0.0f, 0u),
                                    vec3(std::sqrt(1.0f - Sqr(ray.direction.z)), 0.0f, abs(ray.direction.z)));
        ray.origin += (hit.t + 1e-4f) * ray.direction;
        distance -= hit.t + 1e-4f;
    }
}

inline Medium MediumAt(uint material) {
    return shapes.at(material).medium;
}

}  // namespace raygraph::shading

// The bridge is declared: now the integrator over it.
#define SINGLE_TRACE_CALL
#include "integrator/extend_path.glsl"

namespace raygraph::shading {

constexpr uint kNoLimit = 0xFFFFFFFFu;

// Other tests find options and lights as they were; those that follow find no shape.
class PathFixture : public ::testing::Test {
  protected:
    explicit PathFixture(TraceFeatures features = {}) {
        UseOptions(features);
        testLights = {};
        shapes.clear();
    }
    ~PathFixture() override {
        threadTraceFeatures = m_features;
        threadBrdfModel = m_brdf;
        threadMisHeuristic = m_mis;
        threadRoulette = m_roulette;
        threadLoopOptions = m_loop;
        testLights = {};
        shapes.clear();
    }

    static void UseOptions(TraceFeatures features, BrdfModel brdf = BrdfModel::Gltf) {
        threadTraceFeatures = features | kTraceMetals | kTraceOpaque | kTraceSmooth;
        threadBrdfModel = brdf;
        threadMisHeuristic = MisHeuristic::Power;
    }

  private:
    const TraceFeatures m_features = threadTraceFeatures;
    const BrdfModel m_brdf = threadBrdfModel;
    const MisHeuristic m_mis = threadMisHeuristic;
    const Roulette m_roulette = threadRoulette;
    const uint m_loop = threadLoopOptions;
};

// Without a bias.
inline PathSettings Unbiased(uint maxDepth, uint rouletteStart) {
    return {.maxDepth = maxDepth,
            .rouletteStart = rouletteStart,
            .survival = 1.0f,
            .frameDepth = 0u,
            .clampIndirect = kInfinity,
            .regularize = 0.0f};
}

struct Mean {
    glm::dvec3 radiance{0.0};
    glm::dvec3 error{0.0};  // standard error
    double rays = 0.0;
};

inline Mean MeanRadiance(Ray ray, PathSettings settings, uint sampleCount, MediumStack media = NoMedia()) {
    glm::dvec3 sum(0.0), squares(0.0);
    double rays = 0.0;
    for (uint i = 0; i < sampleCount; ++i) {
        PathState path = StartPath(ray, StartPixelSample(uvec2(7u, 11u), i, 42u));
        path.media = media;
        while (ExtendPath(path, settings)) {
        }
        sum += glm::dvec3(path.radiance);
        squares += glm::dvec3(path.radiance) * glm::dvec3(path.radiance);
        rays += path.rayCount;
    }
    const double n = sampleCount;
    const glm::dvec3 mean = sum / n;
    return {mean, glm::sqrt(glm::max(squares / n - mean * mean, 0.0) / n), rays / n};
}

// The means of all colors, each of a noise below this share of its value.
inline void ExpectMean(const Mean& mean, const glm::dvec3& expected, double noise = 0.01,
                       double tolerance = 1e-3) {
    for (int color = 0; color < 3; ++color) {
        EXPECT_LT(mean.error[color], noise * expected[color]) << "too noisy to prove anything";
        EXPECT_NEAR(mean.radiance[color], expected[color],
                    4.0 * mean.error[color] + tolerance * expected[color])
            << "color " << color;
    }
}

// A material that passes all light, smooth and without a color.
inline SurfaceMaterial ClearMaterial(float ior, uint flags) {
    SurfaceMaterial material{};
    material.baseColor = vec3(1.0f);
    material.specular = 1.0f;
    material.specularColor = vec3(1.0f);
    material.transmission = 1.0f;
    material.ior = ior;
    material.flags = flags;
    return material;
}

// Adds a triangle that shines, as a shape and as light `testLights.scene.emission.size()`.
inline void AddLamp(const std::vector<vec3>& corners, vec3 radiance, bool isDoubleSided) {
    Shape lamp{.kind = Shape::Kind::Triangle, .height = corners[0].z, .corners = corners};
    lamp.material.ior = 1.5f;
    lamp.emission = [=](vec3, bool isFront) { return isDoubleSided || !isFront ? radiance : vec3(0.0f); };
    lamp.light = uint(testLights.scene.emission.size());
    shapes.push_back(lamp);
    testLights.AddTriangle(corners[0], corners[2], corners[1], radiance, isDoubleSided);
}

// Light sampling, with every heuristic, has the mean that paths have which find lights by chance.
inline void ExpectSamplingFindsWhatChanceFinds(Ray ray, PathSettings settings, TraceFeatures lights) {
    const TraceFeatures features = threadTraceFeatures;
    const Mean byChance = MeanRadiance(ray, settings, 1u << 17);
    ASSERT_LT(byChance.error.y, 0.015 * byChance.radiance.y) << "too noisy to prove anything";
    threadTraceFeatures |= kTraceLightSampling | lights;
    for (const MisHeuristic mis : {MisHeuristic::Off, MisHeuristic::Balance, MisHeuristic::Power}) {
        threadMisHeuristic = mis;
        const Mean sampled = MeanRadiance(ray, settings, 1u << 15);
        const double error = std::hypot(sampled.error.y, byChance.error.y);
        EXPECT_NEAR(sampled.radiance.y, byChance.radiance.y, 4.0 * error) << "heuristic " << int(mis);
        EXPECT_LT(sampled.error.y, 0.02 * sampled.radiance.y) << "too noisy to prove anything";
    }
    threadTraceFeatures = features;
}

// An environment that is even but for one texel.
inline image::ImageF SkyWithALamp() {
    image::ImageF sky{.width = 16, .height = 8, .rgba = {}};
    for (uint32_t texel = 0; texel < 16 * 8; ++texel) {
        const float value = texel % 16 == 3 && texel / 16 == 2 ? 40.0f : 0.2f;
        sky.rgba.insert(sky.rgba.end(), {value, value, value, 1.0f});
    }
    return sky;
}

}  // namespace raygraph::shading

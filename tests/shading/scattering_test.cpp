// Media that scatter: their phase function, and paths through a half space, a sphere and an endless medium.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "scene/ray.glsl"
#include "tests/shading/light_scene.h"
#include "tests/support/energy_bridge.h"
#include "tests/support/h_function.h"

#include "bxdf/bsdf.glsl"

namespace raygraph::shading {

namespace {

enum class Shape { HalfSpace, Sphere, Lamp };
thread_local Shape shape = Shape::HalfSpace;
thread_local Medium fog;
const vec3 kLampCorners[3] = {vec3(-2.0f, -2.0f, 1.5f), vec3(2.0f, -2.0f, 1.5f), vec3(0.0f, 3.0f, 1.5f)};

// A half space below z = 0, a sphere of radius 1, or a triangle that shines.
Hit Intersect(Ray ray, uint) {
    Hit hit{};
    hit.t = -1.0f;
    if (shape == Shape::Sphere) {
        const float b = dot(ray.origin, ray.direction);
        const float discriminant = b * b - dot(ray.origin, ray.origin) + 1.0f;
        if (discriminant < 0.0f) return hit;
        const float root = sqrt(discriminant);
        hit.t = -b - root > 0.0f ? -b - root : -b + root;
        return hit;
    }
    const float height = shape == Shape::Lamp ? kLampCorners[0].z : 0.0f;
    const float t = (height - ray.origin.z) / ray.direction.z;
    if (!(t > 0.0f)) return hit;
    const vec3 at = ray.origin + t * ray.direction;
    for (int i = 0; shape == Shape::Lamp && i < 3; ++i)
        if (cross(kLampCorners[(i + 1) % 3] - kLampCorners[i], at - kLampCorners[i]).z < 0.0f) return hit;
    hit.t = t;
    return hit;
}

SurfaceInteraction SurfaceAt(Hit hit, Ray ray) {
    SurfaceInteraction surface{};
    surface.position = ray.origin + hit.t * ray.direction;
    surface.fromInstance = surface.position;
    const vec3 outward = shape == Shape::Sphere ? normalize(surface.position) : vec3(0.0f, 0.0f, 1.0f);
    surface.isFront = dot(outward, ray.direction) < 0.0f;
    surface.geometricNormal = surface.isFront ? outward : -outward;
    surface.shadingNormal = surface.geometricNormal;
    surface.clearance = 1e-5f;
    surface.light = kNoLight;
    surface.material.specular = 1.0f;
    surface.material.specularColor = vec3(1.0f);
    surface.material.ior = 1.0f;
    if (shape == Shape::Lamp) {
        surface.light = 0u;
        surface.emission = surface.isFront ? vec3(0.0f) : vec3(4.0f);
        surface.material.metallic = 1.0f;
    } else {
        surface.material.baseColor = vec3(1.0f);
        surface.material.transmission = 1.0f;
        surface.material.flags = kMaterialVolume;
    }
    return surface;
}

// Only the lamp is opaque, and shadow rays do not reach it.
vec3 ShadowTransmittance(Ray, float, float, uint) {
    return vec3(1.0f);
}

Medium MediumAt(uint) {
    return fog;
}

}  // namespace

}  // namespace raygraph::shading

// The bridge is declared: now the integrator over it.
#include "integrator/extend_path.glsl"

namespace raygraph::shading::scattering_test {

namespace {

constexpr uint kNoLimit = 0xFFFFFFFFu;

// Other tests find the options as they were.
class Scattering : public ::testing::Test {
  protected:
    Scattering() {
        threadTraceFeatures = kTraceSmooth | kTraceGlass | kTraceMetals | kTraceVolumes | kTraceScattering;
        threadBrdfModel = BrdfModel::Gltf;
        threadMisHeuristic = MisHeuristic::Power;
        testLights = {};
        testLights.environmentTint = vec3(1.0f);
    }
    ~Scattering() override {
        threadTraceFeatures = m_features;
        threadBrdfModel = m_brdf;
        threadMisHeuristic = m_mis;
        testLights = {};
    }

    void Use(Shape wanted, vec3 extinction, vec3 albedo, float g) {
        shape = wanted;
        fog = {.extinction = extinction,
               .scattering = extinction * albedo,
               .anisotropy = g,
               .ior = 1.0f,
               .dispersion = 0.0f,
               .priority = 0u};
    }

  private:
    const TraceFeatures m_features = threadTraceFeatures;
    const BrdfModel m_brdf = threadBrdfModel;
    const MisHeuristic m_mis = threadMisHeuristic;
};

struct Mean {
    glm::dvec3 radiance{0.0};
    glm::dvec3 error{0.0};
};

Mean MeanRadiance(Ray ray, uint maxDepth, uint count, bool isInside = false) {
    const PathSettings settings{.maxDepth = maxDepth,
                                .rouletteStart = 4u,
                                .survival = 1.0f,
                                .frameDepth = 0u,
                                .clampIndirect = kInfinity,
                                .regularize = 0.0f};
    glm::dvec3 sum(0.0), squares(0.0);
    for (uint i = 0; i < count; ++i) {
        PathState path = StartPath(ray, StartPixelSample(uvec2(7u, 11u), i, 42u));
        if (isInside) path.media = EnterMedium(NoMedia(), 0u);
        while (ExtendPath(path, settings)) {
        }
        sum += glm::dvec3(path.radiance);
        squares += glm::dvec3(path.radiance) * glm::dvec3(path.radiance);
    }
    const glm::dvec3 mean = sum / double(count);
    return {mean, glm::sqrt(glm::max(squares / double(count) - mean * mean, 0.0) / double(count))};
}

Ray From(float mu) {
    const vec3 up(sqrt(1.0f - mu * mu), 0.0f, mu);
    return {.origin = 2.0f * up, .direction = -up};
}

}  // namespace

TEST_F(Scattering, PhaseFunctionIsOneInAllAndHasItsMeanCosine) {
    for (const float g : {-0.9f, -0.3f, 0.0f, 5e-4f, 0.5f, 0.95f}) {
        double sum = 0.0, cosines = 0.0;
        constexpr int kSteps = 400000;
        for (int i = 0; i < kSteps; ++i) {
            const double z = -1.0 + 2.0 * (i + 0.5) / kSteps;
            const double share = 4.0 * double(kPi) / kSteps * double(PhaseHG(g, float(z)));
            sum += share;
            cosines += share * z;
        }
        EXPECT_NEAR(sum, 1.0, 1e-3) << g;
        EXPECT_NEAR(cosines, g, 1e-3) << g;
    }
}

// The bins have equal probability by the closed form of the cumulative density.
TEST_F(Scattering, DirectionsAreDrawnByThePhaseFunction) {
    for (const float g : {-0.7f, 5e-4f, 0.3f, 0.9f}) {
        constexpr uint kCount = 1u << 18, kBins = 16u;
        std::array<uint, kBins> counts{};
        for (uint i = 0; i < kCount; ++i) {
            const vec3 wi = SamplePhaseHG(g, vec2((float(i) + 0.5f) / float(kCount), 0.37f));
            EXPECT_NEAR(dot(wi, wi), 1.0f, 1e-5f);
            const double d = g, z = wi.z;
            const double below =
                (1.0 - d * d) / (2.0 * d) * (1.0 / std::sqrt(1.0 + d * d - 2.0 * d * z) - 1.0 / (1.0 + d));
            ++counts[std::min(uint(below * kBins), kBins - 1u)];
        }
        for (const uint count : counts) EXPECT_NEAR(double(count) * kBins / kCount, 1.0, 0.005) << g;
    }
}

// Each color has another extinction and another albedo; the closed form depends on the albedo alone.
TEST_F(Scattering, HalfSpaceReflectsByChandrasekharsHFunction) {
    const vec3 albedo(0.5f, 0.9f, 0.99f);
    Use(Shape::HalfSpace, vec3(10.0f, 1.0f, 3.0f), albedo, 0.0f);
    for (const float mu : {1.0f, 0.3f}) {
        const Mean mean = MeanRadiance(From(mu), kNoLimit, 1u << 15);
        for (int color = 0; color < 3; ++color) {
            const double expected = testing::HFunction(double{albedo[color]}).Reflected(mu);
            EXPECT_LT(mean.error[color], 0.01) << "too noisy to prove anything";
            EXPECT_NEAR(mean.radiance[color], expected, 4.0 * mean.error[color] + 1e-3)
                << "cosine " << mu << ", color " << color;
        }
    }
}

// Light that is scattered once: of the share that reaches a depth, the phase function sends some out again,
//     albedo integral of p(angle) mu / (mu + mu0) over the directions above.
TEST_F(Scattering, LightScatteredOnceFollowsThePhaseFunction) {
    constexpr double kAlbedo = 0.8, kMu0 = 0.4;
    for (const float g : {-0.5f, 0.0f, 0.7f}) {
        Use(Shape::HalfSpace, vec3(2.0f), vec3(float(kAlbedo)), g);
        // Through the boundary, scattered, and out again
        const Mean mean = MeanRadiance(From(float(kMu0)), 3u, 1u << 17);
        double expected = 0.0;
        constexpr int kSteps = 400;
        for (int i = 0; i < kSteps; ++i)
            for (int j = 0; j < kSteps; ++j) {
                const double mu = (i + 0.5) / kSteps, phi = double(kPi) * (j + 0.5) / kSteps;
                const double sines = std::sqrt((1.0 - mu * mu) * (1.0 - kMu0 * kMu0));
                const double cosTheta = -mu * kMu0 - sines * std::cos(phi);
                expected += double(PhaseHG(g, float(cosTheta))) * mu / (mu + kMu0);
            }
        expected *= kAlbedo * 2.0 * double(kPi) / (double(kSteps) * kSteps);
        EXPECT_LT(mean.error.y, 0.01 * expected + 1e-4);
        EXPECT_NEAR(mean.radiance.y, expected, 4.0 * mean.error.y + 1e-4) << g;
    }
}

TEST_F(Scattering, SphereThatAbsorbsNothingIsNotSeenInUniformLight) {
    for (const float g : {0.0f, 0.8f}) {
        Use(Shape::Sphere, vec3(2.0f, 5.0f, 0.5f), vec3(1.0f), g);
        const Mean mean = MeanRadiance(
            {.origin = vec3(0.3f, 0.0f, 3.0f), .direction = vec3(0.0f, 0.0f, -1.0f)}, kNoLimit, 1u << 14);
        for (int color = 0; color < 3; ++color)
            EXPECT_NEAR(mean.radiance[color], 1.0, 4.0 * mean.error[color] + 1e-4) << g;
    }
}

// The medium is infinite; light goes from the lamp to a point of the ray, and from there to the eye.
TEST_F(Scattering, PointLightInFogIsTheIntegralAlongTheRay) {
    testLights.environmentTint = vec3(0.0f);
    testLights.AddPunctual(scene::LightType::Point, vec3(0.5f, 0.0f, -1.0f), vec3(0.0f, 0.0f, -1.0f),
                           vec3(9.0f));
    testLights.Build();
    threadTraceFeatures |= kTraceLightSampling | kTracePunctualLights;
    const float g = 0.6f;
    const double sigma = 0.7, albedo = 0.9;
    Use(Shape::HalfSpace, vec3(float(sigma)), vec3(float(albedo)), g);
    // Down: the plane is behind
    const Mean mean = MeanRadiance({.origin = vec3(0.0f, 0.0f, -1e-3f), .direction = vec3(0.0f, 0.0f, -1.0f)},
                                   1u, 1u << 16, true);
    double expected = 0.0;
    constexpr double kStep = 1e-4;
    for (double t = 0.5 * kStep; t < 40.0; t += kStep) {
        const glm::dvec2 toLight(0.5, t - 0.999);
        const double distance = glm::length(toLight);
        const double cosTheta = toLight.y / distance;  // to the direction of the ray, which is -z
        expected += double(PhaseHG(g, float(-cosTheta))) * 9.0 / (distance * distance) *
                    std::exp(-sigma * (t + distance)) * sigma * albedo * kStep;
    }
    EXPECT_LT(mean.error.y, 0.01 * expected);
    EXPECT_NEAR(mean.radiance.y, expected, 4.0 * mean.error.y);
}

TEST_F(Scattering, LampInFogIsFoundBySamplingAsByChance) {
    testLights.environmentTint = vec3(0.0f);
    testLights.AddTriangle(kLampCorners[0], kLampCorners[2], kLampCorners[1], vec3(4.0f));
    testLights.Build();
    Use(Shape::Lamp, vec3(0.5f, 0.2f, 1.0f), vec3(0.9f, 0.5f, 0.8f), 0.4f);
    const Ray ray{.origin = vec3(0.0f), .direction = normalize(vec3(1.0f, 0.1f, -0.3f))};
    const Mean found = MeanRadiance(ray, 6u, 1u << 17, true);
    threadTraceFeatures |= kTraceLightSampling | kTraceTriangleLights;
    for (const MisHeuristic mis : {MisHeuristic::Power, MisHeuristic::Balance}) {
        threadMisHeuristic = mis;
        const Mean sampled = MeanRadiance(ray, 6u, 1u << 16, true);
        for (int color = 0; color < 3; ++color) {
            const double error = std::hypot(found.error[color], sampled.error[color]);
            EXPECT_LT(error, 0.05 * found.radiance[color]);
            EXPECT_NEAR(sampled.radiance[color], found.radiance[color], 4.0 * error) << color;
        }
        EXPECT_LT(sampled.error.y, found.error.y);
    }
}

}  // namespace raygraph::shading::scattering_test

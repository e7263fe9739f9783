// Media whose boundaries do not refract: light goes straight into and out of them, found by light sampling as by
// chance. Balls of media about each other, on the CPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "scene/ray.glsl"
#include "tests/shading/light_scene.h"
#include "tests/support/energy_bridge.h"

#include "bxdf/bsdf.glsl"

namespace raygraph::shading {

namespace {

struct Ball {
    vec3 center{0.0f};
    float radius = 1.0f;
    Medium medium{};
};
// Ball i is of material i.
thread_local std::vector<Ball> balls;
thread_local SurfaceMaterial skin{};  // material of all surfaces, except for ior and id
thread_local bool hasLamp = false;
const vec3 kLampCorners[3] = {vec3(-0.3f, -0.3f, 3.0f), vec3(0.3f, -0.3f, 3.0f), vec3(0.0f, 0.4f, 3.0f)};
constexpr uint kLamp = 100u;

Hit Intersect(Ray ray, uint) {
    Hit hit{};
    hit.t = -1.0f;
    const auto meet = [&](float t, uint instance) {
        if (!(t > 0.0f) || (hit.t >= 0.0f && t > hit.t)) return;
        hit.t = t;
        hit.instance = instance;
    };
    for (uint i = 0; i < balls.size(); ++i) {
        const vec3 from = ray.origin - balls[i].center;
        const float b = dot(from, ray.direction);
        const float discriminant = b * b - dot(from, from) + Sqr(balls[i].radius);
        if (discriminant < 0.0f) continue;
        meet(-b - sqrt(discriminant), i);
        meet(-b + sqrt(discriminant), i);
    }
    const float t = (kLampCorners[0].z - ray.origin.z) / ray.direction.z;
    bool isOnLamp = hasLamp;
    for (int i = 0; isOnLamp && i < 3; ++i) {
        const vec3 at = ray.origin + t * ray.direction - kLampCorners[i];
        isOnLamp = cross(kLampCorners[(i + 1) % 3] - kLampCorners[i], at).z >= 0.0f;
    }
    if (isOnLamp) meet(t, kLamp);
    return hit;
}

SurfaceInteraction SurfaceAt(Hit hit, Ray ray) {
    SurfaceInteraction surface{};
    surface.position = ray.origin + hit.t * ray.direction;
    surface.light = kNoLight;
    surface.clearance = 2e-5f;
    if (hit.instance == kLamp) {
        surface.isFront = ray.direction.z > 0.0f;
        surface.geometricNormal = vec3(0.0f, 0.0f, surface.isFront ? -1.0f : 1.0f);
        surface.light = 0u;
        surface.emission = surface.isFront ? vec3(40.0f) : vec3(0.0f);
        surface.material.metallic = 1.0f;
        surface.material.ior = 1.5f;
    } else {
        const Ball& ball = balls[hit.instance];
        const vec3 outward = normalize(surface.position - ball.center);
        surface.position = ball.center + ball.radius * outward;
        surface.isFront = dot(outward, ray.direction) < 0.0f;
        surface.geometricNormal = surface.isFront ? outward : -outward;
        surface.material = skin;
        surface.material.ior = ball.medium.ior;
        surface.material.id = hit.instance;
    }
    surface.shadingNormal = surface.geometricNormal;
    surface.coatNormal = surface.geometricNormal;
    surface.fromInstance = surface.position;
    return surface;
}

// Acts like shadow rays that all surfaces but smooth thin walls block.
vec3 ShadowTransmittance(Ray ray, float distance, float, uint) {
    const Hit hit = Intersect(ray, 0u);
    return vec3(IsHit(hit) && hit.t < distance ? 0.0f : 1.0f);
}

Medium MediumAt(uint material) {
    return balls[material].medium;
}

}  // namespace

}  // namespace raygraph::shading

// The bridge is declared: now the integrator over it.
#include "integrator/extend_path.glsl"

namespace raygraph::shading::matched_media_test {

namespace {

constexpr TraceFeatures kFeatures = kTraceSmooth | kTraceGlass | kTraceMetals | kTraceOpaque | kTraceVolumes |
                                    kTraceScattering | kTraceMatchedMedia | kTraceClearcoat;

Medium Fog(vec3 extinction, vec3 albedo, float g, float ior = 1.0f, uint priority = 0u) {
    return {.extinction = extinction,
            .scattering = extinction * albedo,
            .anisotropy = g,
            .ior = ior,
            .dispersion = 0.0f,
            .priority = priority};
}

// Passes all light.
SurfaceMaterial ClearSkin() {
    SurfaceMaterial material{};
    material.baseColor = vec3(1.0f);
    material.specular = 1.0f;
    material.specularColor = vec3(1.0f);
    material.transmission = 1.0f;
    material.flags = kMaterialVolume;
    return material;
}

// Other tests find the options as they were.
class MatchedMedia : public ::testing::Test {
  protected:
    MatchedMedia() {
        threadTraceFeatures = kFeatures;
        threadBrdfModel = BrdfModel::Gltf;
        threadMisHeuristic = MisHeuristic::Power;
        testLights = {};
        balls.clear();
        skin = ClearSkin();
        hasLamp = false;
    }
    ~MatchedMedia() override {
        threadTraceFeatures = m_features;
        threadBrdfModel = m_brdf;
        threadMisHeuristic = m_mis;
        testLights = {};
    }

    void LightWithAPoint(vec3 position) {
        testLights.AddPunctual(scene::LightType::Point, position, vec3(0.0f, 0.0f, -1.0f), vec3(9.0f));
        testLights.Build();
        threadTraceFeatures |= kTraceLightSampling | kTracePunctualLights;
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

Mean MeanRadiance(Ray ray, uint maxDepth, uint count, MediumStack media = NoMedia()) {
    const PathSettings settings{.maxDepth = maxDepth,
                                .rouletteStart = 8u,
                                .survival = 1.0f,
                                .frameDepth = 0u,
                                .clampIndirect = kInfinity,
                                .regularize = 0.0f};
    glm::dvec3 sum(0.0), squares(0.0);
    for (uint i = 0; i < count; ++i) {
        PathState path = StartPath(ray, StartPixelSample(uvec2(7u, 11u), i, 42u));
        path.media = media;
        while (ExtendPath(path, settings)) {
        }
        sum += glm::dvec3(path.radiance);
        squares += glm::dvec3(path.radiance) * glm::dvec3(path.radiance);
    }
    const glm::dvec3 mean = sum / double(count);
    return {mean, glm::sqrt(glm::max(squares / double(count) - mean * mean, 0.0) / double(count))};
}

// The medium at a point: of the balls around it the one of highest priority.
std::optional<Medium> PresentAt(const glm::dvec3& at) {
    std::optional<Medium> present;
    for (const Ball& ball : balls)
        if (glm::length(at - glm::dvec3(ball.center)) < double{ball.radius} &&
            (!present || ball.medium.priority > present->priority))
            present = ball.medium;
    return present;
}

glm::dvec3 OpticalDepth(const glm::dvec3& from, const glm::dvec3& to, int steps) {
    glm::dvec3 depth(0.0);
    const double step = glm::length(to - from) / steps;
    for (int i = 0; i < steps; ++i)
        if (const auto medium = PresentAt(glm::mix(from, to, (i + 0.5) / steps)))
            depth += glm::dvec3(medium->extinction) * step;
    return depth;
}

// Light of a point that is scattered once along the ray.
glm::dvec3 ScatteredOnce(const Ray& ray, const glm::dvec3& light, double length) {
    constexpr int kSteps = 2000;
    const glm::dvec3 origin(ray.origin), direction(ray.direction);
    const double step = length / kSteps;
    glm::dvec3 depth(0.0), sum(0.0);
    for (int i = 0; i < kSteps; ++i) {
        const glm::dvec3 at = origin + (i + 0.5) * step * direction;
        const auto medium = PresentAt(at);
        if (!medium) continue;
        const glm::dvec3 extinction(medium->extinction);
        const glm::dvec3 way = light - at;
        const double phase =
            double(PhaseHG(medium->anisotropy, float(glm::dot(direction, glm::normalize(way)))));
        sum += glm::dvec3(medium->scattering) * (phase * 9.0 / glm::dot(way, way) * step) *
               glm::exp(-depth - 0.5 * step * extinction - OpticalDepth(at, light, 2000));
        depth += step * extinction;
    }
    return sum;
}

void ExpectMean(const Mean& mean, const glm::dvec3& expected, const char* what) {
    for (int color = 0; color < 3; ++color) {
        EXPECT_LT(mean.error[color], 0.01 * expected[color]) << "too noisy to prove anything: " << what;
        EXPECT_NEAR(mean.radiance[color], expected[color], 4.0 * mean.error[color] + 1e-3 * expected[color])
            << what << ", color " << color;
    }
}

const Ray kAcross{.origin = vec3(0.2f, -4.0f, 0.1f), .direction = vec3(0.0f, 1.0f, 0.0f)};

}  // namespace

TEST_F(MatchedMedia, FogUnderAPointLightIsTheIntegralAlongTheRay) {
    balls = {{.medium = Fog(vec3(0.5f, 1.0f, 3.0f), vec3(0.9f, 0.5f, 0.99f), 0.5f)}};
    const vec3 light(0.5f, 1.0f, 2.5f);
    LightWithAPoint(light);
    ExpectMean(MeanRadiance(kAcross, 1u, 1u << 16), ScatteredOnce(kAcross, light, 8.0), "a ball of fog");
    // The ray may also start inside
    const Ray inside{.origin = vec3(0.2f, -0.5f, 0.1f), .direction = kAcross.direction};
    ExpectMean(MeanRadiance(inside, 1u, 1u << 16, EnterMedium(NoMedia(), 0u)),
               ScatteredOnce(inside, light, 4.0), "from within");
}

// Both in air and within a medium of index 1.33, one ball hides a part of another; a third one, which would
// refract, is hidden itself.
TEST_F(MatchedMedia, LightPassesTheMediaThatArePresent) {
    for (const float ior : {1.0f, 1.33f}) {
        balls = {{.medium = Fog(vec3(0.4f, 0.7f, 1.0f), vec3(0.9f), 0.3f, ior, 1u)},
                 {.center = vec3(0.3f, 0.0f, 0.8f),
                  .radius = 0.6f,
                  .medium = Fog(vec3(3.0f, 1.0f, 2.0f), vec3(0.6f), -0.2f, ior, 2u)},
                 {.center = vec3(0.0f, -0.2f, 0.0f),
                  .radius = 0.5f,
                  .medium = Fog(vec3(50.0f), vec3(0.0f), 0.0f, 1.7f, 0u)}};
        MediumStack around = NoMedia();
        if (ior > 1.0f) {
            balls.push_back({.radius = 50.0f, .medium = Fog(vec3(0.05f, 0.1f, 0.0f), vec3(0.0f), 0.0f, ior)});
            around = EnterMedium(around, 3u);
        }
        const vec3 light(0.5f, 0.5f, 2.5f);
        testLights = {};
        LightWithAPoint(light);
        ExpectMean(MeanRadiance(kAcross, 1u, 1u << 16, around), ScatteredOnce(kAcross, light, 8.0),
                   ior > 1.0f ? "in water" : "in air");
    }
}

TEST_F(MatchedMedia, BoundariesThatRefractStopShadowRays) {
    balls = {{.medium = Fog(vec3(1.0f), vec3(0.9f), 0.0f)},
             {.center = vec3(0.0f, 0.0f, 2.0f),
              .radius = 0.8f,
              .medium = Fog(vec3(0.0f), vec3(0.0f), 0.0f, 1.5f)}};
    LightWithAPoint(vec3(0.0f, 0.0f, 4.0f));
    const Mean mean = MeanRadiance({.origin = vec3(0.0f, -0.1f, 0.0f), .direction = vec3(0.0f, 1.0f, 0.0f)},
                                   1u, 1u << 8, EnterMedium(NoMedia(), 0u));
    EXPECT_EQ(mean.radiance, glm::dvec3(0.0));
}

TEST_F(MatchedMedia, CrossingIsNoBounce) {
    testLights.environmentTint = vec3(2.0f);
    balls = {{.medium = Fog(vec3(0.5f, 1.0f, 3.0f), vec3(0.0f), 0.0f)}};
    skin.roughness = 0.7f;  // has no effect
    const Ray through{.origin = vec3(0.0f, -4.0f, 0.0f), .direction = vec3(0.0f, 1.0f, 0.0f)};
    const Mean mean = MeanRadiance(through, 0u, 4u);
    for (int color = 0; color < 3; ++color)
        EXPECT_NEAR(mean.radiance[color], 2.0 * std::exp(-2.0 * double(balls[0].medium.extinction[color])),
                    1e-4);
}

// A small lamp and a small sun, through skins that pass all of the light or a part.
TEST_F(MatchedMedia, LightSamplingFindsThroughBoundariesWhatChanceFinds) {
    SurfaceMaterial milky = ClearSkin();
    milky.transmission = 0.7f;
    milky.metallic = 0.2f;
    milky.roughness = 0.5f;
    milky.clearcoat = 0.6f;
    milky.baseColor = vec3(0.9f, 0.6f, 0.8f);
    balls = {{.medium = Fog(vec3(0.5f, 1.0f, 2.0f), vec3(0.9f, 0.8f, 0.95f), 0.4f, 1.0f, 1u)},
             {.center = vec3(0.1f, 0.2f, 0.5f),
              .radius = 0.35f,
              .medium = Fog(vec3(3.0f, 2.0f, 0.5f), vec3(0.9f), 0.0f, 1.0f, 2u)},
             // Hidden in the first
             {.center = vec3(0.2f, -0.2f, 0.0f),
              .radius = 0.4f,
              .medium = Fog(vec3(50.0f), vec3(0.0f), 0.0f, 1.7f, 0u)}};
    hasLamp = true;
    testLights.AddTriangle(kLampCorners[0], kLampCorners[2], kLampCorners[1], vec3(40.0f));
    image::ImageF sky{.width = 16, .height = 8, .rgba = {}};
    for (uint32_t texel = 0; texel < 16 * 8; ++texel) {
        const float value = texel % 16 == 3 && texel / 16 == 2 ? 40.0f : 0.2f;
        sky.rgba.insert(sky.rgba.end(), {value, value, value, 1.0f});
    }
    testLights.SetEnvironment(sky, vec3(1.0f));
    testLights.Build();
    constexpr uint kSamples = 1u << 14, kMore = 4u;
    for (const bool isMilky : {false, true}) {
        skin = isMilky ? milky : ClearSkin();
        for (const uint depth : {1u, 6u}) {
            threadTraceFeatures = kFeatures;
            const Mean found = MeanRadiance(kAcross, depth, kMore * kSamples);
            threadTraceFeatures |= kTraceLightSampling | kTraceTriangleLights | kTraceEnvironmentLight;
            for (const MisHeuristic mis : {MisHeuristic::Power, MisHeuristic::Balance, MisHeuristic::Off}) {
                threadMisHeuristic = mis;
                const Mean sampled = MeanRadiance(kAcross, depth, kSamples);
                for (int color = 0; color < 3; ++color) {
                    const double error = std::hypot(found.error[color], sampled.error[color]);
                    EXPECT_LT(error, 0.06 * found.radiance[color]) << "too noisy to prove anything";
                    EXPECT_NEAR(sampled.radiance[color], found.radiance[color], 4.0 * error)
                        << "color " << color << ", depth " << depth << ", mis " << int(mis);
                }
                // With equally many samples, noise remains at boundaries that block light sampling. Without
                // MIS, a coat that reflects the lamp is noisy anyway
                if (isMilky && mis == MisHeuristic::Off) continue;
                EXPECT_LT(sampled.error.y, 0.4 * std::sqrt(kMore) * found.error.y) << "mis " << int(mis);
            }
        }
    }
}

}  // namespace raygraph::shading::matched_media_test

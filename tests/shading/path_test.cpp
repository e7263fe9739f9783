// The path integrator on the CPU: the very text the device runs, over a bridge of one analytic sphere and
// smooth thin walls above it.
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
    vec3 emission{0.0f};
    std::vector<float> walls{};  // heights
    bool hasLamp = false;
};
thread_local SphereScene scene;
constexpr uint kWall = 1u, kLamp = 2u;  // beside the sphere, 0
// So large that light sampling goes by area
const vec3 kLampCorners[3] = {vec3(-60.0f, -50.0f, 2.5f), vec3(60.0f, -50.0f, 2.5f), vec3(0.0f, 80.0f, 2.5f)};
const vec3 kLampRadiance(4.0f);
const vec3 kWallTint(0.9f, 0.7f, 0.5f);

SurfaceMaterial WallMaterial() {
    SurfaceMaterial material{};
    material.baseColor = kWallTint;
    material.specular = 1.0f;
    material.specularColor = vec3(1.0f);
    material.ior = 1.5f;
    material.transmission = 1.0f;
    return material;
}

// Radiance from everywhere, which the path finds by chance: the light table is left empty.
void SetScene(const SphereScene& values, float environment = 0.0f) {
    scene = values;
    testLights = {};
    testLights.environmentTint = vec3(environment);
}

Hit Intersect(Ray ray, uint) {
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

SurfaceInteraction SurfaceAt(Hit hit, Ray ray) {
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
            flat.material = WallMaterial();
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
    surface.material.baseColor = scene.albedo;
    surface.material.ior = 1.5f;
    return surface;
}

vec3 UnblockedShare(Ray ray, float distance, float ior, uint) {
    vec3 passed(1.0f);
    while (true) {
        const Hit hit = Intersect(ray, 0u);
        if (!IsHit(hit) || hit.t > distance) return passed;
        if (hit.instance != kWall) return vec3(0.0f);
        passed *= StraightShare(WallMaterial(), SettingOf(WallMaterial(), 1.5f / ior, 0.0f, 0u),
                                vec3(std::sqrt(1.0f - Sqr(ray.direction.z)), 0.0f, abs(ray.direction.z)));
        ray.origin += (hit.t + 1e-4f) * ray.direction;
        distance -= hit.t + 1e-4f;
    }
}

thread_local float extinction = 0.0f;
thread_local float mediumIor = 1.0f;

Medium MediumAt(uint) {
    return {.extinction = vec3(extinction),
            .scattering = vec3(0.0f),
            .anisotropy = 0.0f,
            .ior = mediumIor,
            .dispersion = 0.0f,
            .priority = 0u};
}

}  // namespace

}  // namespace raygraph::shading

// The bridge is declared: now the integrator over it.
#include "integrator/path.glsl"

namespace raygraph::shading {

namespace {

constexpr uint kNoLimit = 0xFFFFFFFFu;

// Other tests find the options as they were.
class Path : public ::testing::Test {
  protected:
    ~Path() override {
        threadTraceFeatures = m_features;
        threadBrdfModel = m_brdf;
        threadMisHeuristic = m_mis;
        threadRoulette = m_roulette;
    }

  private:
    const uint m_features = threadTraceFeatures;
    const BrdfModel m_brdf = threadBrdfModel;
    const MisHeuristic m_mis = threadMisHeuristic;
    const Roulette m_roulette = threadRoulette;
};

void UseOptions(uint features, BrdfModel brdf = BrdfModel::Gltf) {
    threadTraceFeatures = features | kTraceMetals | kTraceOpaque;
    threadBrdfModel = brdf;
    threadMisHeuristic = MisHeuristic::Power;
}

// Unbiased, and all materials Lambert's.
PathSettings Unbiased(uint maxDepth, uint rouletteStart) {
    UseOptions(0u, BrdfModel::Lambert);
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

Mean MeanRadiance(Ray ray, PathSettings settings, uint sampleCount) {
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

Ray FromCenter() {
    return {.origin = vec3(0.0f), .direction = normalize(vec3(0.3f, -0.5f, 0.7f))};
}

}  // namespace

TEST_F(Path, ClosedSphereHasRadianceOneOverOneMinusAlbedo) {
    for (const float albedo : {0.2f, 0.5f, 0.8f}) {
        SetScene({.albedo = vec3(albedo), .emission = vec3(1.0f)});
        const Mean mean = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 3u), 1u << 18);
        const double expected = 1.0 / (1.0 - albedo);
        EXPECT_NEAR(mean.radiance, expected, 4.0 * mean.standardError + 1e-4) << "albedo " << albedo;
        EXPECT_LT(mean.standardError, 0.005 * expected) << "too noisy to prove anything";
    }
}

TEST_F(Path, SphereInUnitEnvironmentReflectsItsAlbedo) {
    SetScene({.albedo = vec3(0.7f)}, 1.0f);
    const Ray ray{.origin = vec3(0.2f, 0.1f, 5.0f), .direction = vec3(0.0f, 0.0f, -1.0f)};
    const Mean mean = MeanRadiance(ray, Unbiased(kNoLimit, 100u), 4096);
    EXPECT_NEAR(mean.radiance, 0.7, 1e-5);
    EXPECT_EQ(mean.rays, 2.0) << "a convex body sends every path out after one bounce";
}

TEST_F(Path, RouletteChangesTheNoiseAndNotTheMean) {
    SetScene({.albedo = vec3(0.5f), .emission = vec3(1.0f)});
    const Mean early = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 1u), 1u << 18);
    const Mean late = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 16u), 1u << 16);
    EXPECT_NEAR(early.radiance, 2.0, 4.0 * early.standardError);
    EXPECT_NEAR(late.radiance, 2.0, 4.0 * late.standardError + 1e-3);
    EXPECT_LT(early.rays, late.rays);
}

TEST_F(Path, DepthLimitCutsTheGeometricSeries) {
    SetScene({.albedo = vec3(0.5f), .emission = vec3(1.0f)});
    for (const uint depth : {0u, 1u, 2u, 5u}) {
        const Mean mean = MeanRadiance(FromCenter(), Unbiased(depth, kNoLimit), 64);
        EXPECT_NEAR(mean.radiance, (1.0 - std::pow(0.5, depth + 1.0)) / 0.5, 1e-5) << "depth " << depth;
        EXPECT_EQ(mean.rays, depth + 1.0);
    }
}

TEST_F(Path, BlackSurfaceEndsThePath) {
    SetScene({.emission = vec3(3.0f)}, 1.0f);
    const Mean mean = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 3u), 16);
    EXPECT_EQ(mean.radiance, 3.0);
    EXPECT_EQ(mean.rays, 1.0);
}

TEST_F(Path, MissSeesTheEnvironmentWithoutAlpha) {
    SetScene({}, 2.0f);
    const Ray ray{.origin = vec3(0.0f, 0.0f, 5.0f), .direction = vec3(0.0f, 0.0f, 1.0f)};
    PathState path = StartPath(ray, StartPixelSample(uvec2(0u), 0u, 0u));
    EXPECT_FALSE(ExtendPath(path, Unbiased(kNoLimit, 3u)));
    EXPECT_EQ(path.radiance, vec3(2.0f));
    EXPECT_EQ(path.alpha, 0.0f);
}

// The sphere from above, in the middle of the picture.
Ray FromAbove() {
    return {.origin = vec3(0.0f, 0.0f, 5.0f), .direction = vec3(0.0f, 0.0f, -1.0f)};
}

TEST_F(Path, LightSamplingFindsTheLightThatChanceFinds) {
    SetScene({.albedo = vec3(0.7f)});
    image::ImageF sky{.width = 16, .height = 8, .rgba = {}};
    for (uint32_t texel = 0; texel < 16 * 8; ++texel) {
        const float value = texel % 16 == 3 && texel / 16 == 2 ? 40.0f : 0.2f;
        sky.rgba.insert(sky.rgba.end(), {value, value, value, 1.0f});
    }
    testLights.SetEnvironment(sky, vec3(1.0f));
    testLights.Build();
    const Ray ray{.origin = vec3(0.2f, 4.0f, 3.0f), .direction = normalize(vec3(0.0f, -4.0f, -3.0f))};
    PathSettings settings = Unbiased(kNoLimit, 100u);
    const Mean byChance = MeanRadiance(ray, settings, 1u << 18);
    ASSERT_LT(byChance.standardError, 0.01 * byChance.radiance);
    threadTraceFeatures = kTraceLightSampling | kTraceEnvironmentLight;
    for (const MisHeuristic mis : {MisHeuristic::Off, MisHeuristic::Balance, MisHeuristic::Power}) {
        threadMisHeuristic = mis;
        const Mean sampled = MeanRadiance(ray, settings, 1u << 16);
        const double error = std::hypot(sampled.standardError, byChance.standardError);
        EXPECT_NEAR(sampled.radiance, byChance.radiance, 4.0 * error) << "heuristic " << int(mis);
        EXPECT_LT(sampled.standardError, 0.02 * sampled.radiance) << "too noisy to prove anything";
    }
}

// Lambert and Beer: rho / pi I / d^2 exp(-sigma (d + c)), c from the eye to the surface.
TEST_F(Path, MediumDimsTheWayToTheLightAndToTheEye) {
    SetScene({.albedo = vec3(0.7f)});
    testLights.AddPunctual(scene::LightType::Point, vec3(0.0f, 0.0f, 4.0f), vec3(0.0f, 0.0f, -1.0f),
                           vec3(9.0f));
    testLights.Build();
    const PathSettings settings = Unbiased(kNoLimit, 100u);
    threadTraceFeatures = kTraceLightSampling | kTracePunctualLights | kTraceVolumes;
    extinction = 0.25f;
    PathState path = StartPath(FromAbove(), StartPixelSample(uvec2(0u), 0u, 0u));
    path.media = EnterMedium(NoMedia(), 0u);
    while (ExtendPath(path, settings)) {
    }
    extinction = 0.0f;
    const double expected = 0.7 * double(kInvPi) * 9.0 / (3.0 * 3.0) * std::exp(-0.25 * (3.0 + 4.0));
    EXPECT_NEAR(path.radiance.y, expected, 1e-4 * expected);
}

// Of what a wall of relative index eta does not reflect, by Schlick's curve.
double Passed(double eta, double cosine) {
    const double f0 = std::pow((eta - 1.0) / (eta + 1.0), 2.0);
    return (1.0 - f0) * (1.0 - std::pow(1.0 - cosine, 5.0));
}

TEST_F(Path, PointLightThroughWallsIsDimmedByEach) {
    for (const float ior : {1.0f, 1.33f}) {
        SetScene({.albedo = vec3(0.7f), .walls = {2.0f, 2.5f}});
        testLights.AddPunctual(scene::LightType::Point, vec3(0.0f, 0.0f, 4.0f), vec3(0.0f, 0.0f, -1.0f),
                               vec3(9.0f));
        testLights.Build();
        const PathSettings settings = Unbiased(1u, kNoLimit);
        UseOptions(~(kTraceProbeMedia | kTraceShadowTerminator));
        mediumIor = ior;
        const Ray ray{.origin = vec3(0.0f, 0.0f, 1.5f), .direction = vec3(0.0f, 0.0f, -1.0f)};
        PathState path = StartPath(ray, StartPixelSample(uvec2(0u), 0u, 0u));
        if (ior > 1.0f) path.media = EnterMedium(NoMedia(), 0u);
        while (ExtendPath(path, settings)) {
        }
        mediumIor = 1.0f;
        const double passed = std::pow(Passed(1.5 / ior, 1.0), 2.0);
        for (int channel = 0; channel < 3; ++channel) {
            const double expected = 0.7 * double(kInvPi) * passed * std::pow(double(kWallTint[channel]), 2.0);
            EXPECT_NEAR(path.radiance[channel], expected, 1e-4 * expected) << "index " << ior;
        }
    }
}

// Light behind walls is met with the densities of the last surface that scattered.
TEST_F(Path, LightSamplingFindsThroughWallsWhatChanceFinds) {
    SetScene({.albedo = vec3(0.7f), .walls = {1.5f, 1.7f}, .hasLamp = true});
    testLights.AddTriangle(kLampCorners[0], kLampCorners[1], kLampCorners[2], kLampRadiance, true);
    image::ImageF sky{.width = 16, .height = 8, .rgba = {}};
    for (uint32_t texel = 0; texel < 16 * 8; ++texel) {
        const float value = texel % 16 == 3 && texel / 16 == 2 ? 40.0f : 0.2f;
        sky.rgba.insert(sky.rgba.end(), {value, value, value, 1.0f});
    }
    testLights.SetEnvironment(sky, vec3(1.0f));
    testLights.Build();
    const Ray ray{.origin = vec3(0.2f, 1.5f, 1.2f), .direction = normalize(vec3(-0.1f, -1.2f, -0.4f))};
    for (const uint depth : {1u, kNoLimit}) {
        const PathSettings settings = Unbiased(depth, kNoLimit);
        UseOptions(kTraceThinWalls | kTraceGlass);
        const Mean byChance = MeanRadiance(ray, settings, 1u << 18);
        ASSERT_LT(byChance.standardError, 0.01 * byChance.radiance);
        threadTraceFeatures |= kTraceLightSampling | kTraceEnvironmentLight | kTraceTriangleLights;
        for (const MisHeuristic mis : {MisHeuristic::Off, MisHeuristic::Balance, MisHeuristic::Power}) {
            threadMisHeuristic = mis;
            const Mean sampled = MeanRadiance(ray, settings, 1u << 16);
            const double error = std::hypot(sampled.standardError, byChance.standardError);
            EXPECT_NEAR(sampled.radiance, byChance.radiance, 4.0 * error)
                << "heuristic " << int(mis) << ", depth " << depth;
            EXPECT_LT(sampled.standardError, 0.02 * sampled.radiance) << "too noisy to prove anything";
        }
    }
}

// Straight crossings move the ray's origin, and a lamp that is sampled by area has a density that grows with
// the square of the distance.
TEST_F(Path, SmallLampBehindAWallIsWeighedByTheWholeWay) {
    SetScene({});
    const float side = 0.01f, distance = 10.0f;
    const vec3 from(0.0f, 0.0f, 1.0f), corner(-0.002f, -0.002f, from.z + distance);
    testLights.AddTriangle(corner, corner + vec3(side, 0.0f, 0.0f), corner + vec3(0.0f, side, 0.0f),
                           vec3(4.0f), true);
    testLights.Build();
    const PathSettings settings = Unbiased(kNoLimit, kNoLimit);
    UseOptions(kTraceThinWalls | kTraceLightSampling | kTraceTriangleLights);
    for (const float crossed : {0.0f, 4.0f}) {
        const Ray ray{.origin = from + vec3(0.0f, 0.0f, crossed), .direction = vec3(0.0f, 0.0f, 1.0f)};
        PathState path = StartPath(ray, StartPixelSample(uvec2(0u), 0u, 0u));
        path.scatter.position = from;
        path.scatterPDF = distance * distance / (0.5f * side * side);  // that of light sampling
        CollectFound(path, vec3(4.0f), 0u, distance - crossed, settings);
        EXPECT_NEAR(path.radiance.y, 2.0f, 1e-3f) << "a wall at " << crossed;
    }
}

TEST_F(Path, CrossingAWallIsNoBounce) {
    SetScene({.albedo = vec3(0.7f), .emission = vec3(2.0f), .walls = {2.0f, 3.0f}});
    const PathSettings settings = Unbiased(0u, kNoLimit);
    UseOptions(kTraceThinWalls | kTraceGlass);
    const Mean mean = MeanRadiance(FromAbove(), settings, 1u << 14);
    const double expected = 2.0 * std::pow(double(kWallTint.y) * 0.96, 2.0);
    EXPECT_NEAR(mean.radiance, expected, 4.0 * mean.standardError);
    EXPECT_LT(mean.standardError, 0.005 * expected) << "too noisy to prove anything";
}

}  // namespace raygraph::shading

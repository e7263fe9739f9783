// The path integrator: energy, depth, roulette, media, and light through smooth thin walls.
#include <set>

#include "tests/shading/path_scene.h"

namespace raygraph::shading::path_test {

namespace {
class Path : public PathFixture {};
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

TEST_F(Path, RouletteLeavesPathsOfLittleThroughputAThird) {
    // Bounces survive with 0.99, 0.25 * 3 / 0.99, and then, at a third of throughput, with the albedo
    SetScene({.albedo = vec3(0.5f), .emission = vec3(1.0f)});
    const Mean mean = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 1u), 1u << 16);
    EXPECT_NEAR(mean.rays, 1.0 + 0.99 + 0.75 * 2.0, 0.03);
    PathState path = StartPath(FromCenter(), StartPixelSample(uvec2(0u), 0u, 0u));
    for (path.throughput = vec3(1.0e-3f); !SurviveRoulette(path, Unbiased(kNoLimit, 1u));)
        path.throughput = vec3(1.0e-3f);
    EXPECT_FLOAT_EQ(path.throughput.x, 1.0f / 3.0f);
}

TEST_F(Path, DirectionsOfEachTwoBouncesAreSpreadTogether) {
    const auto draw = [](uint sample, uint depth) {
        PathState path = StartPath({}, StartPixelSample(uvec2(8u, 3u), sample, 1u));
        path.depth = depth;
        return BounceDirectionSample(path);
    };
    const auto boxes = [&](uint first, uint second) {
        std::set<int> taken;
        for (uint sample = 0; sample < 256; ++sample) {
            const vec3 u = draw(sample, first);
            const vec3 v = draw(sample, second);
            taken.insert(((int(u.x * 4.0f) * 4 + int(u.y * 4.0f)) * 4 + int(v.x * 4.0f)) * 4 +
                         int(v.y * 4.0f));
        }
        return taken.size();
    };
    EXPECT_EQ(boxes(0, 1), 256u);
    EXPECT_EQ(boxes(2, 3), 256u);
    EXPECT_LT(boxes(1, 2), 220u) << "as many as 256 points at random take";
    EXPECT_LT(boxes(0, 3), 220u);
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

// Even but for one texel.
image::ImageF SkyWithALamp() {
    image::ImageF sky{.width = 16, .height = 8, .rgba = {}};
    for (uint32_t texel = 0; texel < 16 * 8; ++texel) {
        const float value = texel % 16 == 3 && texel / 16 == 2 ? 40.0f : 0.2f;
        sky.rgba.insert(sky.rgba.end(), {value, value, value, 1.0f});
    }
    return sky;
}

TEST_F(Path, LightSamplingFindsTheLightThatChanceFinds) {
    SetScene({.albedo = vec3(0.7f)});
    testLights.SetEnvironment(SkyWithALamp(), vec3(1.0f));
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

// Otherwise the environment's table would choose its smallest cells too seldom or too often.
TEST_F(Path, NumbersOfCandidatesAreMovedByExactlyAQuarterEach) {
    constexpr int kSteps = 1 << 24;
    for (const int step : {0, 1, kSteps / 4 - 1, kSteps / 4, kSteps / 2 + 1, 3 * kSteps / 4, kSteps - 1}) {
        const auto u = static_cast<float>(std::ldexp(double(step), -24));
        for (uint candidate = 0; candidate < kLightCandidates; ++candidate) {
            const vec3 v = CandidateSample(vec3(u), candidate);
            const int moved = kSteps / int(kLightCandidates) * int(candidate);
            const int across = (step + moved) % kSteps, back = (step + kSteps - moved) % kSteps;
            EXPECT_EQ(double(v.x), std::ldexp(double(across), -24)) << step << ", " << candidate;
            EXPECT_EQ(double(v.y), std::ldexp(double(across), -24)) << step << ", " << candidate;
            EXPECT_EQ(double(v.z), std::ldexp(double(back), -24)) << step << ", " << candidate;
        }
    }
}

// The light is chosen from several candidates (RIS).
TEST_F(Path, GlossySurfacesChooseAmongLightsWithoutBias) {
    for (const float metallic : {0.0f, 1.0f}) {
        SetScene({.albedo = vec3(0.7f), .metallic = metallic, .roughness = 0.5f});
        testLights.SetEnvironment(SkyWithALamp(), vec3(1.0f));
        testLights.Build();
        const Ray ray{.origin = vec3(0.2f, 4.0f, 3.0f), .direction = normalize(vec3(0.0f, -4.0f, -3.0f))};
        const PathSettings settings = Unbiased(kNoLimit, 100u);
        UseOptions({});
        const Mean byChance = MeanRadiance(ray, settings, 1u << 18);
        ASSERT_LT(byChance.standardError, 0.01 * byChance.radiance);
        UseOptions(kTraceLightSampling | kTraceEnvironmentLight);
        for (const MisHeuristic mis : {MisHeuristic::Off, MisHeuristic::Balance, MisHeuristic::Power}) {
            threadMisHeuristic = mis;
            const Mean sampled = MeanRadiance(ray, settings, 1u << 16);
            const double error = std::hypot(sampled.standardError, byChance.standardError);
            EXPECT_NEAR(sampled.radiance, byChance.radiance, 4.0 * error)
                << "heuristic " << int(mis) << ", metallic " << metallic;
            EXPECT_LT(sampled.standardError, 0.02 * sampled.radiance) << "too noisy to prove anything";
        }
    }
}

// Whichever code traces the shadow rays, some of which the lamp stops.
TEST_F(Path, RaysTracedAtOnePlaceGiveTheSamePaths) {
    SetScene({.albedo = vec3(0.7f), .hasLamp = true}, 0.5f);
    testLights.AddTriangle(kLampCorners[0], kLampCorners[1], kLampCorners[2], kLampRadiance, true);
    testLights.SetEnvironment({.width = 1, .height = 1, .rgba = {1.0f, 1.0f, 1.0f, 1.0f}}, vec3(0.5f));
    testLights.Build();
    const Ray ray{.origin = vec3(0.2f, 1.5f, 1.2f), .direction = normalize(vec3(-0.1f, -1.2f, -0.4f))};
    const PathSettings settings = Unbiased(kNoLimit, kNoLimit);
    threadTraceFeatures |= kTraceLightSampling | kTraceEnvironmentLight | kTraceTriangleLights;
    const Mean apart = MeanRadiance(ray, settings, 1024);
    threadLoopOptions = kLoopOneTrace;
    const Mean together = MeanRadiance(ray, settings, 1024);
    EXPECT_EQ(together.radiance, apart.radiance);
    EXPECT_EQ(together.rays, apart.rays);
    EXPECT_GT(apart.rays, 2.0) << "no light was sampled";
}

// Lambert and Beer: rho / pi I / d^2 exp(-sigma (d + c)), c from the eye to the surface.
TEST_F(Path, MediumDimsTheWayToTheLightAndToTheEye) {
    SetScene({.albedo = vec3(0.7f)});
    testLights.AddPunctual(scene::LightType::Point, vec3(0.0f, 0.0f, 4.0f), vec3(0.0f, 0.0f, -1.0f),
                           vec3(9.0f));
    testLights.Build();
    const PathSettings settings = Unbiased(kNoLimit, 100u);
    threadTraceFeatures = kTraceLightSampling | kTracePunctualLights | kTraceVolumes;
    ballExtinction = 0.25f;
    PathState path = StartPath(FromAbove(), StartPixelSample(uvec2(0u), 0u, 0u));
    path.media = EnterMedium(NoMedia(), 0u);
    while (ExtendPath(path, settings)) {
    }
    ballExtinction = 0.0f;
    const double expected = 0.7 * double(kInvPi) * 9.0 / (3.0 * 3.0) * std::exp(-0.25 * (3.0 + 4.0));
    EXPECT_NEAR(path.radiance.y, expected, 1e-4 * expected);
}

// Returns the fraction that a wall of relative index eta does not reflect, by Schlick's curve.
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
        UseOptions(~(kTraceProbeMedia | kTraceShadowTerminator | kTraceTextureLod | kTraceHiddenEnvironment));
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
        path.scatterPDF = distance * distance / (0.5f * side * side);  // the density of light sampling
        AddHitEmission(path, vec3(4.0f), 0u, 0u, distance - crossed, settings);
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

}  // namespace raygraph::shading::path_test

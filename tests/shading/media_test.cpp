// Media on the CPU: which of them a path is in, scattering, boundaries that do not refract, and dispersion.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "tests/shading/path_scene.h"
#include "tests/support/h_function.h"

namespace raygraph::shading::media_test {
namespace {

Medium Fog(vec3 extinction, vec3 albedo, float g, float ior = 1.0f, uint priority = 0u) {
    return {.extinction = extinction,
            .scattering = extinction * albedo,
            .anisotropy = g,
            .ior = ior,
            .dispersion = 0.0f,
            .priority = priority};
}

void AddPointLight(vec3 position) {
    testLights.AddPunctual(scene::LightType::Point, position, vec3(0.0f, 0.0f, -1.0f), vec3(9.0f));
    testLights.Build();
    threadTraceFeatures |= kTraceLightSampling | kTracePunctualLights;
}

// ------------------------------------------------------------------------------------ which medium a path is in

class Media : public PathFixture {};

// Media of these priorities, of indices 1.1, 1.2, ...
void SetMedia(const std::vector<uint>& priorities) {
    shapes.clear();
    for (size_t i = 0; i < priorities.size(); ++i)
        shapes.push_back(
            {.medium = Fog(vec3(0.0f), vec3(0.0f), 0.0f, 1.1f + 0.1f * float(i), priorities[i])});
}

TEST_F(Media, OneVolumeIsEnteredAndLeft) {
    SetMedia({0});
    const Boundary in = CrossBoundary(NoMedia(), 0, true);
    EXPECT_TRUE(in.isReal);
    EXPECT_FLOAT_EQ(RelativeIor(in, kNoWavelength), 1.1f);
    EXPECT_EQ(CurrentMedium(in.beyond), 0u);
    const Boundary out = CrossBoundary(in.beyond, 0, false);
    EXPECT_TRUE(out.isReal);
    EXPECT_FLOAT_EQ(RelativeIor(out, kNoWavelength), 1.0f / 1.1f);
    EXPECT_EQ(CurrentMedium(out.beyond), kVacuum);
}

TEST_F(Media, SurfaceOfLowerPriorityIsNotThere) {
    SetMedia({2, 1});
    const MediumStack glass = CrossBoundary(NoMedia(), 0, true).beyond;
    const Boundary water = CrossBoundary(glass, 1, true);
    EXPECT_FALSE(water.isReal);
    EXPECT_EQ(CurrentMedium(water.beyond), 0u);
    // Leaving the glass inside the water is a change from glass to water
    const Boundary out = CrossBoundary(water.beyond, 0, false);
    EXPECT_TRUE(out.isReal);
    EXPECT_FLOAT_EQ(RelativeIor(out, kNoWavelength), 1.2f / 1.1f);
    EXPECT_EQ(CurrentMedium(out.beyond), 1u);
}

TEST_F(Media, AmongEqualsTheLastEnteredIsThere) {
    SetMedia({1, 1, 1});
    MediumStack stack = NoMedia();
    for (const uint material : {0u, 1u, 2u}) {
        stack = CrossBoundary(stack, material, true).beyond;
        EXPECT_EQ(CurrentMedium(stack), material);
    }
    // One in the middle goes without a change
    const Boundary middle = CrossBoundary(stack, 1, false);
    EXPECT_FALSE(middle.isReal);
    EXPECT_EQ(CurrentMedium(middle.beyond), 2u);
    EXPECT_EQ(CurrentMedium(CrossBoundary(middle.beyond, 2, false).beyond), 0u);
}

TEST_F(Media, OrderOfEnteringDoesNotMatterWherePrioritiesDiffer) {
    SetMedia({3, 0, 7, 5});
    std::mt19937 random(1);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<uint> order{0, 1, 2, 3};
        std::shuffle(order.begin(), order.end(), random);
        MediumStack stack = NoMedia();
        for (const uint material : order) stack = EnterMedium(stack, material);
        std::shuffle(order.begin(), order.end(), random);
        for (const uint expected : {2u, 3u, 0u, 1u}) {
            ASSERT_EQ(CurrentMedium(stack), expected);
            stack = LeaveMedium(stack, expected);
        }
        ASSERT_EQ(CurrentMedium(stack), kVacuum);
    }
}

TEST_F(Media, VolumeThatWasNeverEnteredIsLeftFromWithin) {
    SetMedia({0});
    const Boundary out = CrossBoundary(NoMedia(), 0, false);
    EXPECT_TRUE(out.isReal);
    EXPECT_FLOAT_EQ(RelativeIor(out, kNoWavelength), 1.0f / 1.1f);
    EXPECT_EQ(CurrentMedium(out.beyond), kVacuum);
}

TEST_F(Media, MoreVolumesThanFitLoseTheOutermost) {
    SetMedia({0, 0, 0, 0, 0});
    MediumStack stack = NoMedia();
    for (uint material = 0; material < 5; ++material) stack = EnterMedium(stack, material);
    EXPECT_FALSE(IsInMedium(stack, 0));
    for (uint material = 4; material > 0; --material) {
        EXPECT_EQ(CurrentMedium(stack), material);
        stack = LeaveMedium(stack, material);
    }
    EXPECT_EQ(CurrentMedium(stack), kVacuum);
}

TEST_F(Media, LightFadesExponentially) {
    SetMedia({0});
    shapes[0].medium.extinction = vec3(0.0f, 1.0f, 3.0f);
    const vec3 passed = Transmittance(0, 0.5f);
    EXPECT_FLOAT_EQ(passed.x, 1.0f);
    EXPECT_NEAR(passed.y, std::exp(-0.5), 1e-6);
    EXPECT_NEAR(passed.z, std::exp(-1.5), 1e-6);
    EXPECT_EQ(Transmittance(kVacuum, 1e6f), vec3(1.0f));
}

// ----------------------------------------------------------------------------------------------- scattering

class Scattering : public PathFixture {
  protected:
    Scattering() : PathFixture(kTraceGlass | kTraceVolumes | kTraceScattering) {
        testLights.environmentTint = vec3(1.0f);
    }
    // The half space below z = 0, or a ball of radius 1.
    static void Use(Shape::Kind kind, const Medium& medium) {
        shapes = {{.kind = kind, .material = ClearMaterial(1.0f, kMaterialVolume), .medium = medium}};
    }
};

Ray From(float mu) {
    const vec3 up(sqrt(1.0f - mu * mu), 0.0f, mu);
    return {.origin = 2.0f * up, .direction = -up};
}

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
    Use(Shape::Kind::Plane, Fog(vec3(10.0f, 1.0f, 3.0f), albedo, 0.0f));
    for (const float mu : {1.0f, 0.3f}) {
        glm::dvec3 expected;
        for (int color = 0; color < 3; ++color)
            expected[color] = testing::HFunction(double{albedo[color]}).Reflected(mu);
        ExpectMean(MeanRadiance(From(mu), Unbiased(kNoLimit, 4u), 1u << 15), expected, 0.05);
    }
}

// Light that is scattered once: of the share that reaches a depth, the phase function sends some out again,
//     albedo integral of p(angle) mu / (mu + mu0) over the directions above.
TEST_F(Scattering, LightScatteredOnceFollowsThePhaseFunction) {
    constexpr double kAlbedo = 0.8, kMu0 = 0.4;
    for (const float g : {-0.5f, 0.0f, 0.7f}) {
        Use(Shape::Kind::Plane, Fog(vec3(2.0f), vec3(float(kAlbedo)), g));
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
        // Through the boundary, scattered, and out again
        ExpectMean(MeanRadiance(From(float(kMu0)), Unbiased(3u, 4u), 1u << 16), glm::dvec3(expected), 0.015);
    }
}

TEST_F(Scattering, SphereThatAbsorbsNothingIsNotSeenInUniformLight) {
    for (const float g : {0.0f, 0.8f}) {
        Use(Shape::Kind::Sphere, Fog(vec3(2.0f, 5.0f, 0.5f), vec3(1.0f), g));
        const Ray ray{.origin = vec3(0.3f, 0.0f, 3.0f), .direction = vec3(0.0f, 0.0f, -1.0f)};
        ExpectMean(MeanRadiance(ray, Unbiased(kNoLimit, 4u), 1u << 14), glm::dvec3(1.0), 0.02, 1e-4);
    }
}

// The medium is infinite; light goes from the lamp to a point of the ray, and from there to the eye.
TEST_F(Scattering, PointLightInFogIsTheIntegralAlongTheRay) {
    testLights.environmentTint = vec3(0.0f);
    AddPointLight(vec3(0.5f, 0.0f, -1.0f));
    const float g = 0.6f;
    const double sigma = 0.7, albedo = 0.9;
    Use(Shape::Kind::Plane, Fog(vec3(float(sigma)), vec3(float(albedo)), g));
    double expected = 0.0;
    constexpr double kStep = 1e-4;
    for (double t = 0.5 * kStep; t < 40.0; t += kStep) {
        const glm::dvec2 toLight(0.5, t - 0.999);
        const double distance = glm::length(toLight);
        const double cosTheta = toLight.y / distance;  // to the direction of the ray, which is -z
        expected += double(PhaseHG(g, float(-cosTheta))) * 9.0 / (distance * distance) *
                    std::exp(-sigma * (t + distance)) * sigma * albedo * kStep;
    }
    // Down: the plane is behind
    const Ray ray{.origin = vec3(0.0f, 0.0f, -1e-3f), .direction = vec3(0.0f, 0.0f, -1.0f)};
    ExpectMean(MeanRadiance(ray, Unbiased(1u, 4u), 1u << 16, EnterMedium(NoMedia(), 0u)),
               glm::dvec3(expected), 0.01, 0.0);
}

// A lamp in fog without an end, and a small lamp and a small sun through skins that pass all of the light or a part.
// With equally many samples, noise remains at boundaries that block light sampling. Without MIS, a coat that reflects
// the lamp is noisy anyway.
void ExpectSamplingBeatsChance(const Ray& ray, uint depth, uint more, MediumStack media, TraceFeatures lights,
                               const std::vector<MisHeuristic>& heuristics, bool isNoisyWithoutMis) {
    constexpr uint kSamples = 1u << 14;
    const PathSettings settings = Unbiased(depth, 8u);
    const TraceFeatures features = threadTraceFeatures;
    const Mean found = MeanRadiance(ray, settings, more * kSamples, media);
    threadTraceFeatures |= kTraceLightSampling | lights;
    for (const MisHeuristic mis : heuristics) {
        SCOPED_TRACE("heuristic " + std::to_string(int(mis)));
        threadMisHeuristic = mis;
        const Mean sampled = MeanRadiance(ray, settings, kSamples, media);
        for (int color = 0; color < 3; ++color) {
            const double error = std::hypot(found.error[color], sampled.error[color]);
            EXPECT_LT(error, 0.06 * found.radiance[color]) << "too noisy to prove anything";
            EXPECT_NEAR(sampled.radiance[color], found.radiance[color], 4.0 * error) << "color " << color;
        }
        if (isNoisyWithoutMis && mis == MisHeuristic::Off) continue;
        EXPECT_LT(sampled.error.y, 0.4 * std::sqrt(double(more)) * found.error.y);
    }
    threadTraceFeatures = features;
}

TEST_F(Scattering, LampInFogIsFoundBySamplingAsByChance) {
    testLights.environmentTint = vec3(0.0f);
    shapes.clear();
    AddLamp({vec3(-2.0f, -2.0f, 1.5f), vec3(2.0f, -2.0f, 1.5f), vec3(0.0f, 3.0f, 1.5f)}, vec3(4.0f), false);
    shapes[0].medium = Fog(vec3(0.5f, 0.2f, 1.0f), vec3(0.9f, 0.5f, 0.8f), 0.4f);
    testLights.Build();
    const Ray ray{.origin = vec3(0.0f), .direction = normalize(vec3(1.0f, 0.1f, -0.3f))};
    ExpectSamplingBeatsChance(ray, 6u, 8u, EnterMedium(NoMedia(), 0u), kTraceTriangleLights,
                              {MisHeuristic::Power, MisHeuristic::Balance}, false);
}

// ------------------------------------------------------------------------------ boundaries that do not refract

class MatchedMedia : public PathFixture {
  protected:
    MatchedMedia()
        : PathFixture(kTraceGlass | kTraceVolumes | kTraceScattering | kTraceMatchedMedia | kTraceClearcoat) {
    }

    static void AddBall(vec3 center, float radius, const Medium& medium,
                        SurfaceMaterial skin = ClearMaterial(1.0f, kMaterialVolume)) {
        skin.ior = medium.ior;
        shapes.push_back({.center = center, .radius = radius, .material = skin, .medium = medium});
    }
};

// The medium at a point: of the balls around it the one of highest priority.
std::optional<Medium> PresentAt(const glm::dvec3& at) {
    std::optional<Medium> present;
    for (const Shape& ball : shapes)
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

const Ray kAcross{.origin = vec3(0.2f, -4.0f, 0.1f), .direction = vec3(0.0f, 1.0f, 0.0f)};

TEST_F(MatchedMedia, FogUnderAPointLightIsTheIntegralAlongTheRay) {
    AddBall(vec3(0.0f), 1.0f, Fog(vec3(0.5f, 1.0f, 3.0f), vec3(0.9f, 0.5f, 0.99f), 0.5f));
    const vec3 light(0.5f, 1.0f, 2.5f);
    AddPointLight(light);
    ExpectMean(MeanRadiance(kAcross, Unbiased(1u, 8u), 1u << 16), ScatteredOnce(kAcross, light, 8.0));
    // The ray may also start inside
    const Ray inside{.origin = vec3(0.2f, -0.5f, 0.1f), .direction = kAcross.direction};
    ExpectMean(MeanRadiance(inside, Unbiased(1u, 8u), 1u << 16, EnterMedium(NoMedia(), 0u)),
               ScatteredOnce(inside, light, 4.0));
}

// Both in air and within a medium of index 1.33, one ball hides a part of another; a third one, which would
// refract, is hidden itself.
TEST_F(MatchedMedia, LightPassesTheMediaThatArePresent) {
    for (const float ior : {1.0f, 1.33f}) {
        SCOPED_TRACE(ior);
        shapes.clear();
        AddBall(vec3(0.0f), 1.0f, Fog(vec3(0.4f, 0.7f, 1.0f), vec3(0.9f), 0.3f, ior, 1u));
        AddBall(vec3(0.3f, 0.0f, 0.8f), 0.6f, Fog(vec3(3.0f, 1.0f, 2.0f), vec3(0.6f), -0.2f, ior, 2u));
        AddBall(vec3(0.0f, -0.2f, 0.0f), 0.5f, Fog(vec3(50.0f), vec3(0.0f), 0.0f, 1.7f, 0u));
        MediumStack around = NoMedia();
        if (ior > 1.0f) {
            AddBall(vec3(0.0f), 50.0f, Fog(vec3(0.05f, 0.1f, 0.0f), vec3(0.0f), 0.0f, ior));
            around = EnterMedium(around, 3u);
        }
        const vec3 light(0.5f, 0.5f, 2.5f);
        testLights = {};
        AddPointLight(light);
        ExpectMean(MeanRadiance(kAcross, Unbiased(1u, 8u), 1u << 16, around),
                   ScatteredOnce(kAcross, light, 8.0));
    }
}

TEST_F(MatchedMedia, BoundariesThatRefractStopShadowRays) {
    AddBall(vec3(0.0f), 1.0f, Fog(vec3(1.0f), vec3(0.9f), 0.0f));
    AddBall(vec3(0.0f, 0.0f, 2.0f), 0.8f, Fog(vec3(0.0f), vec3(0.0f), 0.0f, 1.5f));
    AddPointLight(vec3(0.0f, 0.0f, 4.0f));
    const Ray ray{.origin = vec3(0.0f, -0.1f, 0.0f), .direction = vec3(0.0f, 1.0f, 0.0f)};
    EXPECT_EQ(MeanRadiance(ray, Unbiased(1u, 8u), 1u << 8, EnterMedium(NoMedia(), 0u)).radiance,
              glm::dvec3(0.0));
}

TEST_F(MatchedMedia, CrossingIsNoBounce) {
    testLights.environmentTint = vec3(2.0f);
    AddBall(vec3(0.0f), 1.0f, Fog(vec3(0.5f, 1.0f, 3.0f), vec3(0.0f), 0.0f));
    shapes[0].material.roughness = 0.7f;  // has no effect
    const Ray through{.origin = vec3(0.0f, -4.0f, 0.0f), .direction = vec3(0.0f, 1.0f, 0.0f)};
    const Mean mean = MeanRadiance(through, Unbiased(0u, 8u), 4u);
    for (int color = 0; color < 3; ++color)
        EXPECT_NEAR(mean.radiance[color], 2.0 * std::exp(-2.0 * double(shapes[0].medium.extinction[color])),
                    1e-4);
}

TEST_F(MatchedMedia, LightSamplingFindsThroughBoundariesWhatChanceFinds) {
    SurfaceMaterial milky = ClearMaterial(1.0f, kMaterialVolume);
    milky.transmission = 0.7f;
    milky.metallic = 0.2f;
    milky.roughness = 0.5f;
    milky.clearcoat = 0.6f;
    milky.baseColor = vec3(0.9f, 0.6f, 0.8f);
    for (const bool isMilky : {false, true}) {
        SCOPED_TRACE(isMilky ? "milky" : "clear");
        const SurfaceMaterial skin = isMilky ? milky : ClearMaterial(1.0f, kMaterialVolume);
        shapes.clear();
        testLights = {};
        AddBall(vec3(0.0f), 1.0f, Fog(vec3(0.5f, 1.0f, 2.0f), vec3(0.9f, 0.8f, 0.95f), 0.4f, 1.0f, 1u), skin);
        AddBall(vec3(0.1f, 0.2f, 0.5f), 0.35f, Fog(vec3(3.0f, 2.0f, 0.5f), vec3(0.9f), 0.0f, 1.0f, 2u), skin);
        // Hidden in the first
        AddBall(vec3(0.2f, -0.2f, 0.0f), 0.4f, Fog(vec3(50.0f), vec3(0.0f), 0.0f, 1.7f, 0u), skin);
        AddLamp({vec3(-0.3f, -0.3f, 3.0f), vec3(0.3f, -0.3f, 3.0f), vec3(0.0f, 0.4f, 3.0f)}, vec3(40.0f),
                false);
        testLights.SetEnvironment(SkyWithALamp(), vec3(1.0f));
        testLights.Build();
        for (const uint depth : {1u, 6u})
            ExpectSamplingBeatsChance(
                kAcross, depth, 4u, NoMedia(), kTraceTriangleLights | kTraceEnvironmentLight,
                {MisHeuristic::Power, MisHeuristic::Balance, MisHeuristic::Off}, isMilky);
    }
}

// ----------------------------------------------------------------------------------------------- dispersion

constexpr float kIor = 1.6f;
const PathSettings kSettings = Unbiased(8u, 100u);

// Glass below z = 0, without an end, under a film, and in it at z = -1 a black floor that emits 3 + x.
class Dispersion : public PathFixture {
  protected:
    Dispersion() : PathFixture(kTraceGlass | kTraceVolumes | kTraceDispersion) { UseGlass(0.0f, 0.0f); }

    static void UseGlass(float dispersion, float filmWeight) {
        Shape glass{.kind = Shape::Kind::Plane, .material = ClearMaterial(kIor, kMaterialVolume)};
        glass.material.iridescence = filmWeight;
        glass.material.iridescenceIor = 1.0f;
        glass.material.iridescenceThickness = 500.0f;
        glass.medium.ior = kIor;
        glass.medium.dispersion = dispersion;
        shapes = {glass, {.kind = Shape::Kind::Plane, .height = -1.0f}};
        shapes[1].emission = [](vec3 position, bool) { return vec3(3.0f + position.x); };
        shapes[1].material.ior = 1.5f;
    }
};

// The integral of a function of the wavelength over each color's band.
glm::dvec3 OverBands(const std::function<double(double)>& value) {
    glm::dvec3 sum(0.0);
    for (double wavelength = 250.5; wavelength < 900.0; ++wavelength)
        sum += glm::dvec3(BandDensity(float(wavelength))) * value(wavelength);
    return sum;
}

// The color matching functions are the fits by Wyman, Sloan and Shirley 2013, "Simple Analytic Approximations
// to the CIE XYZ Color Matching Functions", equation 4, with the matrix of linear sRGB.
TEST_F(Dispersion, BandsHaveMeanAndDeviationOfTheColorMatchingFunctions) {
    const auto lobe = [](double x, double center, double below, double above) {
        const double t = (x - center) * (x < center ? below : above);
        return std::exp(-0.5 * t * t);
    };
    glm::dvec3 sums(0.0), means(0.0), squares(0.0);
    for (double l = 380.0; l < 780.0; ++l) {
        const double x = 0.362 * lobe(l, 442.0, 0.0624, 0.0374) + 1.056 * lobe(l, 599.8, 0.0264, 0.0323) -
                         0.065 * lobe(l, 501.1, 0.0490, 0.0382);
        const double y = 0.821 * lobe(l, 568.8, 0.0213, 0.0247) + 0.286 * lobe(l, 530.9, 0.0613, 0.0322);
        const double z = 1.217 * lobe(l, 437.0, 0.0845, 0.0278) + 0.681 * lobe(l, 459.0, 0.0385, 0.0725);
        glm::dvec3 rgb(3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                       -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                       0.0556434 * x - 0.2040259 * y + 1.0572252 * z);
        rgb = glm::max(rgb, 0.0);
        if (l < 480.0) rgb.x = 0.0;  // the violet part
        sums += rgb;
        means += l * rgb;
        squares += l * l * rgb;
    }
    means /= sums;
    for (int color = 0; color < 3; ++color) {
        const double deviation = std::sqrt(squares[color] / sums[color] - means[color] * means[color]);
        EXPECT_NEAR(kBandMean[color], means[color], 0.2) << color;
        EXPECT_NEAR(kBandScale[color], deviation * std::sqrt(3.0) / double(kPi), 0.02) << color;
    }
}

TEST_F(Dispersion, SharesOfTheWavelengthsDrawnHaveTheMeanOne) {
    constexpr uint kCount = 1u << 18;
    glm::dvec3 sum(0.0), middle(0.0);
    for (uint i = 0; i < kCount; ++i) {
        const float wavelength = SampleWavelength((float(i) + 0.5f) / float(kCount));
        const vec3 share = WavelengthShare(wavelength);
        ASSERT_NEAR(share.x + share.y + share.z, 3.0f, 1e-5f) << wavelength;
        sum += glm::dvec3(share);
        middle += glm::dvec3(share) * double(wavelength);
    }
    for (int color = 0; color < 3; ++color) {
        EXPECT_NEAR(sum[color] / kCount, 1.0, 1e-4) << color;
        EXPECT_NEAR(middle[color] / kCount, kBandMean[color], 0.05) << color;
    }
    const glm::dvec3 whole = OverBands([](double) { return 1.0; });
    for (int color = 0; color < 3; ++color) EXPECT_NEAR(whole[color], 1.0, 1e-4) << color;
}

TEST_F(Dispersion, IndexHasTheAbbeNumberThatTheFileSays) {
    for (const float abbe : {20.0f, 55.0f, 89.0f}) {
        const float value = 20.0f / abbe;
        const float d = DispersedIor(kIor, value, 587.56f);
        EXPECT_NEAR(d, kIor, 2e-5f * value);
        const double spread =
            double{DispersedIor(kIor, value, 486.13f)} - double{DispersedIor(kIor, value, 656.27f)};
        EXPECT_NEAR((kIor - 1.0) / spread, abbe, 1e-3 * abbe);
    }
    EXPECT_EQ(DispersedIor(kIor, 7.0f, kNoWavelength), kIor);
    EXPECT_EQ(DispersedIor(1.1f, 100.0f, 1200.0f), 1.0f) << "not below that of vacuum";
}

// Through the surface, refracted by Snell's law at each wavelength, to the floor: the mean of a function that is
// linear in the place that is seen there, times what Fresnel's law lets pass.
TEST_F(Dispersion, ColorsSeeTheFloorWhereTheirWavelengthsRefractTo) {
    const double sinI = std::sin(1.1), cosI = std::cos(1.1);
    const Ray ray{.origin = vec3(-sinI, 0.0f, cosI), .direction = vec3(sinI, 0.0f, -cosI)};
    for (const float value : {0.36f, 4.0f}) {
        UseGlass(value, 0.0f);
        const glm::dvec3 expected = OverBands([&](double wavelength) {
            const double n = DispersedIor(kIor, value, float(wavelength));
            const double sinT = sinI / n;
            const double f0 = std::pow((n - 1.0) / (n + 1.0), 2.0);
            const double passed = (1.0 - f0) * (1.0 - std::pow(1.0 - cosI, 5.0));
            return passed / (n * n) * (3.0 + sinT / std::sqrt(1.0 - sinT * sinT));
        });
        ExpectMean(MeanRadiance(ray, kSettings, 1u << 16), expected, 0.01, 2e-4);
        EXPECT_GT(expected.x - expected.z, 20.0 * 0.001 * double{value}) << "nothing to see";
    }
}

// Without dispersion no wavelength is drawn: a path keeps all colors.
TEST_F(Dispersion, PathsThroughOtherGlassKeepAllColors) {
    const Ray ray{.origin = vec3(0.0f, 0.0f, 1.0f), .direction = normalize(vec3(0.4f, 0.0f, -1.0f))};
    for (uint i = 0; i < 64u; ++i) {
        PathState path = StartPath(ray, StartPixelSample(uvec2(3u, 5u), i, 9u));
        while (ExtendPath(path, kSettings)) {
        }
        EXPECT_EQ(path.wavelength, kNoWavelength);
        EXPECT_EQ(path.throughput.x, path.throughput.z);
        EXPECT_EQ(path.radiance.x, path.radiance.z);
    }
}

// A film of the index of what is before it is not there, at any wavelength: its index is relative to that of the
// path's own.
TEST_F(Dispersion, FilmOfTheIndexOfAirChangesNothing) {
    threadTraceFeatures |= kTraceIridescence;
    testLights.environmentTint = vec3(1.0f);
    for (const bool isInside : {false, true}) {
        const Ray ray{.origin = vec3(0.0f, 0.0f, isInside ? -0.5f : 1.0f),
                      .direction = normalize(vec3(0.4f, 0.0f, isInside ? 1.0f : -1.0f))};
        const auto seen = [&](float filmWeight) {
            UseGlass(5.0f, filmWeight);
            return MeanRadiance(ray, kSettings, 4096u, isInside ? EnterMedium(NoMedia(), 0u) : NoMedia())
                .radiance;
        };
        const glm::dvec3 with = seen(1.0f), without = seen(0.0f);
        for (int color = 0; color < 3; ++color)
            EXPECT_NEAR(with[color], without[color], 2e-4 * without[color]) << isInside << ", " << color;
    }
}

}  // namespace
}  // namespace raygraph::shading::media_test

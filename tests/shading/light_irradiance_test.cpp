// Irradiance by sampling lights against closed forms, with every light sampler.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/rng.glsl"
#include "tests/shading/light_scene.h"

namespace raygraph::shading::light_irradiance_test {
namespace {

constexpr std::array kSamplers = {LightSampler::Uniform, LightSampler::Power, LightSampler::Bvh};
constexpr double kTolerance = 0.005;

struct Estimate {
    double mean = 0.0;
    double variance = 0.0;  // variance of one sample
};

// Irradiance (green) on the upper side of the plane of `normal`; nothing is in between.
Estimate Irradiance(vec3 position, vec3 normal, uint sampleCount, uint seed = 1) {
    const LightContext context{position, normal};
    double sum = 0.0, squares = 0.0;
    for (uint i = 0; i < sampleCount; ++i) {
        Sampler rng = StartPixelSample(uvec2(3u, 5u), i, seed);
        const float uc = Get1D(rng);
        const LightSample s = SampleLight(context, uc, Get2D(rng));
        const float cosine = dot(s.wi, normal);
        if (s.pdf == 0.0f || cosine <= 0.0f) continue;
        const double value = double(s.radiance.y * cosine / s.pdf);
        sum += value;
        squares += value * value;
    }
    const double mean = sum / sampleCount;
    return {mean, squares / sampleCount - mean * mean};
}

void ExpectIrradiance(vec3 position, vec3 normal, double expected, uint sampleCount = 1u << 15) {
    for (const LightSampler sampler : kSamplers) {
        threadLightSampler = sampler;
        EXPECT_NEAR(Irradiance(position, normal, sampleCount).mean, expected, kTolerance * expected)
            << "sampler " << int(sampler);
    }
    threadLightSampler = LightSampler::Bvh;
}

const vec3 kUp(0.0f, 0.0f, 1.0f);

TEST(Irradiance, PointLightGivesIntensityTimesCosineOverSquaredDistance) {
    testLights = {};
    testLights.AddPunctual(scene::LightType::Point, vec3(1, 2, 3), kUp, vec3(7.0f));
    testLights.Build();
    ExpectIrradiance(vec3(0.0f), kUp, 7.0 * 3.0 / std::pow(14.0, 1.5), 16);
}

TEST(Irradiance, PointLightFollowsTheSquareOfItsDistanceFromNearToFar) {
    for (float distance = 1e-7f; distance < 2e3f; distance *= 10.0f) {
        testLights = {};
        testLights.AddPunctual(scene::LightType::Point, vec3(0, 0.6f, 0.8f) * distance, kUp, vec3(7.0f));
        testLights.Build();
        ExpectIrradiance(vec3(0.0f), kUp, 7.0 * 0.8 / (double(distance) * double(distance)), 16);
    }
}

TEST(Irradiance, SpotFallsOffAsItsExtensionSays) {
    // clamp((cos - cos outer) / (cos inner - cos outer), 0, 1)^2, at angles within, between and beyond
    constexpr double kInner = 0.3, kOuter = 0.8;
    for (const double angle : {0.0, 0.2, 0.4, 0.6, 0.75, 0.79}) {
        testLights = {};
        testLights.AddPunctual(scene::LightType::Spot, vec3(0, 0, 2), -kUp, vec3(5.0f), float(kInner),
                               float(kOuter));
        testLights.Build();
        const double falloff = std::clamp(
            (std::cos(angle) - std::cos(kOuter)) / (std::cos(kInner) - std::cos(kOuter)), 0.0, 1.0);
        const double distance = 2.0 / std::cos(angle);
        ExpectIrradiance(vec3(float(2.0 * std::tan(angle)), 0.0f, 0.0f), kUp,
                         5.0 * falloff * falloff * std::cos(angle) / (distance * distance), 16);
    }
    EXPECT_EQ(Irradiance(vec3(3, 0, 0), kUp, 16).mean, 0.0) << "beyond the outer cone";
}

TEST(Irradiance, DirectionalLightGivesItsLuxTimesCosine) {
    testLights = {};
    testLights.AddPunctual(scene::LightType::Directional, vec3(0.0f), normalize(vec3(1, 0, -2)), vec3(3.0f));
    testLights.Build();
    ExpectIrradiance(vec3(5, 6, 7), kUp, 3.0 * 2.0 / std::sqrt(5.0), 16);
}

void AddQuad(vec3 corner, vec3 x, vec3 y, vec3 radiance) {
    testLights.AddTriangle(corner, corner + x, corner + x + y, radiance);
    testLights.AddTriangle(corner, corner + x + y, corner + y, radiance);
}

// Form factor of a small patch to a parallel rectangle with one corner above it (Howell, A Catalog of
// Radiation Heat Transfer Configuration Factors, B-4), sides a and b at height 1.
double CornerFormFactor(double a, double b) {
    const double ra = std::sqrt(1.0 + a * a), rb = std::sqrt(1.0 + b * b);
    return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / (2.0 * M_PI);
}

TEST(Irradiance, QuadGivesItsFormFactorTimesPi) {
    // The quad covers (-1..2) x (-0.5..1) and faces down; its diagonal, an edge of both triangles, is above
    // the origin
    for (const float height : {1e-3f, 0.05f, 0.5f, 2.0f, 100.0f}) {
        testLights = {};
        AddQuad(vec3(-1, -0.5f, height), vec3(0, 1.5f, 0), vec3(3, 0, 0), vec3(2.0f));
        testLights.Build();
        const double h = double(height);
        const double factor = CornerFormFactor(1 / h, 0.5 / h) + CornerFormFactor(2 / h, 0.5 / h) +
                              CornerFormFactor(1 / h, 1 / h) + CornerFormFactor(2 / h, 1 / h);
        ExpectIrradiance(vec3(0.0f), kUp, 2.0 * M_PI * factor);
        EXPECT_EQ(Irradiance(vec3(0, 0, 2 * height), -kUp, 64).mean, 0.0) << "from behind";
    }
}

// Lamps from 1e-12 m to 1e12 m in size give the same irradiance as a lamp of 1 m.
TEST(Irradiance, OfAQuadIsTheSameInAllSizes) {
    for (const float size : {0x1p-40f, 0x1p-30f, 0x1p32f, 0x1p40f}) {
        testLights = {};
        testLights.scene.radius = size;
        AddQuad(size * vec3(-1, -0.5f, 0.5f), size * vec3(0, 1.5f, 0), size * vec3(3, 0, 0), vec3(2.0f));
        testLights.Build();
        const double factor =
            CornerFormFactor(2, 1) + CornerFormFactor(4, 1) + CornerFormFactor(2, 2) + CornerFormFactor(4, 2);
        ExpectIrradiance(vec3(0.0f), kUp, 2.0 * M_PI * factor);
    }
}

TEST(Irradiance, SphereOfTrianglesGivesPiTimesTheSquareOfItsSine) {
    testLights = {};
    constexpr int kRings = 48, kSegments = 96;
    const auto at = [](int ring, int segment) {
        const float theta = kPi * float(ring) / float(kRings);
        const float phi = kTwoPi * float(segment % kSegments) / float(kSegments);
        return vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    };
    for (int ring = 0; ring < kRings; ++ring)
        for (int segment = 0; segment < kSegments; ++segment) {
            testLights.AddTriangle(at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1),
                                   vec3(1.5f));
            testLights.AddTriangle(at(ring, segment), at(ring + 1, segment + 1), at(ring, segment + 1),
                                   vec3(1.5f));
        }
    testLights.Build();
    const vec3 position(1.2f, -2.0f, 1.0f);
    const double square = double(dot(position, position));
    ExpectIrradiance(position, -normalize(position), 1.5 * M_PI / square, 1u << 17);
}

TEST(Irradiance, ConstantEnvironmentGivesPiTimesItsRadiance) {
    testLights = {};
    testLights.environmentTint = vec3(2.0f);
    testLights.Build();
    ExpectIrradiance(vec3(0.0f), normalize(vec3(1, 2, 3)), 2.0 * M_PI);
}

// A dim sky with a disc of 2 degrees' radius, far above what a half float holds, about `sun` (rotation 0).
image::ImageF SkyWithDisc(vec3 sun) {
    image::ImageF map{.width = 512, .height = 256, .rgba = {}};
    for (uint32_t y = 0; y < map.height; ++y)
        for (uint32_t x = 0; x < map.width; ++x) {
            const vec2 uv((float(x) + 0.5f) / float(map.width), (float(y) + 0.5f) / float(map.height));
            const bool isSun = dot(DirectionFromEquirect(uv, 0.0f), sun) > std::cos(0.035f);
            const float value = isSun ? 2e5f : 0.1f + 0.1f * uv.y;
            map.rgba.insert(map.rgba.end(), {value, value, value, 1.0f});
        }
    return map;
}

// Computes the irradiance by quadrature over the interpolated map, with 16 points per texel.
double EnvironmentIrradiance(vec3 normal) {
    const uint32_t columns = 4 * testLights.map.width, rows = 4 * testLights.map.height;
    double sum = 0.0;
    for (uint32_t row = 0; row < rows; ++row) {
        const float v = (float(row) + 0.5f) / float(rows);
        const double solidAngle = 2.0 * M_PI * M_PI / columns / rows * std::sin(M_PI * double(v));
        for (uint32_t column = 0; column < columns; ++column) {
            const vec2 uv((float(column) + 0.5f) / float(columns), v);
            const vec3 d = DirectionFromEquirect(uv, testLights.scene.environmentRotation);
            sum += solidAngle * std::max(0.0, double(dot(d, normal))) * double(EnvironmentRadiance(d).y);
        }
    }
    return sum;
}

TEST(Irradiance, EnvironmentWithASmallBrightDiscAgreesWithQuadrature) {
    const vec3 normal = normalize(vec3(0.1f, 1.0f, -0.3f));
    testLights = {};
    testLights.SetEnvironment(SkyWithDisc(normalize(vec3(1, 1, 0.2f))), vec3(1.0f));
    testLights.Build();
    ExpectIrradiance(vec3(0.0f), normal, EnvironmentIrradiance(normal), 1u << 14);
}

TEST(Irradiance, RotationTurnsTheEnvironmentAndNothingElse) {
    const image::ImageF map = SkyWithDisc(normalize(vec3(1.0f, 0.8f, 0.0f)));  // towards +x
    testLights = {};
    testLights.SetEnvironment(map, vec3(1.0f));
    testLights.Build();
    const double towardsX = EnvironmentIrradiance(vec3(1, 0, 0));
    ExpectIrradiance(vec3(0.0f), vec3(1, 0, 0), towardsX, 1u << 14);
    testLights.SetEnvironment(map, vec3(1.0f), kPiOver2);  // the texel of +x is at -z
    testLights.Build();
    ExpectIrradiance(vec3(0.0f), vec3(0, 0, -1), towardsX, 1u << 14);
    EXPECT_LT(Irradiance(vec3(0.0f), vec3(0, 0, 1), 1u << 14).mean, 0.01 * towardsX);
}

TEST(Irradiance, AllKindsTogetherAddUp) {
    testLights = {};
    testLights.scene.radius = 2.0f;
    AddQuad(vec3(-1, -1, 2), vec3(0, 2, 0), vec3(2, 0, 0), vec3(1.0f));
    testLights.AddPunctual(scene::LightType::Point, vec3(1, 0, 1), kUp, vec3(1.0f));
    testLights.AddPunctual(scene::LightType::Directional, vec3(0.0f), -kUp, vec3(0.5f));
    testLights.environmentTint = vec3(0.2f);
    testLights.Build();
    const double expected =
        4.0 * CornerFormFactor(0.5, 0.5) * M_PI + 1.0 / (2.0 * std::sqrt(2.0)) + 0.5 + 0.2 * M_PI;
    ExpectIrradiance(vec3(0.0f), kUp, expected, 1u << 16);
}

TEST(Irradiance, TreeHasAQuarterOfTheVarianceOfUniformChoiceInASceneOfManyLights) {
    // 2,000 small triangles and 200 points about a room of 20 m; the variance is relative, over 64 places
    std::mt19937 random(21);
    const auto uniform = [&] { return float(random() >> 8) * 0x1p-24f; };
    const auto place = [&] { return 20.0f * vec3(uniform(), uniform(), 0.4f * uniform()); };
    testLights = {};
    for (int i = 0; i < 2000; ++i) {
        const vec3 p = place();
        const Frame frame = FrameFromZ(SampleUniformSphere(vec2(uniform(), uniform())));
        testLights.AddTriangle(p, p + 0.1f * frame.x, p + 0.1f * frame.y, vec3(20.0f + 200.0f * uniform()));
    }
    for (int i = 0; i < 200; ++i)
        testLights.AddPunctual(scene::LightType::Point, place(), kUp, vec3(0.2f + uniform()));
    testLights.Build();
    double relativeVariance[3] = {};
    for (const LightSampler sampler : kSamplers) {
        threadLightSampler = sampler;
        std::mt19937 places(22);
        for (uint i = 0; i < 64; ++i) {
            const auto coordinate = [&] { return 20.0f * float(places() >> 8) * 0x1p-24f; };
            const vec3 position(coordinate(), coordinate(), 0.0f);
            const Estimate estimate = Irradiance(position, kUp, 1u << 14, i);
            relativeVariance[int(sampler)] += estimate.variance / (estimate.mean * estimate.mean) / 64.0;
        }
    }
    threadLightSampler = LightSampler::Bvh;
    RecordProperty("uniform_over_bvh", std::to_string(relativeVariance[0] / relativeVariance[2]));
    RecordProperty("power_over_bvh", std::to_string(relativeVariance[1] / relativeVariance[2]));
    EXPECT_GT(relativeVariance[0], 4.0 * relativeVariance[2]);
    EXPECT_GT(relativeVariance[1], relativeVariance[2]);
}

}  // namespace
}  // namespace raygraph::shading::light_irradiance_test

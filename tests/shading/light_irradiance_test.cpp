// Irradiance of lights, their profiles, and triangles at any distance.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "core/rng.glsl"
#include "renderer/scene/formats/ies_file.h"
#include "tests/shading/light_scene.h"
#include "tests/shading/random_values.h"
#include "tests/support/chi_square.h"
#include "tests/support/ies_text.h"

// Irradiance by sampling lights against closed forms, with every light sampler.
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

// Lights with profiles: the text that the GPU runs, against the functions that the files were made of.
namespace raygraph::shading::light_profile_test {
namespace {

using test::IesText;
using test::Steps;

constexpr double kDegree = std::numbers::pi / 180.0;

vec3 RandomDirection(std::mt19937& random) {
    std::normal_distribution<float> normal;
    return normalize(vec3(normal(random), normal(random), normal(random)));
}

// A light with the profile at a place, its axes turned, scaled and perhaps mirrored.
void SetLight(const IesText& file, const glm::mat3& axes = glm::mat3(1.0f), vec3 position = vec3(0.0f),
              float intensity = 1.0f) {
    testLights = {};
    scene::Light light;
    light.profile = 0;
    light.intensity = intensity;
    light.lightToWorld = glm::mat4x3(axes[0], axes[1], axes[2], position);
    testLights.scene.punctual.push_back(light);
    const scene::LightProfile profile = scene::ParseIes(file.Text()).profile;
    testLights.scene.profiles = MakeProfileTable(std::span(&profile, 1));
    testLights.Build();
}

class LightProfileShading : public ::testing::Test {
  protected:
    void TearDown() override { testLights = {}; }

    // `d` is in the light's own space.
    static float At(vec3 d) { return LightProfileIntensity(LightAt(0u), normalize(d)); }
};

struct Web {
    const char* name;
    IesText file;
    // Returns the file's intensity in a direction of the light's space.
    std::function<double(const glm::dvec3&)> expected;
};

// Functions that are linear in each angle, so that interpolation is exact.
std::vector<Web> Webs() {
    const auto polar = [](const glm::dvec3& d) { return std::atan2(std::hypot(d.x, d.y), -d.z) / kDegree; };
    const auto azimuth = [](const glm::dvec3& d) {
        const double turn = std::atan2(d.y, d.x) / kDegree;
        return turn < 0.0 ? turn + 360.0 : turn;
    };
    std::vector<Web> webs;
    webs.push_back({"C, the same all around",
                    {.vertical = {0, 10, 90, 180}, .candela = [](double v, double) { return 200.0 - v; }},
                    [=](const glm::dvec3& d) { return 200.0 - polar(d); }});
    webs.push_back({"C, lower half",
                    {.vertical = {0, 10, 90}, .candela = [](double v, double) { return 1.0 + v; }},
                    [=](const glm::dvec3& d) { return polar(d) <= 90.0 ? 1.0 + polar(d) : 0.0; }});
    webs.push_back({"C, upper half",
                    {.vertical = {90, 180}, .candela = [](double v, double) { return v; }},
                    [=](const glm::dvec3& d) { return polar(d) >= 90.0 ? polar(d) : 0.0; }});
    const auto product = [](double v, double h) { return (180.0 - v) * (10.0 + h); };
    webs.push_back({"C, quarters",
                    {.vertical = {0, 180}, .horizontal = {0, 15, 90}, .candela = product},
                    [=](const glm::dvec3& d) {
                        const double h = std::atan2(std::abs(d.y), std::abs(d.x)) / kDegree;
                        return product(polar(d), h);
                    }});
    webs.push_back(
        {"C, halves",
         {.vertical = {0, 180}, .horizontal = {0, 100, 180}, .candela = product},
         [=](const glm::dvec3& d) { return product(polar(d), std::atan2(std::abs(d.y), d.x) / kDegree); }});
    webs.push_back({"C, halves from 90",
                    {.vertical = {0, 180}, .horizontal = {90, 180, 270}, .candela = product},
                    [=](const glm::dvec3& d) {
                        // The other half is mirrored at the plane of 90 and 270 degrees
                        return product(polar(d), azimuth({-std::abs(d.x), d.y, d.z}));
                    }});
    const auto around = [](double h) { return h <= 240.0 ? h : 240.0 - 0.5 * (h - 240.0); };
    webs.push_back({"C, all around",
                    {.vertical = {0, 180},
                     .horizontal = {0, 180, 240, 360},
                     .candela = [=](double v, double h) { return (180.0 - v) * around(h); }},
                    [=](const glm::dvec3& d) { return (180.0 - polar(d)) * around(azimuth(d)); }});
    // Horizontal angles are clockwise: positive ones towards -y
    const auto slanted = [](double v, double h) { return 1000.0 + 2.0 * v + 3.0 * h + 0.01 * v * h; };
    const auto anglesB = [](const glm::dvec3& d) {
        return glm::dvec2(std::atan2(d.x, -d.z), std::asin(std::clamp(-d.y, -1.0, 1.0))) / kDegree;
    };
    const auto anglesA = [](const glm::dvec3& d) {
        return glm::dvec2(std::asin(std::clamp(d.x, -1.0, 1.0)), std::atan2(-d.y, -d.z)) / kDegree;
    };
    const auto inFront = [](const glm::dvec2& angles) {
        return std::abs(angles.x) <= 90.0 && std::abs(angles.y) <= 90.0;
    };
    webs.push_back({"B",
                    {.type = 2, .vertical = {-90, 0, 90}, .horizontal = {-90, 30, 90}, .candela = slanted},
                    [=](const glm::dvec3& d) {
                        const glm::dvec2 a = anglesB(d);
                        return inFront(a) ? slanted(a.x, a.y) : 0.0;
                    }});
    webs.push_back({"B, mirrored",
                    {.type = 2, .vertical = {-90, 90}, .horizontal = {0, 90}, .candela = slanted},
                    [=](const glm::dvec3& d) {
                        const glm::dvec2 a = anglesB(d);
                        return inFront(a) ? slanted(a.x, std::abs(a.y)) : 0.0;
                    }});
    webs.push_back({"B, upper part",
                    {.type = 2, .vertical = {0, 90}, .horizontal = {-45, 60}, .candela = slanted},
                    [=](const glm::dvec3& d) {
                        const glm::dvec2 a = anglesB(d);
                        const bool isInside = a.x >= 0.0 && a.x <= 90.0 && a.y >= -45.0 && a.y <= 60.0;
                        return isInside ? slanted(a.x, a.y) : 0.0;
                    }});
    webs.push_back({"A",
                    {.type = 3, .vertical = {-90, 0, 90}, .horizontal = {-90, 90}, .candela = slanted},
                    [=](const glm::dvec3& d) {
                        const glm::dvec2 a = anglesA(d);
                        return inFront(a) ? slanted(a.x, a.y) : 0.0;
                    }});
    return webs;
}

// Returns whether a direction is at an edge, where the expected value jumps.
bool IsAtEdge(const Web& web, const glm::dvec3& d) {
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 near =
            glm::normalize(d + 1e-4 * glm::dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
        if (std::abs(web.expected(near) - web.expected(d)) > 10.0) return true;
    }
    return false;
}

}  // namespace

TEST_F(LightProfileShading, IntensityIsTheFilesFunctionInEveryDirection) {
    for (const Web& web : Webs()) {
        SCOPED_TRACE(web.name);
        SetLight(web.file);
        std::mt19937 random(1);
        int edges = 0;
        for (int i = 0; i < 2000; ++i) {
            const vec3 d = RandomDirection(random);
            if (IsAtEdge(web, d)) {
                ++edges;
                continue;
            }
            const double expected = web.expected(d);
            ASSERT_NEAR(At(d), expected, 1e-4 * std::abs(expected) + 1e-2) << d.x << ' ' << d.y << ' ' << d.z;
        }
        EXPECT_LT(edges, 100);
    }
}

// By the specification, zero is along -z, and planes of zero are in x and z.
TEST_F(LightProfileShading, AxesAreThoseOfTheSpecification) {
    const auto peak = [](double v0, double h0) {
        return [=](double v, double h) { return v == v0 && h == h0 ? 100.0 : 0.0; };
    };
    SetLight({.vertical = {0, 90, 180}, .horizontal = {0, 90, 180, 270, 360}, .candela = peak(90, 90)});
    EXPECT_EQ(At({0, 1, 0}), 100.0f) << "C counts counterclockwise, seen from above";
    SetLight({.vertical = {0, 90, 180}, .candela = peak(0, 0)});
    EXPECT_EQ(At({0, 0, -1}), 100.0f);
    SetLight({.type = 2, .vertical = {-90, 0, 90}, .horizontal = {-90, 0, 90}, .candela = peak(0, 0)});
    EXPECT_EQ(At({0, 0, -1}), 100.0f);
    SetLight({.type = 2, .vertical = {-90, 0, 45, 90}, .horizontal = {-90, 0, 90}, .candela = peak(45, 0)});
    EXPECT_NEAR(At({1, 0, -1}), 100.0f, 1e-3f);
    SetLight({.type = 2, .vertical = {-90, 0, 90}, .horizontal = {-90, 0, 45, 90}, .candela = peak(0, 45)});
    EXPECT_NEAR(At({0, -1, -1}), 100.0f, 1e-3f);
    SetLight({.type = 3, .vertical = {-90, 0, 90}, .horizontal = {-90, 0, 45, 90}, .candela = peak(0, 45)});
    EXPECT_NEAR(At({0, -1, -1}), 100.0f, 1e-3f);
    SetLight({.type = 3, .vertical = {-90, 0, 45, 90}, .horizontal = {-90, 0, 90}, .candela = peak(45, 0)});
    EXPECT_NEAR(At({1, 0, -1}), 100.0f, 1e-3f);
}

TEST_F(LightProfileShading, TurnsWithTheNodeWhateverItsScale) {
    const Web web = Webs()[7];
    const glm::mat3 turn = glm::mat3_cast(glm::normalize(glm::quat(0.7f, -0.2f, 0.5f, 0.4f)));
    for (const vec3& scale : {vec3(1.0f), vec3(0.01f, 5.0f, 3.0f), vec3(1.0f, -1.0f, 1.0f)}) {
        glm::mat3 axes = turn;
        for (int i = 0; i < 3; ++i) axes[i] *= scale[i];
        SetLight(web.file, axes);
        std::mt19937 random(2);
        for (int i = 0; i < 500; ++i) {
            const vec3 own = RandomDirection(random);
            if (IsAtEdge(web, own)) continue;
            const vec3 signs = glm::sign(scale);
            const double expected = web.expected(own);
            ASSERT_NEAR(At(turn * (signs * own)), expected, 1e-4 * std::abs(expected) + 2e-2);
        }
    }
}

TEST_F(LightProfileShading, IrradianceIsIntensityByTheSquareOfTheDistance) {
    const Web web = Webs()[4];
    const vec3 position(1.0f, 4.0f, -2.0f);
    // -z of the node down
    const glm::mat3 down(vec3(1, 0, 0), vec3(0, 0, -1), vec3(0, 1, 0));
    SetLight(web.file, down, position, 0.5f);
    std::mt19937 random(3);
    for (int i = 0; i < 100; ++i) {
        const vec3 point(6.0f * RandomDirection(random).x, 0.0f, 6.0f * RandomDirection(random).z);
        const vec3 way = point - position;
        const double distance2 = glm::dot(glm::dvec3(way), glm::dvec3(way));
        const glm::dvec3 own = glm::transpose(glm::dmat3(down)) * glm::dvec3(glm::normalize(way));
        const LightSample s = SamplePunctual(LightAt(0u), {point, vec3(0, 1, 0)});
        EXPECT_EQ(s.isDelta, 1u);
        EXPECT_EQ(s.pdf, 1.0f);
        EXPECT_NEAR(s.radiance.x, 0.5 * web.expected(own) / distance2, 2e-4 * s.radiance.x);
    }
}

TEST_F(LightProfileShading, PowerIsThatOfTheMeanIntensity) {
    SetLight({.vertical = Steps(0, 90, 1), .candela = [](double v, double) { return std::cos(v * kDegree); }},
             glm::mat3(1.0f), vec3(0.0f), 3.0f);
    ASSERT_EQ(testLights.table.Set().nodeCount, 1u);
    EXPECT_NEAR(testLights.table.NodeAt(0).power, 3.0 * std::numbers::pi, 1e-3);
    SetLight({.candela = [](double, double) { return 0.0; }});
    EXPECT_EQ(testLights.table.Set().activeCount, 0u) << "a dark one is no light";
}

// Each sampler of lights finds both of two: a profile that shines down, and a point light.
TEST_F(LightProfileShading, EverySamplerFindsTheSameIrradiance) {
    const auto before = threadLightSampler;
    for (const LightSampler sampler : {LightSampler::Uniform, LightSampler::Power, LightSampler::Bvh}) {
        SetLight({.vertical = {0, 30, 90}, .candela = [](double v, double) { return v < 1.0 ? 90.0 : 0.0; }},
                 glm::mat3(vec3(1, 0, 0), vec3(0, 0, -1), vec3(0, 1, 0)), vec3(0.0f, 2.0f, 0.0f));
        testLights.AddPunctual(scene::LightType::Point, vec3(1.0f, 1.0f, 0.0f), vec3(0, -1, 0), vec3(2.0f));
        testLights.Build();
        threadLightSampler = sampler;
        const LightContext context{vec3(0.0f), vec3(0, 1, 0)};
        std::mt19937 random(4);
        std::uniform_real_distribution<float> uniform(0.0f, 0.9999999f);
        double sum = 0.0;
        constexpr int kSamples = 200'000;
        for (int i = 0; i < kSamples; ++i) {
            const float uc = uniform(random);
            const LightSample s = SampleLight(context, uc, vec2(uniform(random), 0.5f));
            if (s.pdf > 0.0f) sum += double{s.radiance.x} * std::max(s.wi.y, 0.0f) / s.pdf;
        }
        // Uniformly chosen, a sample is off by 22
        EXPECT_NEAR(sum / kSamples, 90.0 / 4.0 + std::sqrt(0.5), 0.2) << static_cast<int>(sampler);
    }
    threadLightSampler = before;
}

}  // namespace raygraph::shading::light_profile_test

// Tests of a triangle light seen from 1e-7 to 1e3 times its size away: above its middle, its edges and its
// corners, and from beside it. Sampled light, light that rays find, and closed forms in double precision
// agree.
namespace raygraph::shading::triangle_light_range_test {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kTolerance = 1e-3;

struct View {
    std::string name;
    LightRecord light{};    // seen from the origin
    double rounding = 0.0;  // relative error of what is seen, by rounded coordinates
    bool isSliver = false;
};

double Turn(dvec2 a, dvec2 b) {
    return a.x * b.y - a.y * b.x;
}

// A triangle as seen from the origin, in double precision. The light's record is taken as exact.
class Seen {
  public:
    explicit Seen(const LightRecord& light)
        : m_corners{dvec3(light.p0), dvec3(light.p0) + dvec3(light.e1), dvec3(light.p0) + dvec3(light.e2)},
          m_normal(glm::normalize(glm::cross(dvec3(light.e1), dvec3(light.e2)))) {
        if (glm::dot(m_corners[0], m_normal) < 0.0) m_normal = -m_normal;
        m_height = glm::dot(m_corners[0], m_normal);
        m_x = glm::normalize(dvec3(light.e1));
        m_y = glm::cross(m_normal, m_x);
        for (int i = 0; i < 3; ++i)
            m_flat[i] = dvec2(glm::dot(m_corners[i], m_x), glm::dot(m_corners[i], m_y));
        if (Turn(m_flat[1] - m_flat[0], m_flat[2] - m_flat[0]) < 0.0) std::swap(m_flat[1], m_flat[2]);
        for (int i = 0; i < 3; ++i) m_isInside &= Turn(m_flat[(i + 1) % 3] - m_flat[i], -m_flat[i]) >= 0.0;
        if (m_isInside) return;
        const dvec2 middle = (m_flat[0] + m_flat[1] + m_flat[2]) / 3.0;
        const double center = std::atan2(middle.y, middle.x);
        m_low = m_high = center;
        for (const dvec2& corner : m_flat) {
            const double turn = std::atan2(Turn(middle, corner), glm::dot(middle, corner));
            m_low = std::min(m_low, center + turn);
            m_high = std::max(m_high, center + turn);
        }
    }

    dvec3 Normal() const { return m_normal; }
    double Height() const { return m_height; }
    double NearestCorner() const {
        return std::min({glm::length(m_corners[0]), glm::length(m_corners[1]), glm::length(m_corners[2])});
    }
    // The triangle is seen only in azimuths about the normal between these.
    double Low() const { return m_low; }
    double High() const { return m_high; }
    double AzimuthOf(dvec3 direction) const {
        const double azimuth = std::atan2(glm::dot(direction, m_y), glm::dot(direction, m_x));
        return m_low + std::fmod(azimuth - m_low + 4.0 * M_PI, 2.0 * M_PI);
    }

    // Gives the range of cosines to the normal of those directions of an azimuth that meet the triangle.
    // Returns false if none do.
    bool Cosines(double azimuth, double& least, double& most) const {
        const dvec2 d(std::cos(azimuth), std::sin(azimuth));
        double near = 0.0, far = std::numeric_limits<double>::infinity();
        for (int i = 0; i < 3; ++i) {
            const dvec2 edge = m_flat[(i + 1) % 3] - m_flat[i];
            const double at = Turn(edge, -m_flat[i]), slope = Turn(edge, d);  // inside: at + t slope >= 0
            if (slope > 0.0) near = std::max(near, -at / slope);
            if (slope < 0.0) far = std::min(far, -at / slope);
            if (slope == 0.0 && at < 0.0) return false;
        }
        if (!(near < far)) return false;
        most = m_height / std::hypot(m_height, near);
        least = m_height / std::hypot(m_height, far);
        return true;
    }
    bool IsMet(dvec3 direction) const {
        double least = 0.0, most = 0.0;
        const double cosine = glm::dot(direction, m_normal) / glm::length(direction);
        return Cosines(AzimuthOf(direction), least, most) && cosine >= least && cosine <= most;
    }

    // Returns the irradiance on the parallel plane through the origin by Lambert's formula ("Photometria",
    // 1760), or by quadrature where its terms cancel.
    double Irradiance() const {
        double sum = 0.0;
        for (int i = 0; i < 3; ++i) {
            const dvec3 a = m_corners[i], b = m_corners[(i + 1) % 3], across = glm::cross(a, b);
            const double sine = glm::length(across);
            if (sine > 0.0) sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(across / sine, m_normal);
        }
        if (std::abs(sum) > 1e-10) return 0.5 * std::abs(sum);
        constexpr int kSteps = 20'000;
        sum = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            double least = 0.0, most = 0.0;
            if (Cosines(m_low + (m_high - m_low) * (i + 0.5) / kSteps, least, most))
                sum += 0.5 * (most * most - least * least) * (m_high - m_low) / kSteps;
        }
        return sum;
    }

  private:
    dvec3 m_corners[3];
    dvec2 m_flat[3];  // in the plane, relative to the origin's projection
    dvec3 m_normal, m_x{0.0}, m_y{0.0};
    double m_height = 0.0, m_low = -M_PI, m_high = M_PI;
    bool m_isInside = true;
};

struct Shape {
    const char* name;
    dvec2 corners[3];
    bool isAlongAxis[3];  // [i]: the edge from corner i to the next one is along an axis
    bool isSliver = false;
};

constexpr int kLeastExponent = -7, kMaxExponent = 3;

// Adds all views of a shape, in a turned plane or not, from 10^exponent times its size away.
void AddViews(const Shape& shape, bool isTurned, int exponent, std::vector<View>& views) {
    const dvec3 z = isTurned ? glm::normalize(dvec3(0.3, -0.5, 0.8)) : dvec3(0, 0, 1);
    const dvec3 x = isTurned ? glm::normalize(glm::cross(dvec3(0.2, 0.9, 0.1), z)) : dvec3(1, 0, 0);
    const glm::dmat3 turn(x, glm::cross(z, x), z);
    const double r = std::pow(10.0, exponent);
    const auto& c = shape.corners;
    const auto add = [&](const std::string& place, dvec2 foot, double height, double rounding) {
        View view{.name = std::string(shape.name) + (isTurned ? ", turned, " : ", ") + place + ", 1e" +
                          std::to_string(exponent),
                  .rounding = rounding,
                  .isSliver = shape.isSliver};
        vec3 p[3];
        for (int i = 0; i < 3; ++i) p[i] = turn * dvec3(c[i] - foot, height);
        view.light.p0 = p[0];
        view.light.e1 = p[1] - p[0];
        view.light.e2 = p[2] - p[0];
        view.light.flags = kLightDoubleSided;
        views.push_back(view);
    };
    // Rounding of a corner turns the plane through the origin and a near edge, or moves the triangle's plane
    // if it is seen edge-on
    const auto nearby = [&](bool isExact) { return isExact ? 0.0 : 2e-8 / r; };
    add("middle", (c[0] + c[1] + c[2]) / 3.0, r, 0.0);
    for (int i = 0; i < 3; ++i) {
        const dvec2 edge = glm::normalize(c[(i + 1) % 3] - c[i]), inward(-edge.y, edge.x);
        const dvec2 on = c[i] + 0.37 * (c[(i + 1) % 3] - c[i]);
        const double rounding = nearby(!isTurned && shape.isAlongAxis[i]);
        const std::string number = std::to_string(i);
        add("edge " + number, on, r, rounding);
        add("inside of edge " + number, on + r * inward, r, rounding);
        add("outside of edge " + number, on - r * inward, r, rounding);
        add("corner " + number, c[i] + dvec2(0.3 * r, -0.2 * r), 0.5 * r, nearby(false));
    }
    add("flat inside of edge 0", c[0] + dvec2(0.37, 20.0 * r), r, nearby(!isTurned));
    add("flat outside of edge 0", c[0] + dvec2(0.37, -20.0 * r), r, nearby(!isTurned));
    add("beside", c[1] + (0.2 + r) * dvec2(0.8, -0.6), 0.05 * r, isTurned ? 3e-6 / r : 0.0);
}

std::vector<View> Views() {
    const Shape shapes[] = {{"half of a square", {{0, 0}, {1, 0}, {1, 1}}, {true, true, false}},
                            {"obtuse", {{0, 0}, {1, 0}, {0.4, 0.15}}, {true, false, false}},
                            {"sliver", {{0, 0}, {1, 0}, {0.3, 2e-3}}, {true, false, false}, true}};
    std::vector<View> views;
    for (const Shape& shape : shapes)
        for (int exponent = kLeastExponent; exponent <= kMaxExponent; ++exponent) {
            AddViews(shape, false, exponent, views);
            if (exponent % 2 != 0) AddViews(shape, true, exponent, views);
        }
    return views;
}

bool IsByAngle(const SphericalTriangle& t) {
    return t.density > 0.0f;
}

// Directions are counted in cells of azimuth and of cosine to the normal, whose solid angles are exact.
constexpr int kTurns = 16, kRings = 8, kSteps = 250;

struct Cells {
    std::vector<double> solidAngles = std::vector<double>(kTurns * kRings, 0.0);
    double least = 1.0, most = 0.0;  // cosines

    explicit Cells(const Seen& seen) {
        const double step = (seen.High() - seen.Low()) / (kTurns * kSteps);
        const auto each = [&](auto&& visit) {
            for (int i = 0; i < kTurns * kSteps; ++i) {
                double from = 0.0, to = 0.0;
                if (seen.Cosines(seen.Low() + (i + 0.5) * step, from, to)) visit(i / kSteps, from, to);
            }
        };
        each([&](int, double from, double to) {
            least = std::min(least, from);
            most = std::max(most, to);
        });
        const double ring = (most - least) / kRings;
        each([&](int column, double from, double to) {
            for (int k = 0; k < kRings; ++k)
                solidAngles[size_t(column * kRings + k)] +=
                    step *
                    std::max(0.0, std::min(to, least + (k + 1) * ring) - std::max(from, least + k * ring));
        });
    }
    size_t CellOf(const Seen& seen, dvec3 direction) const {
        const double turn = (seen.AzimuthOf(direction) - seen.Low()) / (seen.High() - seen.Low());
        const double cosine = glm::dot(direction, seen.Normal()) / glm::length(direction);
        const int column = std::clamp(int(turn * kTurns), 0, kTurns - 1);
        const int row = std::clamp(int((cosine - least) / (most - least) * kRings), 0, kRings - 1);
        return size_t(column * kRings + row);
    }
};

TEST(TriangleLightRange, SampledDirectionsFollowTheDensityOfFoundOnes) {
    constexpr int kCount = 20'000;
    const std::vector<View> views = Views();
    const double level = test::SidakLevel(0.01, int(views.size()));
    Uniform random(61);
    int count = 0;
    for (const View& view : views) {
        const SphericalTriangle t = SphericalTriangleFrom(view.light, vec3(0.0f));
        const Seen seen(view.light);
        // A sliver that is farther away covers too few azimuths for these cells
        const bool isFar = seen.NearestCorner() > (view.isSliver ? 0.05 : 0.5);
        if (!IsByAngle(t) || view.rounding > 1e-2 || isFar) continue;
        ++count;
        const Cells cells(seen);
        const double density = double(TriangleLightPDF(view.light, vec3(0.0f), 1.0f));
        std::vector<double> expected;
        double met = 0.0;
        for (const double solidAngle : cells.solidAngles) {
            expected.push_back(kCount * density * solidAngle);
            met += expected.back();
        }
        EXPECT_NEAR(met / kCount, 1.0, kTolerance + view.rounding) << view.name;
        std::vector<double> observed(expected.size(), 0.0);
        int strayCount = 0;  // samples that rounding put beside the triangle
        for (int i = 0; i < kCount; ++i) {
            const vec2 u(random(), random());
            const TrianglePoint point = SampleTriangleLight(view.light, t, vec3(0.0f), u);
            ASSERT_NEAR(length(point.wi), 1.0f, 1e-5f) << view.name;
            const dvec3 place = dvec3(view.light.p0) + double{point.barycentrics.x} * dvec3(view.light.e1) +
                                double{point.barycentrics.y} * dvec3(view.light.e2);
            ASSERT_NEAR(double{point.distance}, glm::length(place), 1e-4 * glm::length(place) + 3e-7)
                << view.name;  // and roundings of the place
            const size_t cell = cells.CellOf(seen, dvec3(point.wi));
            if (!(point.pdf > 0.0f) || expected[cell] < 0.5 || !seen.IsMet(dvec3(point.wi)))
                ++strayCount;
            else
                observed[cell] += 1.0;
        }
        EXPECT_LT(strayCount, (kTolerance + view.rounding) * kCount) << view.name;
        EXPECT_GT(test::ChiSquareTest(observed, expected).pValue, level) << view.name;
    }
    EXPECT_GT(count, 100);
}

// A lamp 1 m long and 1 mm to 10 cm wide is sampled by solid angle from as near as its width. Points chosen
// by area would almost all be too far away to contribute.
TEST(TriangleLightRange, LongLampsAreSampledWellFromNear) {
    constexpr uint kCount = 1u << 14;
    testLights = {};
    testLights.scene.emission = {vec3(1.0f)};
    for (const float width : {1e-1f, 1e-2f, 1e-3f})
        for (const float height : {1.0f, 10.0f, 100.0f}) {
            LightRecord light{};
            light.p0 = vec3(-0.37f, -0.3f * width, height * width);
            light.e1 = vec3(1.0f, 0.0f, 0.0f);
            light.e2 = vec3(1.0f, width, 0.0f);
            light.flags = kLightDoubleSided;
            const double expected = Seen(light).Irradiance();
            double sum = 0.0, squares = 0.0;
            for (uint i = 0; i < kCount; ++i) {
                Sampler rng = StartPixelSample(uvec2(3u, 5u), i, 1u);
                const LightSample s = SampleTriangle(light, {vec3(0.0f), vec3(0, 0, 1)}, Get2D(rng));
                const double value = s.pdf > 0.0f ? double(s.wi.z / s.pdf) : 0.0;
                sum += value;
                squares += value * value;
            }
            const double mean = sum / kCount;
            EXPECT_NEAR(mean, expected, kTolerance * expected)
                << width << " m wide, " << height << " widths off";
            EXPECT_LT(squares / kCount - mean * mean, mean * mean)
                << width << " m wide, " << height << " widths off";
        }
}

// The irradiance of all views is estimated by light sampling and cosine-distributed rays, weighted by the
// balance heuristic with the density of TriangleLightPDF. Where the light is sampled by solid angle, light
// sampling alone is checked, too.
TEST(TriangleLightRange, IrradianceIsLamberts) {
    constexpr uint kCount = 1u << 12;
    testLights = {};
    testLights.scene.emission = {vec3(1.0f)};
    for (const View& view : Views()) {
        const SphericalTriangle t = SphericalTriangleFrom(view.light, vec3(0.0f));
        const Seen seen(view.light);
        const vec3 normal(seen.Normal());
        const Frame frame = FrameFromZ(normal);
        const double expected = seen.Irradiance();
        double alone = 0.0, both = 0.0, squares = 0.0;
        for (uint i = 0; i < kCount; ++i) {
            Sampler rng = StartPixelSample(uvec2(3u, 5u), i, 1u);
            const LightSample s = SampleTriangle(view.light, {vec3(0.0f), normal}, Get2D(rng));
            double value = 0.0;
            if (s.pdf > 0.0f) {
                const double cosine = std::max(double(dot(s.wi, normal)), 0.0);
                alone += cosine / double(s.pdf);
                value += cosine / (double(s.pdf) + cosine / M_PI);
            }
            const dvec3 found(FromLocal(frame, SampleCosineHemisphere(Get2D(rng))));
            if (seen.IsMet(found)) {
                const double cosine = glm::dot(found, seen.Normal());
                const float pdf = TriangleLightPDF(view.light, vec3(0.0f), float(seen.Height() / cosine));
                value += cosine / (double(pdf) + cosine / M_PI);
            }
            both += value;
            squares += value * value;
        }
        alone /= kCount;
        both /= kCount;
        const double tolerance = (kTolerance + view.rounding) * expected;
        const double deviation = std::sqrt(std::max(squares / kCount - both * both, 0.0) / kCount);
        EXPECT_NEAR(both, expected, tolerance + 4.0 * deviation) << view.name << ", with found light";
        if (IsByAngle(t)) {
            EXPECT_NEAR(alone, expected, tolerance) << view.name;
        }
    }
}

}  // namespace
}  // namespace raygraph::shading::triangle_light_range_test

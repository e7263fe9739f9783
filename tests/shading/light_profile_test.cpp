// Lights with profiles: the text that the GPU runs, against the functions that the files were made of.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <numbers>
#include <random>

#include "core/rng.glsl"
#include "renderer/scene/formats/ies_file.h"
#include "tests/shading/light_scene.h"
#include "tests/support/ies_text.h"

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

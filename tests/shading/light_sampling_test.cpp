// Sampling of lights: one sampler over all of them, meshes, and environments.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/rng.glsl"
#include "renderer/gpu_scene/lights/light_mesh.h"
#include "tests/shading/light_scene.h"
#include "tests/shading/random_values.h"
#include "tests/support/chi_square.h"

// Choice of lights and directions: probabilities are those that are claimed.
namespace raygraph::shading::light_sampling_test {
namespace {

constexpr std::array kSamplers = {LightSampler::Uniform, LightSampler::Power, LightSampler::Bvh};

// Lights of every kind about the origin, one of them dark.
void MakeMixedScene() {
    Uniform random(11);
    testLights = {};
    testLights.scene.radius = 2.0f;
    for (int i = 0; i < 40; ++i) {
        const vec3 p = PointIn(random, 3.0f);
        testLights.AddTriangle(p, p + PointIn(random, 0.5f), p + PointIn(random, 0.5f),
                               vec3(i == 7 ? 0.0f : 5.0f * random()), i % 4 == 0);
    }
    for (int i = 0; i < 10; ++i)
        testLights.AddPunctual(i % 2 == 0 ? scene::LightType::Point : scene::LightType::Spot,
                               PointIn(random, 3.0f), random.Direction(), vec3(3.0f * random()), 0.2f, 1.2f);
    testLights.AddPunctual(scene::LightType::Directional, vec3(0.0f), random.Direction(), vec3(0.4f));
    testLights.AddPunctual(scene::LightType::Directional, vec3(0.0f), random.Direction(), vec3(0.1f));
    testLights.SetEnvironment(RandomMap(16, 8, random), vec3(0.3f, 0.2f, 0.1f), 0.7f);
    testLights.Build();
}

std::vector<LightContext> Contexts() {
    return {{vec3(0.0f), vec3(0.0f)},
            {vec3(0.3f, -0.2f, 0.5f), vec3(0.0f, 1.0f, 0.0f)},
            {vec3(10.0f, 1.0f, 0.0f), normalize(vec3(-1.0f, 0.2f, 0.1f))},
            {vec3(0.0f, -2.5f, 1.0f), normalize(vec3(0.5f, -1.0f, 0.3f))}};
}

class LightSampling : public ::testing::TestWithParam<LightSampler> {
  protected:
    void SetUp() override {
        threadTraceFeatures =
            kTraceLightSampling | kTraceTriangleLights | kTracePunctualLights | kTraceEnvironmentLight;
        threadLightSampler = GetParam();
    }
    void TearDown() override {
        threadTraceFeatures = m_features;
        threadLightSampler = LightSampler::Bvh;
    }

    const TraceFeatures m_features = threadTraceFeatures;

    static double Probability(const LightContext& context, uint light) {
        const LightSetRecord lights = LightSet();
        const uint trail = light < lights.lightCount ? LightAt(light).bitTrail : 0u;
        return double(LightProbability(lights, context, light, trail));
    }
};

TEST_P(LightSampling, FrequenciesAreTheProbabilitiesWhichSumToOne) {
    MakeMixedScene();
    const uint count = LightSet().lightCount + 1u;
    const double level = test::SidakLevel(0.01, int(Contexts().size() * kSamplers.size()));
    Uniform random(12);
    for (const LightContext& context : Contexts()) {
        std::vector<double> expected(count + 1), observed(count + 1, 0.0);
        double sum = 0.0;
        for (uint light = 0; light < count; ++light) {
            const double p = Probability(context, light);
            expected[light] = 3e5 * p;
            sum += p;
        }
        // The tree may end at a node of which neither child can matter: no light then
        EXPECT_LT(sum, 1.0 + 1e-5);
        if (GetParam() != LightSampler::Bvh) {
            EXPECT_GT(sum, 1.0 - 1e-5);
        }
        EXPECT_GT(sum, 0.5);
        expected[count] = 3e5 * std::max(0.0, 1.0 - sum);
        if (expected[count] < 10.0) expected[count] = 0.0;  // rounding
        for (int i = 0; i < 300'000; ++i) {
            float uc = random(), ux = random();
            const ChosenLight chosen = ChooseLight(LightSet(), context, uc, ux);
            const bool isChosen = chosen.probability > 0.0f;
            observed[isChosen ? chosen.light : count] += 1.0;
            if (isChosen && i % 100 == 0) {
                ASSERT_NEAR(double(chosen.probability), expected[chosen.light] / 3e5,
                            1e-5 * double(chosen.probability));
            }
        }
        EXPECT_GT(test::ChiSquareTest(observed, expected).pValue, level);
    }
}

TEST_P(LightSampling, NumbersLeftOverAreUniform) {
    MakeMixedScene();
    Uniform random(13);
    const LightContext context = Contexts()[1];
    double sumC = 0.0, sumX = 0.0;
    constexpr int kCount = 200'000;
    for (int i = 0; i < kCount; ++i) {
        float uc = random(), ux = random();
        ChooseLight(LightSet(), context, uc, ux);
        ASSERT_TRUE(uc >= 0.0f && uc < 1.0f && ux >= 0.0f && ux < 1.0f);
        sumC += double(uc);
        sumX += double(ux);
    }
    EXPECT_NEAR(sumX / kCount, 0.5, 4.0 * std::sqrt(1.0 / 12 / kCount));
    // The tree takes uc by value
    if (GetParam() != LightSampler::Bvh) {
        EXPECT_NEAR(sumC / kCount, 0.5, 4.0 * std::sqrt(1.0 / 12 / kCount));
    }
}

// Returns where a ray meets a triangle's plane, in double; infinity outside the triangle, which is enlarged a
// little.
double Meet(const LightRecord& light, vec3 origin, vec3 direction) {
    const glm::dvec3 e1(light.e1), e2(light.e2), d(direction), s(origin - light.p0);
    const glm::dvec3 h = glm::cross(d, e2), q = glm::cross(s, e1);
    const double a = glm::dot(e1, h);
    const double b1 = glm::dot(s, h) / a, b2 = glm::dot(d, q) / a;
    const bool isInside = b1 > -1e-3 && b2 > -1e-3 && b1 + b2 < 1.001;
    return isInside ? glm::dot(e2, q) / a : std::numeric_limits<double>::infinity();
}

TEST_P(LightSampling, SamplesHaveTheDensityOfWhatTheirRayHits) {
    MakeMixedScene();
    Uniform random(14);
    int triangles = 0, environments = 0, deltas = 0, disagreements = 0;
    for (const LightContext& context : Contexts()) {
        for (int i = 0; i < 50'000; ++i) {
            const float uc = random();
            const LightSample s = SampleLight(context, uc, random.Pair());
            if (s.pdf == 0.0f) continue;
            ASSERT_NEAR(length(s.wi), 1.0f, 1e-5f);
            if (s.light == LightSet().lightCount) {
                ++environments;
                ASSERT_EQ(s.distance, kInfinity);
                // A direction may fall off the edge of its cell by rounding
                disagreements +=
                    std::abs(LightPDF(context, LightSet().lightCount, 0u, s.wi, kInfinity) / s.pdf - 1.0f) >
                    1e-3f;
                continue;
            }
            const LightRecord light = LightAt(s.light);
            if (light.kind != kLightTriangle) {
                ++deltas;
                ASSERT_EQ(s.isDelta, 1u);
                ASSERT_NEAR(double(s.pdf), Probability(context, s.light), 1e-5 * double(s.pdf));
                continue;
            }
            ++triangles;
            const double distance = Meet(light, context.position, s.wi);
            ASSERT_NEAR(distance, double(s.distance), 1e-3 * double(s.distance));
            ASSERT_EQ(s.radiance, TriangleEmission(light, vec2(0.0f), -s.wi));
            ASSERT_NEAR(LightPDF(context, s.light, s.triangle, s.wi, float(distance)), s.pdf, 5e-3f * s.pdf);
        }
    }
    EXPECT_GT(triangles, 1000);
    EXPECT_GT(environments, 1000);
    EXPECT_GT(deltas, 1000);
    EXPECT_LT(disagreements, environments / 1000);
}

TEST_P(LightSampling, NothingIsChosenWhereNothingShines) {
    testLights = {};
    testLights.Build();
    EXPECT_EQ(SampleLight(Contexts()[0], 0.5f, vec2(0.5f)).pdf, 0.0f);
    EXPECT_EQ(LightPDF(Contexts()[0], LightSet().lightCount, 0u, vec3(0, 1, 0), kInfinity), 0.0f);
    testLights.AddTriangle(vec3(0, 0, 1), vec3(1, 0, 1), vec3(0, 1, 1), vec3(0.0f));
    testLights.Build();
    EXPECT_EQ(SampleLight(Contexts()[0], 0.5f, vec2(0.5f)).pdf, 0.0f);
    EXPECT_EQ(LightPDF(Contexts()[0], 0u, 0u, vec3(0, 0, 1), 1.0f), 0.0f);
}

TEST_P(LightSampling, BacksOfSingleSidedTrianglesGiveNoLight) {
    testLights = {};
    testLights.AddTriangle(vec3(-1, -1, 2), vec3(1, -1, 2), vec3(0, 1, 2), vec3(1.0f));  // front: +z
    testLights.Build();
    const LightContext below{vec3(0.0f), vec3(0.0f)}, above{vec3(0, 0, 4), vec3(0.0f)};
    EXPECT_EQ(SampleLight(below, 0.5f, vec2(0.4f)).pdf, 0.0f);
    EXPECT_EQ(LightPDF(below, 0u, 0u, vec3(0, 0, 1), 2.0f), 0.0f);
    EXPECT_GT(SampleLight(above, 0.5f, vec2(0.4f)).pdf, 0.0f);
    EXPECT_GT(LightPDF(above, 0u, 0u, vec3(0, 0, -1), 2.0f), 0.0f);
}

INSTANTIATE_TEST_SUITE_P(Samplers, LightSampling, ::testing::ValuesIn(kSamplers));

// A lone triangle of some size seen from the origin, at a distance of 1.
LightRecord TriangleOfSize(float size) {
    LightRecord light{};
    light.p0 = vec3(-0.3f, -0.4f, 1.0f) * vec3(size, size, 1.0f);
    light.e1 = vec3(0.2f, 0.9f, 0.1f) * size;
    light.e2 = vec3(1.0f, 0.1f, 0.3f) * size;
    return light;
}

// Solid angle of (a, b, c) from the origin, in double.
double SolidAngle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    a = glm::normalize(a);
    b = glm::normalize(b);
    c = glm::normalize(c);
    const double det = std::abs(glm::dot(a, glm::cross(b - a, c - a)));
    return 2.0 * std::atan2(det, 1.0 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
}

TEST(TriangleLight, DirectionsAreUniformInSolidAngle) {
    // Sizes on both sides of the bounds between area and solid angle
    constexpr std::array kSizes = {0.001f, 0.05f, 0.3f, 1.0f, 5.0f, 100.0f};
    constexpr uint kCuts = 5;
    Uniform random(15);
    for (const float size : kSizes) {
        const LightRecord light = TriangleOfSize(size);
        const SphericalTriangle seen = SphericalTriangleFrom(light, vec3(0.0f));
        const glm::dvec3 p0(light.p0), e1(light.e1), e2(light.e2);
        const double whole = SolidAngle(p0, p0 + e1, p0 + e2);
        const bool isByAngle = seen.density > 0.0f;
        if (isByAngle) {
            EXPECT_NEAR(1.0 / double(seen.density), whole, 2e-4 * whole) << size;
        }
        // Cells of barycentrics, each cut in a lower and an upper triangle
        std::vector<double> expected, observed;
        std::map<std::array<uint, 3>, size_t> cells;
        for (uint i = 0; i < kCuts; ++i)
            for (uint j = 0; i + j < kCuts; ++j)
                for (uint upper = 0; upper < (i + j + 1 < kCuts ? 2u : 1u); ++upper) {
                    const auto at = [&](uint a, uint b) {
                        return p0 + (double(a) * e1 + double(b) * e2) / double(kCuts);
                    };
                    const double angle = upper == 0u
                                             ? SolidAngle(at(i, j), at(i + 1, j), at(i, j + 1))
                                             : SolidAngle(at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
                    cells[{i, j, upper}] = expected.size();
                    expected.push_back(3e5 * (isByAngle ? angle / whole : 1.0 / (kCuts * kCuts)));
                }
        observed.resize(expected.size(), 0.0);
        for (int n = 0; n < 300'000; ++n) {
            const vec2 b = SampleTriangleLight(light, seen, vec3(0.0f), random.Pair()).barycentrics;
            ASSERT_TRUE(b.x >= 0.0f && b.y >= 0.0f && b.x + b.y <= 1.0f + 1e-6f);
            const uint i = min(uint(b.x * float(kCuts)), kCuts - 1u);
            const uint j = min(uint(b.y * float(kCuts)), kCuts - 1u - i);
            const bool isUpper = b.x * float(kCuts) - float(i) + b.y * float(kCuts) - float(j) > 1.0f;
            observed[cells.at({i, j, isUpper && i + j + 1 < kCuts ? 1u : 0u})] += 1.0;
        }
        EXPECT_GT(test::ChiSquareTest(observed, expected).pValue, test::SidakLevel(0.01, kSizes.size()))
            << "size " << size << (isByAngle ? " by solid angle" : " by area");
    }
    EXPECT_EQ(SphericalTriangleFrom(TriangleOfSize(0.001f), vec3(0.0f)).density, 0.0f);
    EXPECT_GT(SphericalTriangleFrom(TriangleOfSize(1.0f), vec3(0.0f)).density, 0.0f);
}

TEST(TriangleLight, PDFIntegratesToOne) {
    // Directions to points that are uniform by area have dw = |cos| dA / d^2
    for (const float size : {0.001f, 0.05f, 1.0f, 5.0f}) {
        LightRecord light = TriangleOfSize(size);
        light.flags = kLightDoubleSided;
        double integral = 0.0;
        constexpr int kCount = 400;
        for (int i = 0; i < kCount; ++i)
            for (int j = 0; j < kCount; ++j) {
                const vec3 b = SampleUniformTriangle((vec2(float(i), float(j)) + 0.5f) / float(kCount));
                const vec3 p = light.p0 + b.y * light.e1 + b.z * light.e2;
                const float d = length(p);
                const vec3 wi = p / d;
                const float projected = 0.5f * std::abs(dot(cross(light.e1, light.e2), wi));
                integral += double(TriangleLightPDF(light, vec3(0.0f), d) * projected / (d * d));
            }
        EXPECT_NEAR(integral / (kCount * kCount), 1.0, 1e-3) << size;
    }
}

TEST(TriangleLight, PointsInItsPlaneAndAtItsCornersGiveNoNumbersThatAreNot) {
    testLights = {};
    testLights.AddTriangle(vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0), vec3(1.0f), true);
    testLights.Build();
    for (const vec3 position : {vec3(0, 0, 0), vec3(0.5f, 0, 0), vec3(0.2f, 0.2f, 0), vec3(2, 2, 0),
                                vec3(0.2f, 0.2f, 1e-7f), vec3(0.2f, 0.2f, 1e-30f)})
        for (int i = 0; i < 64; ++i) {
            const vec2 u((float(i % 8)) / 8.0f, float(i) / 64.0f);
            const LightSample s = SampleLight({position, vec3(0.0f)}, 0.5f, u);
            ASSERT_TRUE(s.pdf >= 0.0f && std::isfinite(s.pdf)) << s.pdf;
            ASSERT_TRUE(std::isfinite(s.distance));
            ASSERT_FALSE(std::isnan(s.wi.x));
        }
}

TEST(LightTree, ImportanceIsNoughtOnlyWhereNoLightArrives) {
    // Whatever the tree rules out for a context contributes nothing there
    MakeMixedScene();
    Uniform random(18);
    int ruledOut = 0;
    for (int i = 0; i < 2000; ++i) {
        const LightContext context{PointIn(random, 4.0f), random.Direction()};
        for (uint light = 0; light < LightSet().boundedCount; ++light) {
            const LightRecord record = LightAt(light);
            if (LightAliasAt(light).probability == 0.0f) continue;
            if (LightTreeProbability(0u, context, record.bitTrail) > 0.0f) continue;
            ++ruledOut;
            for (int k = 0; k < 8; ++k) {
                const LightSample s = record.kind == kLightTriangle
                                          ? SampleTriangle(record, context, random.Pair())
                                          : SamplePunctual(record, context);
                const bool arrives = s.pdf > 0.0f && MaxComponent(s.radiance) > 0.0f;
                ASSERT_FALSE(arrives && dot(s.wi, context.normal) > 1e-4f) << light;
            }
        }
    }
    EXPECT_GT(ruledOut, 10'000);
}

}  // namespace
}  // namespace raygraph::shading::light_sampling_test

// Meshes that are placed often: each placement is one light, and its triangles are there once.
namespace raygraph::shading::mesh_light_test {
namespace {

constexpr std::array kSamplers = {LightSampler::Uniform, LightSampler::Power, LightSampler::Bvh};
constexpr uint32_t kTriangles = 20;

// Turned, scaled unevenly and sheared, mirrored, flattened.
std::vector<glm::mat4x3> Transforms() {
    const glm::mat4x3 turned(vec3(0.0f, 1.2f, 0.0f), vec3(0.0f, 0.0f, 1.2f), vec3(1.2f, 0.0f, 0.0f),
                             vec3(-3.0f, 4.0f, 0.5f));
    const glm::mat4x3 uneven(vec3(2.0f, 0.3f, 0.0f), vec3(0.0f, 0.4f, 0.1f), vec3(0.2f, 0.0f, 0.8f),
                             vec3(2.5f, 3.0f, -1.0f));
    const glm::mat4x3 mirrored(vec3(-0.7f, 0.0f, 0.0f), vec3(0.0f, 0.5f, 0.5f), vec3(0.0f, -0.5f, 0.5f),
                               vec3(0.0f, 5.0f, 2.0f));
    const glm::mat4x3 flat(vec3(1.0f, 0.0f, 0.0f), vec3(0.0f, 0.0f, 0.0f), vec3(0.0f, 0.0f, 1.0f),
                           vec3(1.0f, 3.5f, 2.0f));
    return {turned, uneven, mirrored, flat};
}

// A lamp of triangles in all directions, placed four times, with a group that is placed once and a point
// light. Of the lamp one triangle is dark, some emit on both sides.
void MakeScene(bool isShared) {
    Uniform random(31);
    testLights = {};
    LightScene& scene = testLights.scene;
    scene.maxExpandedLights = isShared ? 0 : 1'000'000;
    for (uint32_t i = 0; i < kTriangles; ++i) {
        const vec3 p = PointIn(random, 0.5f);
        testLights.AddTriangle(p, p + PointIn(random, 0.4f), p + PointIn(random, 0.4f),
                               vec3(i == 3 ? 0.0f : 0.5f + 4.0f * random()), i % 4 == 0);
    }
    scene.groups.push_back({});
    for (uint32_t i = 0; i < 2; ++i) {
        const vec3 p = vec3(0.0f, 3.0f, -3.0f) + PointIn(random, 0.5f);
        scene.groups[1].push_back(
            {.p0 = p, .p1 = p + vec3(0, 0, 1), .p2 = p + vec3(1, 0, 0), .primitive = 5, .material = 5});
    }
    scene.placements.clear();
    scene.instances.clear();
    for (const glm::mat4x3& transform : Transforms()) {
        const auto index = static_cast<uint32_t>(scene.instances.size());
        scene.placements.push_back({.record = index, .instance = index, .group = 0});
        scene.instances.push_back({.objectToWorld = transform});
    }
    scene.placements.push_back({.record = 4, .instance = 4, .group = 1});
    scene.instances.push_back({});
    testLights.AddPunctual(scene::LightType::Point, vec3(1.0f, 4.0f, 1.0f), vec3(0, -1, 0), vec3(2.0f));
    testLights.Build();
}

struct Choice {
    uint light, triangle;
    double probability;
};

// Lists all lights that light sampling may choose at a context.
std::vector<Choice> Choices(const LightContext& context) {
    std::vector<Choice> choices;
    for (uint light = 0; light < LightSet().lightCount; ++light) {
        const LightRecord record = LightAt(light);
        const double chosen = double(LightProbability(LightSet(), context, light, record.bitTrail));
        const bool isMesh = record.kind == kLightMesh;
        const uint count = isMesh ? LightMeshAt(record.primitive).triangleCount : 1u;
        for (uint triangle = 0; triangle < count; ++triangle) {
            LightRecord within = record;
            const double share = double(ResolveHitMeshLight(within, context, triangle));
            choices.push_back({light, triangle, chosen * share});
        }
    }
    return choices;
}

std::vector<LightContext> Contexts() {
    return {{vec3(0.0f), vec3(0.0f)},
            {vec3(0.0f), vec3(0.0f, 1.0f, 0.0f)},
            {vec3(2.5f, 3.1f, -0.8f), vec3(0.0f)},  // inside a lamp
            {vec3(-3.0f, 3.0f, 0.5f), normalize(vec3(0.6f, 0.8f, 0.2f))},
            {vec3(30.0f, 1.0f, 0.0f), normalize(vec3(-1.0f, 0.2f, 0.1f))}};
}

// Irradiance of a triangle by Lambert's formula; all of it is above the plane of `normal` at the origin.
double IrradianceOf(const glm::dvec3 (&corners)[3], glm::dvec3 normal) {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 a = glm::normalize(corners[i]), b = glm::normalize(corners[(i + 1) % 3]);
        const glm::dvec3 across = glm::cross(a, b);
        const double sine = glm::length(across);
        sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(across / sine, normal);
    }
    return 0.5 * std::abs(sum);
}

// Returns the irradiance of everything at the origin facing +y, from the scene and not from the tables.
double Irradiance() {
    const LightScene& scene = testLights.scene;
    double sum = 0.0;
    for (const EmitterPlacement& placement : scene.placements) {
        const glm::dmat4x3 m(scene.instances[placement.instance].objectToWorld);
        const bool isMirrored = glm::determinant(glm::dmat3(m)) < 0.0;
        for (const Emitter& emitter : scene.groups[placement.group]) {
            const glm::dvec3 corners[3] = {m * glm::dvec4(emitter.p0, 1.0), m * glm::dvec4(emitter.p1, 1.0),
                                           m * glm::dvec4(emitter.p2, 1.0)};
            glm::dvec3 front = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
            if (isMirrored) front = -front;
            if (!emitter.isDoubleSided && glm::dot(front, corners[0]) >= 0.0) continue;
            sum += double(scene.emission[emitter.material].x) * IrradianceOf(corners, {0.0, 1.0, 0.0});
        }
    }
    const glm::dvec3 point(1.0, 4.0, 1.0);
    return sum + 2.0 * point.y / std::pow(glm::length(point), 3.0);
}

class MeshLight : public ::testing::TestWithParam<LightSampler> {
  protected:
    void SetUp() override {
        threadTraceFeatures =
            kTraceLightSampling | kTraceTriangleLights | kTracePunctualLights | kTraceMeshLights;
        threadLightSampler = GetParam();
    }
    void TearDown() override {
        threadTraceFeatures = m_features;
        threadLightSampler = LightSampler::Bvh;
    }

    const TraceFeatures m_features = threadTraceFeatures;
};

TEST_P(MeshLight, EveryPlacementIsOneLight) {
    MakeScene(true);
    EXPECT_EQ(LightSet().lightCount, 4u + 2u + 1u);
    EXPECT_EQ(testLights.table.EmissiveTriangleCount(), 4u * (kTriangles - 1u) + 2u);
    EXPECT_EQ(testLights.table.LightCount(), 7u + kTriangles);
    EXPECT_EQ(LightMeshAt(0u).activeCount, kTriangles - 1u);
}

TEST_P(MeshLight, FrequenciesAreTheProbabilitiesWhichSumToOne) {
    MakeScene(true);
    const double level = test::SidakLevel(0.01, int(Contexts().size() * kSamplers.size()));
    Uniform random(32);
    for (const LightContext& context : Contexts()) {
        const std::vector<Choice> choices = Choices(context);
        std::vector<double> expected, observed(choices.size() + 1, 0.0);
        double sum = 0.0;
        for (const Choice& choice : choices) {
            expected.push_back(3e5 * choice.probability);
            sum += choice.probability;
            if (choice.triangle == 3u) {
                EXPECT_EQ(choice.probability, 0.0) << "dark";
            }
        }
        EXPECT_LT(sum, 1.0 + 1e-5);
        // A tree may end at a node of which neither child can matter: no light then
        EXPECT_GT(sum, GetParam() == LightSampler::Bvh ? 0.5 : 1.0 - 1e-5);
        expected.push_back(3e5 * std::max(0.0, 1.0 - sum));
        if (expected.back() < 10.0) expected.back() = 0.0;  // rounding
        for (int i = 0; i < 300'000; ++i) {
            float uc = random();
            vec2 u(random(), random());
            const ChosenLight chosen = ChooseLight(LightSet(), context, uc, u.x);
            size_t at = choices.size();
            uint triangle = 0u;
            if (chosen.probability > 0.0f) {
                LightRecord light = LightAt(chosen.light);
                const float within = ResolveMeshLight(light, context, u, triangle);
                ASSERT_TRUE(u.x >= 0.0f && u.x < 1.0f && u.y >= 0.0f && u.y < 1.0f);
                if (within > 0.0f) {
                    const uint first =
                        chosen.light < 4u ? chosen.light * kTriangles : 4u * kTriangles + chosen.light - 4u;
                    at = first + triangle;
                    ASSERT_NEAR(double(chosen.probability * within), choices[at].probability,
                                1e-5 * choices[at].probability);
                }
            }
            observed[at] += 1.0;
        }
        EXPECT_GT(test::ChiSquareTest(observed, expected).pValue, level) << context.position.x;
    }
}

TEST_P(MeshLight, IrradianceIsTheClosedFormSharedOrNot) {
    for (const bool isShared : {false, true}) {
        MakeScene(isShared);
        const double expected = Irradiance();
        Uniform random(33);
        double sum = 0.0, squares = 0.0;
        constexpr int kCount = 400'000;
        for (int i = 0; i < kCount; ++i) {
            const float uc = random();
            const LightSample s = SampleLight({vec3(0.0f), vec3(0, 1, 0)}, uc, random.Pair());
            const double value = s.pdf > 0.0f ? double(s.radiance.x * max(s.wi.y, 0.0f) / s.pdf) : 0.0;
            sum += value;
            squares += value * value;
        }
        const double mean = sum / kCount;
        const double deviation = std::sqrt((squares / kCount - mean * mean) / kCount);
        EXPECT_NEAR(mean, expected, 4.0 * deviation) << isShared;
        EXPECT_LT(deviation, 0.01 * expected) << isShared;
    }
}

TEST_P(MeshLight, SamplesHaveTheDensityOfWhatTheirRayHits) {
    MakeScene(true);
    Uniform random(34);
    int found = 0;
    for (const LightContext& context : Contexts())
        for (int i = 0; i < 20'000; ++i) {
            const float uc = random();
            const LightSample s = SampleLight(context, uc, random.Pair());
            if (s.pdf == 0.0f || s.isDelta != 0u || s.light >= 4u) continue;
            ++found;
            const Emitter& emitter = testLights.scene.groups[0][s.triangle];
            ASSERT_EQ(s.radiance, testLights.scene.emission[emitter.material]);
            // In the plane of the triangle, as the scene places it
            const glm::dmat4x3 m(testLights.scene.instances[s.light].objectToWorld);
            const glm::dvec3 p0 = m * glm::dvec4(emitter.p0, 1.0);
            const glm::dvec3 e1 = glm::dvec3(m * glm::dvec4(emitter.p1, 1.0)) - p0;
            const glm::dvec3 e2 = glm::dvec3(m * glm::dvec4(emitter.p2, 1.0)) - p0;
            const glm::dvec3 normal = glm::normalize(glm::cross(e1, e2));
            const glm::dvec3 point = glm::dvec3(context.position) + double(s.distance) * glm::dvec3(s.wi);
            ASSERT_NEAR(glm::dot(point - p0, normal), 0.0, 1e-5);
            ASSERT_LT(glm::dot(glm::dvec3(s.target) - p0, normal) * glm::dot(glm::dvec3(s.wi), normal), 0.0)
                << "the ray must end before the triangle";
            ASSERT_NEAR(LightPDF(context, s.light, s.triangle, s.wi, s.distance), s.pdf, 1e-3f * s.pdf);
        }
    EXPECT_GT(found, 20'000);
}

INSTANTIATE_TEST_SUITE_P(Samplers, MeshLight, ::testing::ValuesIn(kSamplers));

TEST(LightMesh, PowersAreThoseOfItsTriangles) {
    MakeScene(false);
    std::vector<double> expanded(4, 0.0);
    double rest = 0.0, sharedRest = 0.0;
    for (uint i = 0; i < LightSet().lightCount; ++i)
        (i < 4u * kTriangles ? expanded[i / kTriangles] : rest) += double(LightAliasAt(i).probability);
    MakeScene(true);
    for (uint i = 0; i < 4u; ++i) EXPECT_NEAR(double(LightAliasAt(i).probability), expanded[i], 1e-6) << i;
    for (uint i = 4; i < LightSet().lightCount; ++i) sharedRest += double(LightAliasAt(i).probability);
    EXPECT_NEAR(sharedRest, rest, 1e-6);
}

TEST(LightMesh, BoundsContainThePlacedTriangles) {
    MakeScene(true);
    const LightScene& scene = testLights.scene;
    const LightMesh mesh(scene.groups[0], scene.emission, {});
    for (const glm::mat4x3& transform : Transforms()) {
        const LightBounds bounds = mesh.Placed(transform);
        EXPECT_TRUE(bounds.isTwoSided);
        for (const Emitter& emitter : scene.groups[0]) {
            if (scene.emission[emitter.material].x == 0.0f) continue;
            const LightRecord light = TriangleLight(emitter, 0, transform);
            for (const vec3 corner : {light.p0, light.p0 + light.e1, light.p0 + light.e2})
                for (int axis = 0; axis < 3; ++axis) {
                    EXPECT_GE(corner[axis], bounds.min[axis] - 1e-5f);
                    EXPECT_LE(corner[axis], bounds.max[axis] + 1e-5f);
                }
            glm::dvec3 normal = glm::cross(glm::dvec3(light.e1), glm::dvec3(light.e2));
            if (glm::length(normal) < 1e-6) continue;
            normal = glm::normalize(normal);
            if ((light.flags & kLightMirrored) != 0u) normal = -normal;
            EXPECT_LE(std::acos(std::clamp(glm::dot(normal, bounds.axis), -1.0, 1.0)), bounds.thetaO + 1e-4);
        }
    }
    // A flat panel stays flat
    const std::vector<Emitter> panel{{.p1 = vec3(0, 0, 1), .p2 = vec3(1, 0, 0)}};
    const LightMesh flat(panel, std::vector<vec3>{vec3(1.0f)}, {});
    EXPECT_LT(flat.Placed(Transforms()[1]).thetaO, 2e-3);
}

TEST(LightMesh, MeshesAreSharedWhereExpandingThemTakesMore) {
    MakeScene(true);
    LightScene scene = testLights.scene;
    scene.maxExpandedLights = 4 * kTriangles;
    EXPECT_EQ(scene.NumberEmitters(), 4 * kTriangles + 2);
    EXPECT_FALSE(scene.isShared[0]);
    scene.maxExpandedLights = 4 * kTriangles - 1;
    EXPECT_EQ(scene.NumberEmitters(), 4u + 2u);
    EXPECT_TRUE(scene.isShared[0]);
    EXPECT_FALSE(scene.isShared[1]) << "placed once";
    scene.isDeformed = {true, false};
    EXPECT_EQ(scene.NumberEmitters(), 4 * kTriangles + 2);
}

}  // namespace
}  // namespace raygraph::shading::mesh_light_test

// Sampling of directions to the environment.
namespace raygraph::shading::environment_light_test {
namespace {

TEST(EnvironmentLight, DirectionsFollowTheDensityOfTheCells) {
    Uniform random(16);
    testLights = {};
    testLights.SetEnvironment(RandomMap(16, 8, random), vec3(1.0f), 1.1f);
    testLights.Build();
    // Quarters of cells: halves in azimuth and in cos theta
    constexpr uint kColumns = 32, kRows = 16;
    std::vector<double> observed(kColumns * kRows, 0.0), expected(kColumns * kRows);
    for (uint row = 0; row < kRows; ++row)
        for (uint column = 0; column < kColumns; ++column)
            expected[row * kColumns + column] =
                0.25 * 3e5 * double(EnvironmentEntryAt(8u + row / 2u * 16u + column / 2u).probability);
    for (int i = 0; i < 300'000; ++i) {
        const float choice = random();
        const EnvironmentSample s = SampleEnvironmentLight(LightSet(), choice, random.Pair());
        const vec2 uv = EquirectFromDirection(s.wi, 1.1f);
        const uint row = min(uint(uv.y * 8.0f), 7u);
        const double cosMiddle = 0.5 * (std::cos(M_PI * row / 8.0) + std::cos(M_PI * (row + 1.0) / 8.0));
        const uint subRow = 2u * row + (double(s.wi.y) < cosMiddle ? 1u : 0u);
        observed[subRow * kColumns + min(uint(uv.x * float(kColumns)), kColumns - 1u)] += 1.0;
        ASSERT_NEAR(length(s.wi), 1.0f, 1e-5f);
    }
    EXPECT_GT(test::ChiSquareTest(observed, expected).pValue, 0.01);
}

// A choice of the table by the definition: the first entry whose end is above u.
uint ChosenByDefinition(uint first, uint count, float u) {
    uint entry = 0;
    while (entry + 1u < count && !(u < EnvironmentEntryAt(first + entry).end)) ++entry;
    return entry;
}

// Even, so that entries end where slots do, but for three black rows, of which no light reaches the middle.
image::ImageF BandedMap(uvec2 size) {
    image::ImageF map{.width = size.x, .height = size.y, .rgba = {}};
    for (uint32_t i = 0; i < 4 * size.x * size.y; ++i)
        map.rgba.push_back(float((i / 4 / size.x + 1) / 3 != 1));
    return map;
}

// The left half is 1. The right half is half of the mean, which is left to BSDF sampling, and 2^-10 to 2^-26
// of that more: entries of all numbers of steps, from one on.
image::ImageF BarelyAboveTheLevel(uvec2 size, Uniform& random) {
    const image::ImageF exponents = RandomMap(size.x, size.y, random);
    image::ImageF map = exponents;
    float level = 0.3f;
    for (int i = 0; i < 60; ++i) {  // the mean depends on the level
        for (uint32_t y = 0; y < size.y; ++y)
            for (uint32_t x = 0; x < size.x; ++x) {
                const size_t at = 4 * (y * size.x + x);
                const float above = std::exp2(-10.0f - 16.0f * exponents.rgba[at]);
                for (size_t c = 0; c < 3; ++c)
                    map.rgba[at + c] = 2 * x < size.x ? 1.0f : level + level * above;
            }
        level = 0.5f * BuildEnvironmentTable(map).meanRadiance.y;
    }
    return map;
}

TEST(EnvironmentLight, EachStepOfTheNumberChoosesTheEntryThatItsProbabilityCounts) {
    Uniform random(18);
    for (const uvec2 size : {uvec2(1u, 1u), uvec2(16u, 8u), uvec2(7u, 5u), uvec2(301u, 3u), uvec2(13u, 6u)}) {
        testLights = {};
        const image::ImageF map = size.x == 13u ? BandedMap(size) : BarelyAboveTheLevel(size, random);
        testLights.SetEnvironment(map, vec3(1.0f));
        testLights.Build();
        uint few = 0;  // entries of at most 64 steps
        const auto expectRow = [&few](uint first, uint count, float share) {
            double sum = 0.0;
            for (uint i = 0; i < count; ++i) {
                const float begin = i > 0u ? EnvironmentEntryAt(first + i - 1u).end : 0.0f;
                const float end = EnvironmentEntryAt(first + i).end;
                ASSERT_NEAR(EnvironmentEntryAt(first + i).probability, share * (end - begin),
                            1e-6f * share * (end - begin));
                sum += double(end - begin);
                few += end > begin && end - begin <= 0x1p-18f;
                for (const float u : {begin, begin + 0x1p-24f, 0.5f * (begin + end), end - 0x1p-24f, end,
                                      float(i) / float(count), float(i + 1u) / float(count) - 0x1p-24f}) {
                    if (u < 0.0f || u > kOneMinusEpsilon) continue;
                    float rest = u;
                    ASSERT_EQ(InvertEnvironmentTable(first, count, 0.0f, rest),
                              ChosenByDefinition(first, count, u))
                        << u << " of " << count;
                    ASSERT_TRUE(rest >= 0.0f && rest < 1.0f);
                }
            }
            ASSERT_EQ(sum, 1.0);
        };
        expectRow(0u, size.y, 1.0f);
        for (uint row = 0; row < size.y; ++row)
            if (const float share = EnvironmentEntryAt(row).probability; share > 0.0f)
                expectRow(size.y + row * size.x, size.x, share);
        if (HasFatalFailure()) return;
        if (size.x != 1u && size.x != 13u) {
            EXPECT_GT(few, 0u);
        }
    }
}

// The number that decides between a light and another one must not have lost its digits when it chooses a cell.
TEST(EnvironmentLight, BesideASunEveryCellHasItsChance) {
    constexpr uint kColumns = 64;
    Uniform random(20);
    LightContext context = {};
    context.normal = vec3(0.0f, 1.0f, 0.0f);
    float keep = 1.0f;
    for (float sun = 1.0f; keep * 0x1p24f > 64.0f; sun *= 4.0f) {
        ASSERT_LT(sun, 1e20f);
        testLights = {};
        testLights.SetEnvironment(RandomMap(kColumns, 2, random), vec3(1.0f));
        testLights.AddPunctual(scene::LightType::Directional, vec3(0.0f), vec3(0.0f, -1.0f, 0.0f), vec3(sun));
        testLights.Build();
        keep = LightAliasAt(LightSet().lightCount + 2u).keep;
    }
    const LightSetRecord lights = LightSet();
    const auto kept = uint(std::ceil(keep * 0x1p24f));
    ASSERT_GT(kept, 4u);
    constexpr uint kChoices = 8192;
    std::vector<double> columns(kColumns, 0.0);
    double all = 0.0;
    for (uint step = 0; step < kept; ++step)
        for (uint i = 0; i < kChoices; ++i) {
            const float uc = 0.5f + (float(i) + 0.5f) / (2.0f * kChoices);
            const LightSample light = SampleLight(context, uc, vec2(float(step) * 0x1p-24f, 0.25f));
            if (light.light != lights.lightCount) continue;
            all += 1.0;
            columns[min(uint(EquirectFromDirection(light.wi, 0.0f).x * kColumns), kColumns - 1u)] += 1.0;
        }
    EXPECT_GT(all, 0.9 * kept * kChoices);
    const uint first = lights.environmentHeight;  // the cells of the upper row
    for (uint column = 0; column < kColumns; ++column) {
        const double share =
            EnvironmentEntryAt(first + column).probability / EnvironmentEntryAt(0u).probability;
        // The last of the few steps is only in part below `keep`, and counts as a whole one
        EXPECT_GE(columns[column] / all, 0.9 * share * (kept - 1.0) / kept) << column;
        EXPECT_LT(columns[column] / all, 1.1 * share + 1.0 / kept) << column;
    }
}

TEST(EnvironmentLight, EvenNumbersGiveEvenDirections) {
    Uniform random(19);
    testLights = {};
    testLights.SetEnvironment(RandomMap(16, 8, random), vec3(1.0f));
    testLights.Build();
    constexpr int kCount = 1024;
    std::vector<double> rows(8, 0.0);
    for (uint i = 0; i < kCount; ++i) {
        Sampler rng = StartPixelSample(uvec2(2u, 3u), i, 4u);
        const vec3 u = Get3D(rng);
        const vec3 wi = SampleEnvironmentLight(LightSet(), u.z, vec2(u)).wi;
        rows[min(uint(EquirectFromDirection(wi, 0.0f).y * 8.0f), 7u)] += 1.0;
    }
    // Independent numbers, or an alias table, would miss by about the root of the number
    for (uint row = 0; row < 8; ++row)
        EXPECT_NEAR(rows[row], kCount * double(EnvironmentEntryAt(row).probability), 2.0) << row;
}

TEST(EnvironmentLight, PDFIntegratesToOne) {
    Uniform random(17);
    for (const uvec2 size : {uvec2(1u, 1u), uvec2(16u, 8u), uvec2(7u, 5u)}) {
        testLights = {};
        testLights.SetEnvironment(RandomMap(size.x, size.y, random), vec3(1.0f), 0.4f);
        testLights.Build();
        double integral = 0.0;
        constexpr int kCount = 1000;
        for (int i = 0; i < kCount; ++i)
            for (int j = 0; j < kCount; ++j) {
                const vec3 d = SampleUniformSphere((vec2(float(i), float(j)) + 0.5f) / float(kCount));
                integral +=
                    double(LightPDF({d, d}, LightSet().lightCount, 0u, vec3(d.x, d.z, d.y), kInfinity));
            }
        EXPECT_NEAR(integral * 4.0 * M_PI / (kCount * kCount), 1.0, 2e-3) << size.x;
    }
}

}  // namespace
}  // namespace raygraph::shading::environment_light_test

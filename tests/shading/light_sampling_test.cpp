// Choice of lights and directions: probabilities are those that are claimed.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <random>

#include "core/rng.glsl"
#include "tests/shading/light_scene.h"
#include "tests/shading/random_values.h"
#include "tests/support/chi_square.h"

namespace raygraph::shading::light_sampling_test {
namespace {

constexpr std::array kSamplers = {LightSampler::Uniform, LightSampler::Power, LightSampler::Bvh};

// Lights of every kind about the origin, one of them dark.
void MakeMixedScene() {
    std::mt19937 random(11);
    testLights = {};
    testLights.scene.radius = 2.0f;
    for (int i = 0; i < 40; ++i) {
        const vec3 p = PointIn(random, 3.0f);
        testLights.AddTriangle(p, p + PointIn(random, 0.5f), p + PointIn(random, 0.5f),
                               vec3(i == 7 ? 0.0f : 5.0f * Uniform(random)), i % 4 == 0);
    }
    for (int i = 0; i < 10; ++i)
        testLights.AddPunctual(i % 2 == 0 ? scene::LightType::Point : scene::LightType::Spot,
                               PointIn(random, 3.0f), DirectionIn(random), vec3(3.0f * Uniform(random)), 0.2f,
                               1.2f);
    testLights.AddPunctual(scene::LightType::Directional, vec3(0.0f), DirectionIn(random), vec3(0.4f));
    testLights.AddPunctual(scene::LightType::Directional, vec3(0.0f), DirectionIn(random), vec3(0.1f));
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
    std::mt19937 random(12);
    for (const LightContext& context : Contexts()) {
        std::vector<double> expected(count + 1), observed(count + 1, 0.0);
        double sum = 0.0;
        for (uint light = 0; light < count; ++light) {
            const double p = Probability(context, light);
            expected[light] = 1e6 * p;
            sum += p;
        }
        // The tree may end at a node of which neither child can matter: no light then
        EXPECT_LT(sum, 1.0 + 1e-5);
        if (GetParam() != LightSampler::Bvh) {
            EXPECT_GT(sum, 1.0 - 1e-5);
        }
        EXPECT_GT(sum, 0.5);
        expected[count] = 1e6 * std::max(0.0, 1.0 - sum);
        if (expected[count] < 10.0) expected[count] = 0.0;  // rounding
        for (int i = 0; i < 1'000'000; ++i) {
            float uc = Uniform(random), ux = Uniform(random);
            const ChosenLight chosen = ChooseLight(LightSet(), context, uc, ux);
            const bool isChosen = chosen.probability > 0.0f;
            observed[isChosen ? chosen.light : count] += 1.0;
            if (isChosen && i % 100 == 0) {
                ASSERT_NEAR(double(chosen.probability), expected[chosen.light] * 1e-6,
                            1e-5 * double(chosen.probability));
            }
        }
        EXPECT_GT(test::ChiSquareTest(observed, expected).pValue, level);
    }
}

TEST_P(LightSampling, NumbersLeftOverAreUniform) {
    MakeMixedScene();
    std::mt19937 random(13);
    const LightContext context = Contexts()[1];
    double sumC = 0.0, sumX = 0.0;
    constexpr int kCount = 200'000;
    for (int i = 0; i < kCount; ++i) {
        float uc = Uniform(random), ux = Uniform(random);
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
    std::mt19937 random(14);
    int triangles = 0, environments = 0, deltas = 0, disagreements = 0;
    for (const LightContext& context : Contexts()) {
        for (int i = 0; i < 50'000; ++i) {
            const float uc = Uniform(random);
            const LightSample s = SampleLight(context, uc, vec2(Uniform(random), Uniform(random)));
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
    std::mt19937 random(15);
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
                    expected.push_back(1e6 * (isByAngle ? angle / whole : 1.0 / (kCuts * kCuts)));
                }
        observed.resize(expected.size(), 0.0);
        for (int n = 0; n < 1'000'000; ++n) {
            const vec2 b =
                SampleTriangleLight(light, seen, vec3(0.0f), vec2(Uniform(random), Uniform(random)))
                    .barycentrics;
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
    std::mt19937 random(18);
    int ruledOut = 0;
    for (int i = 0; i < 2000; ++i) {
        const LightContext context{PointIn(random, 4.0f), DirectionIn(random)};
        for (uint light = 0; light < LightSet().boundedCount; ++light) {
            const LightRecord record = LightAt(light);
            if (LightAliasAt(light).probability == 0.0f) continue;
            if (LightTreeProbability(0u, context, record.bitTrail) > 0.0f) continue;
            ++ruledOut;
            for (int k = 0; k < 8; ++k) {
                const LightSample s =
                    record.kind == kLightTriangle
                        ? SampleTriangle(record, context, vec2(Uniform(random), Uniform(random)))
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

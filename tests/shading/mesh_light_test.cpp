// Meshes that are placed often: each placement is one light, and its triangles are there once.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <utility>

#include "renderer/gpu_scene/lights/light_mesh.h"
#include "tests/shading/light_scene.h"
#include "tests/shading/random_values.h"
#include "tests/support/chi_square.h"

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
    std::mt19937 random(31);
    testLights = {};
    LightScene& scene = testLights.scene;
    scene.maxExpandedLights = isShared ? 0 : 1'000'000;
    for (uint32_t i = 0; i < kTriangles; ++i) {
        const vec3 p = PointIn(random, 0.5f);
        testLights.AddTriangle(p, p + PointIn(random, 0.4f), p + PointIn(random, 0.4f),
                               vec3(i == 3 ? 0.0f : 0.5f + 4.0f * Uniform(random)), i % 4 == 0);
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
    std::mt19937 random(32);
    for (const LightContext& context : Contexts()) {
        const std::vector<Choice> choices = Choices(context);
        std::vector<double> expected, observed(choices.size() + 1, 0.0);
        double sum = 0.0;
        for (const Choice& choice : choices) {
            expected.push_back(1e6 * choice.probability);
            sum += choice.probability;
            if (choice.triangle == 3u) {
                EXPECT_EQ(choice.probability, 0.0) << "dark";
            }
        }
        EXPECT_LT(sum, 1.0 + 1e-5);
        // A tree may end at a node of which neither child can matter: no light then
        EXPECT_GT(sum, GetParam() == LightSampler::Bvh ? 0.5 : 1.0 - 1e-5);
        expected.push_back(1e6 * std::max(0.0, 1.0 - sum));
        if (expected.back() < 10.0) expected.back() = 0.0;  // rounding
        for (int i = 0; i < 1'000'000; ++i) {
            float uc = Uniform(random);
            vec2 u(Uniform(random), Uniform(random));
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
        std::mt19937 random(33);
        double sum = 0.0, squares = 0.0;
        constexpr int kCount = 400'000;
        for (int i = 0; i < kCount; ++i) {
            const float uc = Uniform(random);
            const LightSample s =
                SampleLight({vec3(0.0f), vec3(0, 1, 0)}, uc, vec2(Uniform(random), Uniform(random)));
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
    std::mt19937 random(34);
    int found = 0;
    for (const LightContext& context : Contexts())
        for (int i = 0; i < 20'000; ++i) {
            const float uc = Uniform(random);
            const LightSample s = SampleLight(context, uc, vec2(Uniform(random), Uniform(random)));
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

// Tables of lights, and what counts as an emitter.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/gpu_scene/lights/light_bvh.h"
#include "renderer/gpu_scene/lights/light_table.h"
#include "tests/shading/light_scene.h"

// The tables behind light sampling, as the host builds them.
namespace raygraph::shading::light_tables_test {
namespace {

// Returns the probability of each outcome by a table's slots.
std::vector<double> Outcomes(std::span<const AliasEntry> slots) {
    std::vector<double> result(slots.size(), 0.0);
    for (size_t i = 0; i < slots.size(); ++i) {
        result[i] += double(slots[i].keep) / double(slots.size());
        result[slots[i].alias] += (1.0 - double(slots[i].keep)) / double(slots.size());
    }
    return result;
}

TEST(AliasTable, OutcomesHaveTheSharesOfTheWeights) {
    std::mt19937 random(1);
    for (const size_t count : {1u, 2u, 3u, 1000u}) {
        std::vector<double> weights(count);
        double sum = 0.0;
        for (double& weight : weights) {
            weight = random() % 4 == 0 ? 0.0 : std::pow(10.0, double(random() % 9));
            sum += weight;
        }
        if (sum == 0.0) weights[0] = sum = 1.0;
        std::vector<AliasEntry> slots(count);
        EXPECT_NEAR(BuildAliasTable(weights, slots), sum, 1e-9 * sum);
        const std::vector<double> outcomes = Outcomes(slots);
        for (size_t i = 0; i < count; ++i) {
            EXPECT_NEAR(outcomes[i], weights[i] / sum, 1e-6 / double(count));
            EXPECT_NEAR(double(slots[i].probability), weights[i] / sum, 1e-6 * weights[i] / sum);
            if (weights[i] == 0.0) {
                EXPECT_EQ(outcomes[i], 0.0) << "never chosen";
            }
        }
    }
}

TEST(AliasTable, WithoutWeightsEverySlotHasProbabilityZero) {
    std::vector<AliasEntry> slots(3);
    EXPECT_EQ(BuildAliasTable(std::vector<double>(3, 0.0), slots), 0.0);
    for (const AliasEntry& slot : slots) EXPECT_EQ(slot.probability, 0.0f);
}

image::ImageF BlackMap(uint32_t width, uint32_t height) {
    return {.width = width, .height = height, .rgba = std::vector<float>(size_t{4} * width * height, 0.0f)};
}

void SetTexel(image::ImageF& map, uint32_t x, uint32_t y, vec3 color) {
    for (int c = 0; c < 3; ++c) map.rgba[4 * (y * map.width + x) + size_t(c)] = color[c];
}

TEST(EnvironmentTable, WhereInterpolationLeavesLightThereIsDensity) {
    // One bright texel at the seam, in the top row, in the middle: its light reaches the cells around it, whose
    // means are above half of that of the map
    for (const uvec2 bright : {uvec2(0u, 3u), uvec2(7u, 0u), uvec2(4u, 6u), uvec2(15u, 7u)}) {
        testLights = {};
        image::ImageF map = BlackMap(16, 8);
        SetTexel(map, bright.x, bright.y, vec3(1e5f));
        testLights.SetEnvironment(map, vec3(1.0f));
        testLights.Build();
        std::mt19937 random(2);
        int litCount = 0;
        for (int i = 0; i < 100'000; ++i) {
            const vec3 wi =
                SampleUniformSphere(vec2(float(random() >> 8) * 0x1p-24f, float(random() >> 8) * 0x1p-24f));
            const bool isLit = MaxComponent(EnvironmentRadiance(wi)) > 0.0f;
            litCount += isLit;
            if (isLit) {
                ASSERT_GT(EnvironmentLightPDF(LightSet(), wi), 0.0f);
            }
        }
        EXPECT_GT(litCount, 100);
    }
}

TEST(EnvironmentTable, MeanRadianceIsThatOverTheSphere) {
    image::ImageF map = BlackMap(64, 32);
    for (uint32_t y = 0; y < 16; ++y)
        for (uint32_t x = 0; x < 64; ++x) SetTexel(map, x, y, vec3(2.0f, 4.0f, 100'000.0f));
    const EnvironmentTable table = BuildEnvironmentTable(map);
    EXPECT_NEAR(table.meanRadiance.x, 1.0f, 1e-4f);
    EXPECT_NEAR(table.meanRadiance.z, 50'000.0f, 5.0f) << "beyond half floats";
}

// Radiance cos(theta) above the horizon gives 2 pi / 3, whatever is below; a middle row is half above it.
TEST(EnvironmentTable, SkyIrradianceIsThatOfTheUpperHalf) {
    for (const uint32_t height : {64u, 65u}) {
        image::ImageF map = BlackMap(8, height);
        for (uint32_t y = 0; y < height; ++y)
            for (uint32_t x = 0; x < 8; ++x)
                SetTexel(map, x, y,
                         vec3(std::max(std::cos(kPi * (float(y) + 0.5f) / float(height)), 0.0f), 1.0f,
                              2 * y > height + 2 ? 1e3f : 0.0f));
        const vec3 irradiance = BuildEnvironmentTable(map).skyIrradiance;
        EXPECT_NEAR(irradiance.x, 2.0f * kPi / 3.0f, 2e-3f);
        EXPECT_NEAR(irradiance.y, kPi, 1e-5f);
        EXPECT_EQ(irradiance.z, 0.0f);
    }
    EXPECT_EQ(ConstantEnvironmentTable().skyIrradiance, vec3(kPi));
}

// Above the horizon 3 and 5 by turns in bands of four columns, below it 0.4: the mean is 2.2, and what is
// above half of it 1.9, 3.9 and nothing.
TEST(EnvironmentTable, DensityIsThatOfTheLightAboveHalfOfTheMean) {
    image::ImageF map = BlackMap(32, 16);
    for (uint32_t y = 0; y < 16; ++y)
        for (uint32_t x = 0; x < 32; ++x)
            SetTexel(map, x, y, vec3(y >= 8 ? 0.4f : x / 4 % 2 == 0 ? 3.0f : 5.0f));
    testLights = {};
    testLights.SetEnvironment(map, vec3(1.0f));
    testLights.Build();
    const auto density = [](uint32_t x, uint32_t y) {
        return EnvironmentLightPDF(LightSet(),
                                   DirectionFromEquirect((vec2(x, y) + 0.5f) / vec2(32.0f, 16.0f), 0.0f));
    };
    for (uint32_t y = 1; y < 7; ++y)
        for (uint32_t band = 0; band < 32; band += 8)
            EXPECT_NEAR(density(band + 5, y) / density(band + 2, y), 3.9 / 1.9, 1e-3) << y << ", " << band;
    for (uint32_t y = 9; y < 16; ++y)
        for (uint32_t x = 0; x < 32; ++x) EXPECT_EQ(density(x, y), 0.0f) << x << ", " << y;
    EXPECT_NEAR(testLights.environment.meanRadiance.y, 2.2f, 0.01f) << "the power is that of all light";
}

TEST(EnvironmentTable, EvenMapsHaveDensityEverywhere) {
    image::ImageF map = BlackMap(8, 4);
    for (float& value : map.rgba) value = 0.7f;
    testLights = {};
    testLights.SetEnvironment(map, vec3(1.0f));
    testLights.Build();
    std::mt19937 random(5);
    for (int i = 0; i < 1000; ++i) {
        const vec3 wi =
            SampleUniformSphere(vec2(float(random() >> 8) * 0x1p-24f, float(random() >> 8) * 0x1p-24f));
        EXPECT_NEAR(EnvironmentLightPDF(LightSet(), wi), 0.25 / M_PI, 1e-4);
    }
}

TEST(EnvironmentTable, LargeMapsShareCells) {
    image::ImageF map = BlackMap(64, 32);
    std::mt19937 random(3);
    for (float& value : map.rgba) value = float(random() % 100);
    const EnvironmentTable fine = BuildEnvironmentTable(map);
    const EnvironmentTable coarse = BuildEnvironmentTable(map, 200);
    ASSERT_EQ(coarse.width, 16u);
    ASSERT_EQ(coarse.height, 8u);
    double sum = 0.0;
    for (uint32_t y = 0; y < 4; ++y)
        for (uint32_t x = 0; x < 4; ++x) sum += double(fine.entries[32 + (8 + y) * 64 + 20 + x].probability);
    EXPECT_NEAR(double(coarse.entries[8 + 2 * 16 + 5].probability), sum, 1e-6);
    EXPECT_NEAR(coarse.meanRadiance.y, fine.meanRadiance.y, 1e-4f);
}

// Checks a subtree, returns the lights below.
uint32_t CheckNode(const std::vector<LightNode>& nodes, std::span<const LightRecord> lights, uint32_t index,
                   uint32_t depth, uint32_t trail) {
    const LightNode& node = nodes.at(index);
    EXPECT_NEAR(length(node.axis), 1.0f, 1e-5f);
    if ((node.link & kLightNodeLeaf) != 0u) {
        const LightRecord& light = lights[node.link & kLightNodeIndex];
        EXPECT_EQ(light.bitTrail, trail);
        return 1;
    }
    EXPECT_LT(depth, 32u);
    const uint32_t first = node.link & kLightNodeIndex;
    EXPECT_GT(first, index);
    double power = 0.0;
    for (uint32_t child = first; child < first + 2; ++child) {
        power += double(nodes.at(child).power);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_LE(node.boundsMin[axis], nodes[child].boundsMin[axis]);
            EXPECT_GE(node.boundsMax[axis], nodes[child].boundsMax[axis]);
        }
        // The child's cone lies within the parent's
        const float childO = acos(unpackSnorm2x16(nodes[child].cones).x);
        const float parentO = acos(unpackSnorm2x16(node.cones).x);
        const float between = acos(clamp(dot(node.axis, nodes[child].axis), -1.0f, 1.0f));
        EXPECT_LE(min(between + childO, kPi), parentO + 2e-2f);
        EXPECT_GE(unpackSnorm2x16(nodes[child].cones).y, unpackSnorm2x16(node.cones).y);
    }
    EXPECT_NEAR(double(node.power), power, 1e-5 * power);
    return CheckNode(nodes, lights, first, depth + 1, trail) +
           CheckNode(nodes, lights, first + 1, depth + 1, trail | (1u << depth));
}

uint32_t CheckTree() {
    std::vector<LightRecord> lights;
    for (uint i = 0; i < LightSet().lightCount; ++i) lights.push_back(LightAt(i));
    std::vector<LightNode> nodes;
    for (uint i = 0; i < LightSet().nodeCount; ++i) nodes.push_back(LightNodeAt(i));
    return CheckNode(nodes, lights, 0, 0, 0);
}

LightRecord PointAt(vec3 position) {
    LightRecord light{};
    light.p0 = position;
    light.kind = kLightPoint;
    light.e2 = vec3(1.0f);
    return light;
}

TEST(LightTree, NodesBoundWhatIsBelowAndTrailsLeadToTheLeaves) {
    std::mt19937 random(4);
    const auto coordinate = [&] { return float(random() % 20'000) * 0.001f - 10.0f; };
    std::vector<LightRecord> lights;
    std::vector<float> power;
    uint32_t shiningCount = 0;
    for (int i = 0; i < 3000; ++i) {
        LightRecord light = PointAt(vec3(coordinate(), coordinate(), coordinate()));
        light.kind = uint(i % 3);
        light.e1 = normalize(vec3(coordinate(), coordinate(), coordinate()));
        light.e2 = vec3(coordinate(), coordinate(), coordinate());
        light.spotScale = 4.0f;
        light.spotOffsetOrClearance = -2.0f;
        light.flags = random() % 4;
        lights.push_back(light);
        power.push_back(random() % 5 == 0 ? 0.0f : float(random() % 100 + 1));
        shiningCount += power.back() > 0.0f;
    }
    const LightTree tree = BuildLightTree(lights, power);
    const std::vector<LightNode>& nodes = tree.Nodes();
    EXPECT_EQ(nodes.size(), 2 * shiningCount - 1);
    EXPECT_EQ(CheckNode(nodes, lights, 0, 0, 0), shiningCount);
}

TEST(LightTree, DepthStaysWithinATrailForTheWorstOfScenes) {
    // All are in one place; then each is a fiftieth nearer to a corner than the last
    for (const bool isOnePlace : {true, false}) {
        std::vector<LightRecord> lights;
        for (int i = 0; i < 4000; ++i)
            lights.push_back(PointAt(vec3(isOnePlace ? 1.0f : float(std::pow(0.98, i) * 1e6), 0.0f, 0.0f)));
        const std::vector<float> power(lights.size(), 1.0f);
        const LightTree tree = BuildLightTree(lights, power);
        const std::vector<LightNode>& nodes = tree.Nodes();
        EXPECT_EQ(CheckNode(nodes, lights, 0, 0, 0), 4000u);
    }
}

TEST(LightTree, NoLightsNoNodes) {
    EXPECT_TRUE(BuildLightTree({}, {}).Nodes().empty());
    std::vector<LightRecord> dark{PointAt(vec3(0.0f))};
    EXPECT_TRUE(BuildLightTree(dark, std::vector<float>{0.0f}).Nodes().empty());
}

TEST(LightTable, HiddenAndDarkTrianglesKeepTheirNumberAndNeverShine) {
    testLights = {};
    const vec3 x(1, 0, 0), y(0, 1, 0), o(0.0f);
    testLights.AddTriangle(o, x, y, vec3(0.0f));
    testLights.AddTriangle(o, x, x, vec3(1.0f));  // without area
    testLights.AddTriangle(o, x, y, vec3(1.0f));
    testLights.scene.placements = {{.record = 7}, {.record = 9, .instance = 1}};
    testLights.scene.instances = {{.objectToWorld = glm::mat4x3(1.0f), .isVisible = false}, {}};
    testLights.Build();
    const LightTable& table = testLights.table;
    EXPECT_EQ(testLights.scene.placements[1].firstLight, 3u);
    ASSERT_EQ(table.LightCount(), 6u);
    EXPECT_EQ(table.LightAt(5).instance, 9u);
    EXPECT_EQ(table.LightAt(5).primitive, 2u);
    EXPECT_EQ(table.EmissiveTriangleCount(), 1u);
    EXPECT_EQ(table.Set().activeCount, 1u);
    for (uint light = 0; light < 6; ++light)
        EXPECT_EQ(table.AliasAt(light).probability, light == 5 ? 1.0f : 0.0f);
    EXPECT_EQ(table.Set().nodeCount, 1u);
}

TEST(LightTable, MirroringATriangleKeepsItsFront) {
    testLights = {};
    testLights.AddTriangle(vec3(0.0f), vec3(1, 0, 0), vec3(0, 1, 0), vec3(1.0f));  // front: +z
    testLights.scene.instances[0].objectToWorld =
        glm::mat4x3(vec3(-2, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0.0f));
    testLights.Build();
    const LightRecord light = LightAt(0u);
    EXPECT_TRUE(EmitsTowards(light, cross(light.e1, light.e2).z));
    EXPECT_FALSE(EmitsTowards(light, -cross(light.e1, light.e2).z));
    EXPECT_NEAR(testLights.table.NodeAt(0).axis.z, 1.0f, 1e-6f);
    EXPECT_NEAR(testLights.table.NodeAt(0).power, 3.14159265f, 1e-5f) << "pi times area 1";
}

TEST(LightTable, PowersAreThoseOfRadiometry) {
    testLights = {};
    testLights.scene.radius = 3.0f;
    testLights.AddPunctual(scene::LightType::Point, vec3(0.0f), vec3(0, 0, 1), vec3(1.0f));
    testLights.AddPunctual(scene::LightType::Spot, vec3(0.0f), vec3(0, 0, 1), vec3(1.0f), 0.3f, 0.9f);
    testLights.AddPunctual(scene::LightType::Directional, vec3(0.0f), vec3(0, 0, 1), vec3(1.0f));
    testLights.environmentTint = vec3(1.0f);
    testLights.Build();
    double spot = 0.0;  // by quadrature over the sphere
    for (int i = 0; i < 100'000; ++i) {
        const double c = (i + 0.5) / 100'000;
        const double falloff = std::clamp((c - std::cos(0.9)) / (std::cos(0.3) - std::cos(0.9)), 0.0, 1.0);
        spot += 2.0 * M_PI * falloff * falloff / 100'000;
    }
    const double powers[] = {4.0 * M_PI, spot, M_PI * 9.0, 4.0 * M_PI * M_PI * 9.0};
    const double sum = powers[0] + powers[1] + powers[2] + powers[3];
    for (size_t i = 0; i < 4; ++i)
        EXPECT_NEAR(double(testLights.table.AliasAt(i).probability), powers[i] / sum, 2e-6) << i;
    EXPECT_NEAR(double(testLights.table.Set().unboundedProbability), 1.0 - kMinLightShare, 1e-6);
}

TEST(LightTable, ScalesAndPlacesBeyondReasonGiveNoNumbersThatAreNot) {
    testLights = {};
    for (const float far : {0.0f, 1.0f, 1e19f, 3e38f, -3e38f}) {
        testLights.AddPunctual(scene::LightType::Spot, vec3(far), vec3(0.0f), vec3(1.0f));
        testLights.AddPunctual(scene::LightType::Directional, vec3(far), vec3(0.0f), vec3(1.0f));
        testLights.AddTriangle(vec3(far), vec3(far, 1, 0), vec3(0, far, 1), vec3(1.0f));
        testLights.AddTriangle(vec3(far), vec3(far), vec3(far), vec3(1e38f));
    }
    testLights.scene.instances[0].objectToWorld = glm::mat4x3(1e3f);
    testLights.Build();
    for (uint i = 0; i < LightSet().lightCount; ++i) {
        const LightRecord light = LightAt(i);
        if (light.kind != kLightTriangle) {
            EXPECT_NEAR(length(light.e1), 1.0f, 1e-6f);
        }
    }
    for (int i = 0; i < 10'000; ++i) {
        const vec3 u(float(i % 100) * 0.01f, float(i / 100) * 0.01f, float(i * 37 % 100) * 0.01f);
        const LightSample s = SampleLight({vec3(0.0f), vec3(0, 1, 0)}, u.x, vec2(u.y, u.z));
        ASSERT_FALSE(std::isnan(s.pdf) || std::isnan(s.radiance.x) || std::isnan(s.wi.x)) << s.light;
    }
}

TEST(LightTable, ManyEmittersTakeNoMoreThanSortingDoes) {
    testLights = {};
    std::mt19937 random(5);
    const auto coordinate = [&] { return float(random() % 100'000) * 0.01f; };
    testLights.AddTriangle(vec3(0.0f), vec3(1, 0, 0), vec3(0, 1, 0), vec3(1.0f));
    testLights.AddTriangle(vec3(0.0f), vec3(0, 1, 0), vec3(0, 0, 1), vec3(1.0f));
    testLights.scene.placements.clear();
    testLights.scene.instances.clear();
    for (uint32_t i = 0; i < 65'536; ++i) {
        testLights.scene.placements.push_back({.record = i, .instance = i});
        testLights.scene.instances.push_back(
            {.objectToWorld = glm::mat4x3(vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1),
                                          vec3(coordinate(), coordinate(), coordinate()))});
    }
    const auto start = std::chrono::steady_clock::now();
    testLights.Build();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    EXPECT_EQ(CheckTree(), 131'072u);
    RecordProperty("seconds", std::to_string(seconds.count()));
    EXPECT_LT(seconds.count(), 20.0) << "a square of the count would take minutes";
}

// 500 triangles about the origin, each an instance; `places` are theirs.
void PlaceTriangles(const std::vector<vec3>& places) {
    testLights = {};
    testLights.AddTriangle(vec3(0.0f), vec3(1, 0, 0), vec3(0, 1, 0), vec3(1.0f));
    testLights.scene.placements.clear();
    testLights.scene.instances.clear();
    for (uint32_t i = 0; i < places.size(); ++i) {
        testLights.scene.placements.push_back({.record = i, .instance = i});
        testLights.scene.instances.push_back({.objectToWorld = glm::mat4x3(1.0f)});
        testLights.scene.instances.back().objectToWorld[3] = places[i];
    }
    testLights.Build();
}

std::vector<vec3> RandomPlaces(uint32_t count) {
    std::mt19937 random(6);
    std::vector<vec3> places;
    for (uint32_t i = 0; i < count; ++i)
        places.emplace_back(float(random() % 1000) * 0.1f, float(random() % 1000) * 0.1f,
                            float(random() % 1000) * 0.1f);
    return places;
}

LightTableChanges MoveTo(const std::vector<vec3>& places, std::vector<uint32_t> which, bool mayRefit = true) {
    for (const uint32_t i : which) testLights.scene.instances[i].objectToWorld[3] = places[i];
    return testLights.table.Update(testLights.scene, {.isAll = false, .placements = std::move(which)},
                                   mayRefit);
}

TEST(LightTable, MovedLightUpdatesItsRecordItsLeafAndTheNodesAbove) {
    const std::vector<vec3> places = RandomPlaces(500);
    PlaceTriangles(places);
    std::vector<vec3> moved = places;
    moved[77] = vec3(150.0f, -20.0f, 3.0f);
    const LightTableChanges changes = MoveTo(moved, {77});
    EXPECT_FALSE(changes.isAll || changes.isRebuilt || changes.isAlias || changes.allRecordsChanged);
    EXPECT_EQ(changes.lights, std::vector<uint32_t>{77});
    EXPECT_LE(changes.nodes.size(), 33u);
    EXPECT_EQ(CheckTree(), 500u);
    EXPECT_EQ(LightNodeAt(0u).boundsMax.x, 151.0f);
    EXPECT_EQ(LightNodeAt(0u).boundsMin.y, -20.0f);
    // Back again: nothing is left of where it was
    MoveTo(places, {77});
    const LightTable built = BuildLightTable(testLights.scene);
    for (uint i = 0; i < LightSet().nodeCount; ++i) {
        ASSERT_EQ(LightNodeAt(i).boundsMin, built.NodeAt(i).boundsMin);
        ASSERT_EQ(LightNodeAt(i).boundsMax, built.NodeAt(i).boundsMax);
    }
    EXPECT_TRUE(MoveTo(places, {77}).IsEmpty()) << "it is there";
    EXPECT_TRUE(MoveTo(moved, {77}, false).isRebuilt) << "by request";
}

TEST(LightTable, HiddenLightLeavesTheTreeAndOneThatWasDarkHasItRebuilt) {
    PlaceTriangles(RandomPlaces(500));
    LightScene& scene = testLights.scene;
    scene.instances[3].isVisible = false;
    LightTableChanges changes = testLights.table.Update(scene, {.isAll = false, .placements = {3}}, true);
    EXPECT_TRUE(changes.isAlias && !changes.isRebuilt);
    EXPECT_EQ(LightAliasAt(3u).probability, 0.0f);
    EXPECT_EQ(LightSet().activeCount, 499u);
    EXPECT_NEAR(LightNodeAt(0u).power, 499.0f * kPi / 2.0f, 0.01f);
    scene.instances[3].isVisible = true;
    EXPECT_FALSE(testLights.table.Update(scene, {.isAll = false, .placements = {3}}, true).isRebuilt);
    EXPECT_EQ(LightSet().activeCount, 500u);

    scene.instances[3].isVisible = false;
    testLights.Build();
    scene.instances[3].isVisible = true;
    EXPECT_TRUE(testLights.table.Update(scene, {.isAll = false, .placements = {3}}, true).isRebuilt);
    EXPECT_EQ(CheckTree(), 500u);
    std::vector<uint32_t> all;
    for (uint32_t i = 0; i < 500; ++i) {
        all.push_back(i);
        scene.instances[i].isVisible = false;
    }
    testLights.table.Update(scene, {.isAll = false, .placements = all}, true);
    EXPECT_EQ(LightSet().nodeCount, 0u) << "nothing to choose from";
}

TEST(LightTable, TreeDecaysWhenLightsPartFromTheirNeighbors) {
    const std::vector<vec3> places = RandomPlaces(500);
    PlaceTriangles(places);
    std::vector<uint32_t> all;
    for (uint32_t i = 0; i < places.size(); ++i) all.push_back(i);
    std::vector<vec3> moved = places;
    for (vec3& place : moved) place += vec3(3.0f, 400.0f, 0.0f);
    MoveTo(moved, all);
    EXPECT_FALSE(testLights.table.UpdateDecay()) << "all together";
    moved[9] += vec3(1e6f, 0.0f, 0.0f);
    MoveTo(moved, {9});
    EXPECT_FALSE(testLights.table.UpdateDecay()) << "one alone";
    for (uint32_t i = 0; i < places.size(); ++i) moved[i] = places[i * 37 % places.size()];
    MoveTo(moved, all);
    EXPECT_TRUE(testLights.table.UpdateDecay()) << "each to the place of another";
    EXPECT_EQ(CheckTree(), 500u);
    LightTableChanges changes;
    testLights.table.BuildTree(testLights.scene, changes);
    EXPECT_TRUE(changes.isRebuilt);
    EXPECT_FALSE(testLights.table.UpdateDecay());
    EXPECT_EQ(CheckTree(), 500u);
}

}  // namespace
}  // namespace raygraph::shading::light_tables_test

// Tests which triangles of a mesh may emit, and the effect of their texture.
namespace raygraph::emitters_test {
namespace {

// Two triangles, the halves of a square whose texture coordinates run over (low..high)^2.
scene::Primitive Square(float low, float high, uint32_t material = 0) {
    scene::Primitive square;
    square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.uv0 = {{low, low}, {high, low}, {high, high}, {low, high}};
    square.indices = {0, 1, 2, 0, 2, 3};
    square.material = material;
    return square;
}

class Emitters : public ::testing::Test {
  protected:
    void SetUp() override {
        scene.materials.resize(1);
        scene.materials[0].emissiveFactor = glm::vec3(1.0f);
    }

    // The texel at (x, y) is white where lit(x, y), else black.
    template <typename Lit>
    void SetTexture(uint32_t size, Lit&& lit, scene::WrapMode wrap = scene::WrapMode::Repeat) {
        scene::ImageData image{.name = {}, .width = size, .height = size, .rgba = {}};
        for (uint32_t y = 0; y < size; ++y)
            for (uint32_t x = 0; x < size; ++x)
                image.rgba.insert(image.rgba.end(), 4, lit(x, y) ? uint8_t{255} : uint8_t{0});
        scene.images = {image};
        scene.textures = {{.name = {}, .image = 0, .sampler = {.wrapU = wrap, .wrapV = wrap}}};
        scene.textures[0].colorSpace = scene::ColorSpace::Srgb;
        scene.materials[0].emissiveTexture.texture = 0;
    }

    std::vector<Emitter> Find(std::vector<scene::Primitive> primitives) {
        std::vector<scene::Primitive*> pointers;
        GroupTriangles triangles;
        for (uint32_t i = 0; i < primitives.size(); ++i) {
            const scene::Primitive& primitive = primitives[i];
            const auto first = static_cast<uint32_t>(triangles.positions.size());
            triangles.firstVertices.push_back(first);
            triangles.positions.insert(triangles.positions.end(), primitive.positions.begin(),
                                       primitive.positions.end());
            for (const uint32_t index : primitive.indices) triangles.indices.push_back(first + index);
            triangles.geometries.insert(triangles.geometries.end(), primitive.TriangleCount(), i);
            pointers.push_back(&primitives[i]);
        }
        return EmitterFinder(scene).Find(triangles, pointers, true).emitters;
    }

    scene::SceneData scene;
};

TEST_F(Emitters, AreTheTrianglesOfMaterialsThatEmit) {
    scene.materials.resize(3);
    scene.materials[2].emissiveFactor = glm::vec3(0.0f, 2.0f, 0.0f);
    const std::vector<Emitter> emitters = Find({Square(0, 1, 1), Square(0, 1, 2), Square(0, 1, 1)});
    ASSERT_EQ(emitters.size(), 2u);
    EXPECT_EQ(emitters[0].primitive, 2u);
    EXPECT_EQ(emitters[1].primitive, 3u);
    EXPECT_EQ(emitters[1].material, 2u);
    EXPECT_EQ(emitters[1].p2, glm::vec3(0, 1, 0));
    EXPECT_TRUE(emitters[1].isDoubleSided);
    EXPECT_EQ(TriangleLights(emitters, 6),
              (std::vector<uint32_t>{gpu::kNoLight, gpu::kNoLight, 0, 1, gpu::kNoLight, gpu::kNoLight}));
    EXPECT_TRUE(Find({Square(0, 1, 1)}).empty());
    EXPECT_TRUE(TriangleLights({}, 6).empty());
}

TEST_F(Emitters, TextureIsReadWhereItsTransformSays) {
    // The left half is lit
    SetTexture(64, [](uint32_t x, uint32_t) { return x < 32; });
    scene::TextureTransform& transform = scene.materials[0].emissiveTexture.transform;
    transform.scale = glm::vec2(0.25f);
    EXPECT_EQ(Find({Square(0, 1)}).size(), 2u);
    transform.offset = {0.625f, 0.0f};
    EXPECT_TRUE(Find({Square(0, 1)}).empty());
    transform.offset = {0.125f, 0.625f};
    EXPECT_EQ(Find({Square(0, 1)}).size(), 2u);
    // A quarter turn: u of the image is v of the square, and v goes against its u
    transform.rotation = 1.5707963f;
    EXPECT_EQ(Find({Square(0, 1)}).size(), 2u);
    transform.offset = {0.625f, 0.625f};
    EXPECT_TRUE(Find({Square(0, 1)}).empty());
}

TEST_F(Emitters, TextureCountsByItsMeanOverTheTriangle) {
    // White above the diagonal from (0, 0) to (1, 1), which is the edge between the two triangles
    SetTexture(64, [](uint32_t x, uint32_t y) { return x > y; });
    const std::vector<Emitter> emitters = Find({Square(0, 1)});
    ASSERT_EQ(emitters.size(), 2u);
    EXPECT_NEAR(emitters[0].meanTexture.x, 1.0f, 0.05f) << "below in v, right in u: white";
    EXPECT_NEAR(emitters[1].meanTexture.x, 0.0f, 0.05f);
}

TEST_F(Emitters, TrianglesOfABlackPartOfTheTextureAreLeftOut) {
    SetTexture(64, [](uint32_t x, uint32_t y) { return x == 40 && y == 40; });
    EXPECT_TRUE(Find({Square(0.0f, 0.5f)}).empty());
    EXPECT_TRUE(Find({Square(3.0f, 3.5f)}).empty()) << "repeated";
    EXPECT_EQ(Find({Square(0.6f, 0.65f)}).size(), 2u) << "one texel is enough";
    EXPECT_EQ(Find({Square(0.0f, 0.63f)}).size(), 2u) << "and so is its share in the one beside it";
    for (const Emitter& emitter : Find({Square(0.0f, 1.0f)})) EXPECT_GT(emitter.meanTexture.x, 0.0f);
}

TEST_F(Emitters, TextureCoordinatesBeyondTheEdgeFollowTheSampler) {
    const auto leftEdge = [](uint32_t x, uint32_t) { return x < 16; };
    SetTexture(64, leftEdge, scene::WrapMode::ClampToEdge);
    EXPECT_NEAR(Find({Square(-3.0f, -2.0f)}).at(0).meanTexture.x, 1.0f, 1e-6f);
    EXPECT_TRUE(Find({Square(2.0f, 3.0f)}).empty());
    SetTexture(64, leftEdge, scene::WrapMode::Repeat);
    EXPECT_NEAR(Find({Square(2.01f, 2.2f)}).at(0).meanTexture.x, 1.0f, 1e-6f);
    EXPECT_TRUE(Find({Square(-0.5f, -0.1f)}).empty());
    SetTexture(64, leftEdge, scene::WrapMode::MirroredRepeat);
    EXPECT_NEAR(Find({Square(1.8f, 1.99f)}).at(0).meanTexture.x, 1.0f, 1e-6f);
    EXPECT_NEAR(Find({Square(-0.2f, -0.01f)}).at(0).meanTexture.x, 1.0f, 1e-6f);
}

TEST_F(Emitters, ColorsAreDecodedFromSrgb) {
    SetTexture(2, [](uint32_t, uint32_t) { return true; });
    for (uint8_t& value : scene.images[0].rgba) value = 188;
    EXPECT_NEAR(Find({Square(0, 1)}).at(0).meanTexture.y, 0.5029f, 1e-3f);
    scene.textures[0].colorSpace = scene::ColorSpace::Linear;
    EXPECT_NEAR(Find({Square(0, 1)}).at(0).meanTexture.y, 188.0f / 255.0f, 1e-5f);
}

TEST_F(Emitters, AbsurdTextureCoordinatesDoNoHarm) {
    SetTexture(4, [](uint32_t x, uint32_t) { return x > 0; });
    for (const float value : {1e30f, -1e30f, 3e9f, 1e-40f})
        EXPECT_NO_THROW(Find({Square(-value, value), Square(value, value)}));
}

}  // namespace
}  // namespace raygraph::emitters_test

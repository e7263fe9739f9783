// Emitting meshes that are placed often: the size of their tables, what a change uploads, and their light.
#include <chrono>
#include <cmath>
#include <numbers>

#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::mesh_lights_test {

using passes::TraceSettings;

namespace {

constexpr float kWhite = 0.8f, kRadiance = 3.0f, kHeight = 2.0f, kHalfSize = 0.3f;
constexpr uint32_t kCuts = 15;  // 450 triangles

// A panel of 450 triangles in the xy plane that emits from both sides.
scene::Mesh Panel() {
    scene::Mesh panel = QuadMesh(kHalfSize, 1);
    scene::Primitive& primitive = panel.primitives[0];
    primitive.positions.clear();
    primitive.normals.clear();
    primitive.indices.clear();
    for (uint32_t row = 0; row <= kCuts; ++row)
        for (uint32_t column = 0; column <= kCuts; ++column) {
            primitive.positions.push_back(kHalfSize * glm::vec3(2.0f * float(column) / kCuts - 1.0f,
                                                                2.0f * float(row) / kCuts - 1.0f, 0.0f));
            primitive.normals.emplace_back(0.0f, 0.0f, 1.0f);
        }
    for (uint32_t row = 0; row < kCuts; ++row)
        for (uint32_t column = 0; column < kCuts; ++column) {
            const uint32_t a = row * (kCuts + 1) + column, b = a + 1, c = a + kCuts + 1, d = c + 1;
            for (const uint32_t index : {a, b, d, a, d, c}) primitive.indices.push_back(index);
        }
    return panel;
}

// Some turned, some stretched, some mirrored; all parallel to the floor.
glm::mat4x3 PanelAt(uint32_t index, float x, float y) {
    const float stretch = index % 3 == 0 ? 1.4f : 1.0f, side = index % 4 == 0 ? -1.0f : 1.0f;
    const float angle = 0.1f * float(index % 7);
    const glm::vec3 u(std::cos(angle), std::sin(angle), 0.0f), v(-u.y, u.x, 0.0f);
    return {side * stretch * u, v, {0, 0, 1}, {x, y, kHeight}};
}

// Lambert's formula, for a receiver at the origin that faces +z.
double IrradianceOf(const glm::mat4x3& placed) {
    double sum = 0.0;
    glm::dvec3 corners[4];
    for (int i = 0; i < 4; ++i) {
        const double x = i == 0 || i == 3 ? -1.0 : 1.0, y = i < 2 ? -1.0 : 1.0;
        corners[i] =
            glm::normalize(glm::dmat4x3(placed) * glm::dvec4(x * kHalfSize, y * kHalfSize, 0.0, 1.0));
    }
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 across = glm::cross(corners[i], corners[(i + 1) % 4]);
        const double sine = glm::length(across);
        sum += std::atan2(sine, glm::dot(corners[i], corners[(i + 1) % 4])) * across.z / sine;
    }
    return 0.5 * kRadiance * std::abs(sum);
}

// Instance 0 is a wall at the origin, so small that all of it is lit as its middle is; the others are panels.
scene::SceneData Panels(uint32_t count) {
    scene::SceneData scene = SceneOf({QuadMesh(0.001f, 0), Panel()},
                                     {Lambert(glm::vec3(kWhite)), Lambert({}, glm::vec3(kRadiance))});
    scene.instances.resize(1);
    const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(double(count))));
    for (uint32_t i = 0; i < count; ++i)
        scene.instances.push_back({.mesh = 1,
                                   .objectToWorld = PanelAt(i, float(i % side) - 0.5f * float(side - 1),
                                                            float(i / side) - 0.5f * float(side - 1))});
    return scene;
}

double IrradianceOf(const std::vector<scene::Instance>& instances) {
    double sum = 0.0;
    for (size_t i = 1; i < instances.size(); ++i) sum += IrradianceOf(instances[i].objectToWorld);
    return sum;
}

class MeshLights : public VulkanTest {
  protected:
    static TraceSettings Settings() {
        TraceSettings settings = LookAt({0.5f, 0.0f, 0.5f}, {0, 0, 0}, 0.0005f, 32);
        settings.biases.maxDepth = 1;
        return settings;
    }
    void ExpectIrradiance(double expected, const TraceSettings& settings = Settings()) {
        const RenderedImage image = render.Render(settings, 64);
        const double radiance = expected * kWhite / std::numbers::pi;
        EXPECT_NEAR(image.mean.Mean().y, radiance, 0.005 * radiance + 3.0 * image.StandardErrorOfMean().y);
        EXPECT_LT(image.StandardErrorOfMean().y, 0.01 * radiance) << "too noisy to prove anything";
    }
    const GpuSceneStatistics& Statistics() const { return render.scene.Statistics(); }

    SceneRender render{Device()};
};

double Milliseconds(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

TEST_F(MeshLights, TablesOfAHundredThousandLampsAreSmallAndMovingOneUploadsItsPath) {
    constexpr uint32_t kCount = 100'000;
    scene::SceneData data = Panels(kCount);
    const std::vector<scene::Instance> instances = data.instances;
    const double expected = IrradianceOf(instances);
    const double set = Milliseconds([&] { render.scene.SetScene(std::move(data)); });
    const auto declare = [&] {
        render.renderer.BeginFrame();
        const double took = Milliseconds([&] { render.scene.Declare(render.renderer); });
        render.renderer.DropFrame();
        return took;
    };
    const double first = declare();
    EXPECT_LT(set + first, 20'000.0);
    EXPECT_EQ(Statistics().emissiveTriangleCount, uint64_t{kCount} * 2 * kCuts * kCuts);
    EXPECT_EQ(Statistics().lightCount, kCount);
    EXPECT_LT(Statistics().lightTableBytes, 25'000'000u) << "expanded they would be 9 GB";
    ExpectIrradiance(expected);

    // From above the wall to where no other is
    const uint32_t side = 317, instance = 1 + (side / 2) * side + side / 2;
    const glm::mat4x3 old = instances[instance].objectToWorld;
    glm::mat4x3 moved = old;
    moved[3] = glm::vec3(200.0f, 0.0f, kHeight);
    ASSERT_GT(IrradianceOf(old), 0.05 * expected);
    const GpuSceneStatistics before = Statistics();
    render.scene.SetTransform(instance, moved);
    const double move = declare();
    render.Render(Settings(), 1);
    EXPECT_EQ(Statistics().lightRebuilds, before.lightRebuilds);
    EXPECT_GT(Statistics().lightUpdates, before.lightUpdates);
    // Its leaf and the nodes above. The record is as it was
    const uint64_t uploaded = Statistics().lightBytesUploaded - before.lightBytesUploaded;
    EXPECT_LE(uploaded, 33 * sizeof(gpu::LightNode));
    EXPECT_GE(uploaded, 3 * sizeof(gpu::LightNode));
    ExpectIrradiance(expected - IrradianceOf(old) + IrradianceOf(moved));
    RecordProperty("setMilliseconds", std::to_string(set));
    RecordProperty("firstDeclareMilliseconds", std::to_string(first));
    RecordProperty("moveMilliseconds", std::to_string(move));
    RecordProperty("moveBytes", std::to_string(uploaded));
    RecordProperty("tableBytes", std::to_string(Statistics().lightTableBytes));
}

// Twelve lamps are few, but too many triangles to be lights of their own.
TEST_F(MeshLights, EverySamplerAndStrategyFindsTheirLight) {
    scene::SceneData data = Panels(12);
    const double expected = IrradianceOf(data.instances);
    render.scene.SetScene(std::move(data));
    TraceSettings settings = Settings();
    for (const LightSampler sampler : {LightSampler::Uniform, LightSampler::Power, LightSampler::Bvh}) {
        settings.lights.sampler = sampler;
        ExpectIrradiance(expected, settings);
    }
    settings.lights.mis = MisHeuristic::Off;
    ExpectIrradiance(expected, settings);
    EXPECT_EQ(Statistics().lightCount, 12u);
    EXPECT_EQ(Statistics().emissiveTriangleCount, 12u * 450u);
    // What is hidden does not shine, alone or with the whole mesh's material
    render.scene.SetVisible(5, false);
    EXPECT_EQ((render.Render(Settings(), 1), Statistics().lightCount), 11u);
    EXPECT_EQ(Statistics().emissiveTriangleCount, 11u * 450u);
    render.scene.SetVisible(5, true);
    render.scene.SetMaterial(1, Lambert({}, glm::vec3(2.0f * kRadiance)));
    ExpectIrradiance(2.0 * expected);
    render.scene.SetMaterial(1, Lambert({}));
    EXPECT_EQ(render.Render(Settings(), 1).mean.Mean().y, 0.0);
}

// Trees of this many lights are updated where they can be; smaller ones are always rebuilt.
constexpr uint32_t kMany = 1100;

// What moves, goes and comes: a render does not depend on it, a view may.
TEST_F(MeshLights, PicturesOfTheRuleAlwaysDoNotDependOnWhatWasShownBefore) {
    const auto picture = [&](LightRule rule, bool isEdited) {
        SceneRender other(Device(), {.lightRule = rule});
        scene::SceneData data = Panels(kMany);
        const glm::mat4x3 last = data.instances[3].objectToWorld;
        other.scene.SetScene(std::move(data));
        if (isEdited) other.scene.SetTransform(3, PanelAt(5, -3.0f, 0.5f));
        other.Render(Settings(), 1);
        if (isEdited) {
            other.scene.SetVisible(7, false);
            other.Render(Settings(), 1);
            other.scene.SetVisible(7, true);
            other.scene.SetTransform(3, PanelAt(5, 2.0f, 0.5f));
            other.Render(Settings(), 1);
            other.scene.SetTransform(3, last);
        }
        const RenderedImage image = other.Render(Settings(), 16);
        const uint64_t rebuilds = other.scene.Statistics().lightRebuilds;
        EXPECT_EQ(rebuilds, !isEdited || rule == LightRule::Decay ? 1u : 4u);
        return image.mean;
    };
    const FloatImage set = picture(LightRule::Always, false);
    EXPECT_EQ(picture(LightRule::Always, true).values, set.values);
    const double viewed = picture(LightRule::Decay, true).Mean().y;
    EXPECT_NEAR(viewed, set.Mean().y, 0.02 * viewed);
}

// Nothing of it is updated that does not change, and what decays is built again.
TEST_F(MeshLights, TreeIsRebuiltWhenUpdatesHaveDecayedIt) {
    render.scene.SetScene(Panels(kMany));
    render.Render(Settings(), 1);
    const uint64_t rebuilds = Statistics().lightRebuilds;
    // Each by little, and then to the place of one that is far in the tree
    for (uint32_t i = 1; i <= kMany; ++i)
        render.scene.SetTransform(i,
                                  PanelAt(i - 1, float((i - 1) % 34) - 16.45f, float((i - 1) / 34) - 16.55f));
    render.Render(Settings(), 1);
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds);
    for (uint32_t i = 1; i <= kMany; ++i) {
        const uint32_t place = i * 37 % (kMany + 1);
        render.scene.SetTransform(i, PanelAt(i - 1, float(place % 34) - 16.5f, float(place / 34) - 16.5f));
    }
    render.Render(Settings(), 1);
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds + 1);
}

// One that goes leaves the others as they are, and one that comes takes its place.
TEST_F(MeshLights, LampsComeAndGoInPlace) {
    scene::SceneData data = Panels(kMany);
    const std::vector<scene::Instance> all = data.instances;
    constexpr uint32_t kGone = 1 + 16 * 34 + 17;
    const double whole = IrradianceOf(all), own = IrradianceOf(all[kGone].objectToWorld);
    ASSERT_GT(own, 0.05 * whole);
    render.scene.SetScene(std::move(data));
    render.Render(Settings(), 1);
    const uint64_t rebuilds = Statistics().lightRebuilds;
    render.scene.RemoveInstance(kGone);
    ExpectIrradiance(whole - own);
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds);
    EXPECT_EQ(Statistics().lightCount, kMany - 1);
    EXPECT_EQ(render.scene.AddInstance(1, scene::PlacedTransform{all[kGone].objectToWorld}), kGone);
    ExpectIrradiance(whole);
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds);
    // One more has no number yet
    (void)render.scene.AddInstance(1, scene::PlacedTransform{PanelAt(1, 0.0f, 20.0f)});
    ExpectIrradiance(whole + IrradianceOf(PanelAt(1, 0.0f, 20.0f)));
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds + 1);
    EXPECT_EQ(Statistics().lightCount, kMany + 1);
}

}  // namespace raygraph::testing::mesh_lights_test

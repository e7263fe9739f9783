// The radiance of each group of lights, as Trace separates it.
#include <cstring>

#include "base/error.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_groups_test {

namespace {

constexpr uint32_t kRest = gpu::kLightGroupRest, kFirst = gpu::kLightGroupNamed;

class TraceGroups : public VulkanTest {
  protected:
    // One picture for each group, and last the radiance.
    std::vector<FloatImage> Trace(const passes::TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds scene = render.scene.Declare(render.renderer);
        const passes::TraceIds traced =
            passes::Trace(render.renderer, scene, settings, {.lightGroups = true});
        const Readback radiance = render.renderer.ReadBack(traced.radiance);
        const Readback tiles = render.renderer.ReadBack(traced.lightGroups);
        render.renderer.Execute();
        const FloatImage all = ToFloatImage(tiles);
        const Extent2D across = passes::LightGroupTiles(scene.lightGroupCount), size = settings.extent;
        std::vector<FloatImage> pictures;
        for (uint32_t group = 0; group < scene.lightGroupCount; ++group) {
            FloatImage& picture = pictures.emplace_back(FloatImage{size, {}});
            for (uint32_t y = 0; y < size.height; ++y)
                for (uint32_t x = 0; x < size.width; ++x)
                    picture.values.push_back(all.At(group % across.width * size.width + x,
                                                    group / across.width * size.height + y));
        }
        pictures.push_back(ToFloatImage(radiance));
        return pictures;
    }
    // A floor, two lamps of different instances and materials over it, and a point light.
    passes::TraceSettings SetScene() {
        const glm::mat4x3 flat({1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0});
        scene::SceneData data =
            SceneOf({QuadMesh(3.0f, 0), QuadMesh(0.3f, 1), QuadMesh(0.3f, 2)},
                    {Lambert(glm::vec3(0.6f)), Lambert({}, {4, 0, 0}), Lambert({}, {0, 4, 0})},
                    {flat, Translation({-1, 1, 0}), Translation({1, 1, 0})});
        data.lights = {{.color = {0, 0, 1}, .intensity = 2.0f, .lightToWorld = Translation({0, 2, 0})}};
        render.scene.SetScene(std::move(data));
        return LookAt({0, 1.2f, 4}, {0, 0.5f, 0}, 0.9f, 48);
    }
    SceneRender render{Device()};
};

}  // namespace

// Each triangle of a mesh that is one light is in a group of its own material's or its instance's.
TEST_F(TraceGroups, Trace_TrianglesOfAMeshThatIsPlacedOftenAreInTheirGroups) {
    scene::Mesh lamp = SphereMesh(0.2f, 16, 1);
    scene::Primitive green = lamp.primitives[0];
    scene::Primitive& red = lamp.primitives[0];
    const size_t half = red.indices.size() / 6 * 3;
    green.indices.erase(green.indices.begin(), green.indices.begin() + static_cast<std::ptrdiff_t>(half));
    green.material = 2;
    red.indices.resize(half);
    lamp.primitives.push_back(std::move(green));
    const glm::mat4x3 flat({1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0});
    scene::SceneData data =
        SceneOf({QuadMesh(3.0f, 0), std::move(lamp)},
                {Lambert(glm::vec3(0.6f)), Lambert({}, {4, 0, 0}), Lambert({}, {0, 4, 0})},
                {flat, Translation({0, 1, 0})});
    for (int i = 1; i < 8; ++i)
        data.instances.push_back({.mesh = 1, .objectToWorld = Translation({0.5f * float(i - 4), 1, -1})});
    render.scene.SetScene(std::move(data));
    std::vector<uint32_t> ofInstances(9, kRest);
    ofInstances[1] = kFirst + 1;
    render.scene.SetLightGroups(
        {.namedCount = 3, .instances = ofInstances, .materials = {kRest, kFirst, kFirst + 2}});
    for (const bool isSampled : {true, false}) {
        passes::TraceSettings settings = LookAt({0, 1.2f, 4}, {0, 0.5f, 0}, 0.9f, 48);
        settings.lights.isOn = isSampled;
        const std::vector<FloatImage> pictures = Trace(settings);
        ASSERT_EQ(render.scene.Statistics().lightCount, 8u) << "a mesh is a light";
        const glm::dvec3 reds = pictures[kFirst].Mean(), lone = pictures[kFirst + 1].Mean(),
                         greens = pictures[kFirst + 2].Mean();
        EXPECT_TRUE(reds.x > 0.0 && reds.y == 0.0);
        EXPECT_TRUE(lone.x == 0.0 && lone.y > 0.0);
        EXPECT_TRUE(greens.x == 0.0 && greens.y > lone.y);
        EXPECT_EQ(pictures[kRest].Mean(), glm::dvec3(0.0));
    }
}

TEST_F(TraceGroups, Trace_EveryLightIsInItsGroupAloneAndTheyAreTheRadiance) {
    const passes::TraceSettings settings = SetScene();
    render.scene.SetEnvironment({.radiance = {0.1f, 0.1f, 0.1f}});
    render.scene.SetLightGroups({.namedCount = 3,
                                 .instances = {kRest, kFirst, kRest},
                                 .materials = {kRest, kFirst + 2, kFirst + 1},
                                 .lights = {kFirst + 2}});
    const std::vector<FloatImage> pictures = Trace(settings);
    ASSERT_EQ(pictures.size(), 6u);
    // Red: by its instance, which is in an earlier group than its material. Green: by its material
    const glm::dvec3 red = pictures[kFirst].Mean(), green = pictures[kFirst + 1].Mean(),
                     blue = pictures[kFirst + 2].Mean(), sky = pictures[gpu::kLightGroupEnvironment].Mean();
    EXPECT_TRUE(red.x > 0.0 && red.y == 0.0 && red.z == 0.0);
    EXPECT_TRUE(green.x == 0.0 && green.y > 0.0 && green.z == 0.0);
    EXPECT_TRUE(blue.x == 0.0 && blue.y == 0.0 && blue.z > 0.0);
    EXPECT_TRUE(sky.x > 0.0 && sky.x == sky.y && sky.y == sky.z);
    EXPECT_EQ(pictures[kRest].Mean(), glm::dvec3(0.0));
    for (size_t i = 0; i < pictures[0].values.size(); ++i) {
        glm::dvec4 sum(0.0);
        for (size_t group = 0; group < 5; ++group) sum += glm::dvec4(pictures[group].values[i]);
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(sum[c], pictures[5].values[i][c], 1e-5 * std::max(1e-3, sum[c])) << i;
    }
    const FloatImage alone = render.TraceOnce(settings);
    EXPECT_EQ(
        std::memcmp(alone.values.data(), pictures[5].values.data(), alone.values.size() * sizeof(glm::vec4)),
        0);
}

TEST_F(TraceGroups, Trace_WhatEmitsAndIsNoLightIsInRest) {
    const passes::TraceSettings settings = SetScene();
    render.scene.SetLightGroups({.namedCount = 1, .instances = {kFirst, kFirst, kFirst}, .lights = {kFirst}});
    render.scene.SetMaterial(0, Lambert(glm::vec3(0.6f), glm::vec3(1.0f)));  // dark when the scene was set
    const std::vector<FloatImage> pictures = Trace(settings);
    EXPECT_GT(pictures[kRest].Mean().x, 0.1);
    EXPECT_GT(pictures[kFirst].Mean().x, 0.0);
}

TEST_F(TraceGroups, SetLightGroups_RefusesWhatDoesNotFitTheScene) {
    SetScene();
    const auto refuses = [&](LightGroups groups) {
        EXPECT_THROW(render.scene.SetLightGroups(std::move(groups)), Error);
    };
    refuses({.namedCount = 9});
    refuses({.namedCount = 1, .instances = {kFirst}});
    refuses({.namedCount = 1, .materials = {kRest, kRest, kFirst + 1}});
    refuses({.namedCount = 1, .lights = {gpu::kLightGroupEnvironment}});
    render.scene.SetLightGroups({.namedCount = 1, .lights = {kFirst}});
    SetScene();
    render.renderer.BeginFrame();
    EXPECT_EQ(render.scene.Declare(render.renderer).lightGroupCount, kFirst);  // none is left
}

}  // namespace raygraph::testing::trace_groups_test

// Trace by the scene's own trees: sees what the driver sees, after every change of the scene.
#include <cmath>

#include "renderer/bvh/wide_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/scene_render.h"
#include "tests/support/two_levels.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::own_traversal_test {

using passes::TraceSettings;

namespace {

scene::Material SingleSided(const glm::vec3& albedo) {
    scene::Material material = Lambert(albedo, 0.2f * albedo);
    material.isDoubleSided = false;
    return material;
}

scene::Material WithAlpha(scene::AlphaMode mode, float alpha) {
    scene::Material material = Lambert({0.2f, 0.9f, 0.4f});
    material.baseColorFactor.a = alpha;
    material.alphaMode = mode;
    return material;
}

scene::Material Pane(const glm::vec3& tint) {
    scene::Material material;
    material.baseColorFactor = glm::vec4(tint, 1.0f);
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.0f;
    material.transmissionFactor = 1.0f;
    return material;
}

glm::mat4x3 Placed(const glm::vec3& at, const glm::vec3& scale) {
    return {glm::vec3(scale.x, 0, 0), glm::vec3(0, scale.y, 0), glm::vec3(0, 0, scale.z), at};
}

// By trees of two levels and of one.
class OwnTraversal : public VulkanTest, public ::testing::WithParamInterface<uint32_t> {
  protected:
    // Above a floor: what is mirrored, stretched, culled and seen through in part.
    static scene::SceneData Things() {
        scene::SceneData data =
            SceneOf({QuadMesh(4.0f, 0), BoxMesh(0.3f, 1), SphereMesh(0.4f, 12, 2), QuadMesh(0.5f, 3),
                     QuadMesh(0.6f, 4), QuadMesh(0.4f, 5), BoxMesh(0.25f, 1)},
                    {Lambert(glm::vec3(0.6f)), SingleSided({0.8f, 0.3f, 0.2f}), Lambert({0.3f, 0.4f, 0.9f}),
                     WithAlpha(scene::AlphaMode::Blend, 0.4f), Pane({0.9f, 0.5f, 0.7f}),
                     WithAlpha(scene::AlphaMode::Mask, 0.3f)},
                    {glm::mat4x3(1.0f), Placed({-1, 0.5f, 0.4f}, {1, 1, -1}),
                     Placed({0.4f, 0.3f, 0.5f}, {1, 0.6f, 1.4f}), Placed({-0.3f, -0.8f, 1.0f}, {1, 1, 1}),
                     Placed({0.9f, -0.6f, 0.8f}, {-1, 1, 1}), Placed({0.2f, 1.1f, 0.7f}, {1, 1, 1}),
                     Placed({1.2f, 0.9f, 0.3f}, {-1, -1, -1})});
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 2.0f;
        data.lights = {sun};
        return data;
    }
    // What compiles sooner: no glass, no alpha.
    static scene::SceneData PlainThings() {
        return SceneOf({QuadMesh(4.0f, 0), SphereMesh(0.4f, 12, 1)},
                       {Lambert(glm::vec3(0.6f), glm::vec3(0.1f)), Lambert({0.3f, 0.4f, 0.9f})},
                       {glm::mat4x3(1.0f), Placed({0.4f, 0.3f, 0.5f}, {1, 0.6f, -1.4f})});
    }
    static TraceSettings View(Traversal traversal) {
        TraceSettings settings = LookAt({0.5f, -2.0f, 4.0f}, {0, 0, 0.3f}, 0.8f, 48);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = 6;
        settings.traversal = traversal;
        return settings;
    }
    FloatImage Traced(Traversal traversal, uint32_t sample = 0) {
        TraceSettings settings = View(traversal);
        settings.sampleIndex = sample;
        return render.TraceOnce(settings);
    }
    bool HasOneLevel() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        render.renderer.Execute();
        return ids.hasOneWideLevel;
    }
    // Hits differ in the last bits, so that here and there a path takes another turn.
    void ExpectAlike(const char* what, bool mayHaveOneLevel = true) {
        SCOPED_TRACE(what);
        EXPECT_EQ(HasOneLevel(), mayHaveOneLevel && GetParam() == 1);
        size_t unlike = 0;
        double sum = 0.0, sumOfOwn = 0.0;
        for (uint32_t sample = 0; sample < 4; ++sample) {
            const FloatImage own = Traced(Traversal::Own, sample), driver = Traced(Traversal::Driver, sample);
            ASSERT_EQ(own.values.size(), driver.values.size());
            for (size_t i = 0; i < own.values.size(); ++i) {
                const glm::vec4 difference = glm::abs(own.values[i] - driver.values[i]);
                unlike += std::max({difference.x, difference.y, difference.z}) > 1e-3f;
                sum += double{driver.values[i].y};
                sumOfOwn += double{own.values[i].y};
            }
        }
        EXPECT_LT(unlike, 4 * 48 * 48 / 1000) << "the smallest thing covers more";
        EXPECT_GT(sum, 0.0);
        EXPECT_NEAR(sumOfOwn, sum, 0.002 * sum);
        EXPECT_EQ(render.scene.Statistics().noWideBvhReason, "");
    }

    // Of an empty scene there is nothing of which to make two.
    void SetScene(scene::SceneData&& data) {
        render.scene.SetScene(std::move(data));
        if (GetParam() == 2) ForceTwoLevelTree(render);
    }

    SceneRender render{Device(), {.traversal = Traversal::Own}};
};
INSTANTIATE_TEST_SUITE_P(Levels, OwnTraversal, ::testing::Values(1u, 2u));

}  // namespace

TEST_P(OwnTraversal, SeesWhatTheDriverSees) {
    SetScene(Things());
    ExpectAlike("as it is set");
    // Of the whole program: that of the trees, not of the driver
    const glm::dvec3 mean = Traced(Traversal::Own).Mean();
    EXPECT_GT(mean.y, 0.05);
}

TEST_P(OwnTraversal, FollowsEveryChange) {
    SetScene(Things());
    ExpectAlike("as it is set");
    render.scene.SetTransform(2, Placed({-0.6f, 0.2f, 0.9f}, {0.5f, 1, 1}));
    ExpectAlike("moved");
    render.scene.SetVisible(1, false);
    ExpectAlike("hidden");
    render.scene.SetVisible(1, true);
    ExpectAlike("shown");
    // From culled to not, from opaque to alpha-tested and to a wall, and back
    for (const scene::Material& material :
         {Lambert(glm::vec3(0.7f)), WithAlpha(scene::AlphaMode::Blend, 0.5f), Pane(glm::vec3(0.8f)),
          SingleSided({0.8f, 0.3f, 0.2f})}) {
        render.scene.SetMaterial(1, material);
        ExpectAlike("another material");
    }
    const uint32_t mesh = render.scene.AddMesh(SphereMesh(0.35f, 10, 0));
    const uint32_t added = render.scene.AddInstance(mesh, {Placed({-1.4f, -0.6f, 0.6f}, {1, 1, 1})});
    ExpectAlike("with another mesh");
    render.scene.RemoveInstance(3);
    render.scene.RemoveInstance(added);
    render.scene.RemoveMesh(mesh);
    ExpectAlike("without some");
    render.scene.SetViewpoint({5000.0, 0.0, 0.0});
    ExpectAlike("from another origin");
    SetScene(Things());
    ExpectAlike("set again");
}

TEST_P(OwnTraversal, AnEmptySceneIsBlackAndRoundPrimitivesAreTheDrivers) {
    render.scene.SetScene({});
    EXPECT_EQ(Traced(Traversal::Own).Mean(), Traced(Traversal::Driver).Mean());
    scene::SceneData data = PlainThings();
    data.meshes.push_back(RoundSphere(0.3f, 1, {0, 0, 1}));
    data.instances.push_back(
        {.mesh = static_cast<uint32_t>(data.meshes.size() - 1), .objectToWorld = glm::mat4x3(1.0f)});
    const uint32_t round = static_cast<uint32_t>(data.instances.size() - 1);
    SetScene(std::move(data));
    EXPECT_NE(render.scene.Statistics().noWideBvhReason, "");
    EXPECT_EQ(Traced(Traversal::Own).values, Traced(Traversal::Driver).values) << "by the driver";
    render.scene.SetVisible(round, false);
    if (GetParam() == 2) ForceTwoLevelTree(render);
    ExpectAlike("without what is round");
}

TEST_P(OwnTraversal, TheWavefrontSeesWhatTheLoopSees) {
    SetScene(PlainThings());
    TraceSettings settings = View(Traversal::Own);
    settings.form = passes::IntegratorForm::Loop;
    const FloatImage loop = render.TraceOnce(settings);
    settings.form = passes::IntegratorForm::Wavefront;
    const FloatImage wavefront = render.TraceOnce(settings);
    size_t unlike = 0;
    for (size_t i = 0; i < loop.values.size(); ++i) unlike += loop.values[i] != wavefront.values[i];
    EXPECT_LT(unlike, Device().Info().type == rhi::DeviceType::Cpu ? 1u : loop.values.size() / 50);
}

// A ball that goes through a crowd, step by step: boxes follow, and the tree is built again when it has become
// bad, on another thread.
TEST_P(OwnTraversal, ATreeThatMotionHasMadeWorseIsBuiltAgain) {
    scene::SceneData data = PlainThings();
    data.meshes.push_back(BoxMesh(0.05f, 1));
    for (uint32_t i = 0; i < 60; ++i)
        data.instances.push_back(
            {.mesh = 2,
             .objectToWorld =
                 Placed({0.2f * float(i % 8) - 0.8f, 0.2f * float(i / 8) - 0.8f, 0.6f}, glm::vec3(1))});
    const auto count = static_cast<uint32_t>(data.instances.size());
    SetScene(std::move(data));
    ExpectAlike("as it is set");
    for (int step = 0; step < 12; ++step) {
        // All of them, each its own way
        for (uint32_t i = 1; i < count; ++i) {
            const float angle = 2.1f * float(i) + 0.7f * float(step);
            render.scene.SetTransform(
                i,
                Placed({1.2f * std::cos(angle), 1.2f * std::sin(angle), 0.1f * float(i % 9)}, glm::vec3(1)));
        }
        Traced(Traversal::Own);
    }
    ExpectAlike("moved");
    for (int frame = 0; frame < 50; ++frame) Traced(Traversal::Own);
    ExpectAlike("at rest");
}

// Rays in the space of the mesh would overflow. In the scene's space all is near.
TEST_P(OwnTraversal, AMeshThatReachesTooFarIsPlacedOrTheDrivers) {
    // A sky would light the far mesh, and show that float rounds the points where rays leave it to 1e6 m.
    render.scene.SetEnvironment({});
    scene::SceneData data = PlainThings();
    data.meshes.push_back(BoxMesh(2e18f, 1));
    data.instances.push_back({.mesh = 2, .objectToWorld = Placed({1e13f, 1e13f, 0.0f}, glm::vec3(1e-6f))});
    SetScene(std::move(data));
    if (GetParam() == 1) return ExpectAlike("in one level");
    EXPECT_EQ(Traced(Traversal::Own).values, Traced(Traversal::Driver).values);
    EXPECT_EQ(render.scene.Statistics().noWideBvhReason, "a mesh reaches too far for a tree");
}

// A tree over all of their triangles would take too long to build.
TEST_P(OwnTraversal, ManyTrianglesAreInTwoLevels) {
    scene::SceneData data = PlainThings();
    data.meshes.push_back(SphereMesh(0.1f, 64, 1));
    const uint64_t each = data.meshes.back().primitives[0].TriangleCount();
    for (uint64_t placed = 0; placed <= kMaxLevelTriangles; placed += each) {
        const float x = 4e-6f * static_cast<float>(placed) - 1.0f;
        data.instances.push_back({.mesh = 2, .objectToWorld = Placed({x, 0.6f, 0.4f}, {1, 1, 1})});
    }
    const auto count = static_cast<uint32_t>(data.instances.size());
    SetScene(std::move(data));
    ExpectAlike("too many", false);
    // They stay so: their tables are there
    for (uint32_t i = 8; i < count; ++i) render.scene.RemoveInstance(i);
    ExpectAlike("few", false);
}

// Nobody reads the driver's structures then, and none are built.
TEST_P(OwnTraversal, BuildsNothingForTheDriver) {
    SetScene(PlainThings());
    Traced(Traversal::Own);
    Traced(Traversal::Auto);
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 0u);
    EXPECT_EQ(render.scene.Statistics().tlasRebuilds, 0u);
    Traced(Traversal::Driver);
    EXPECT_GT(render.scene.Statistics().blasBuilds, 0u);
    EXPECT_GT(render.scene.Statistics().tlasRebuilds, 0u);
}

}  // namespace raygraph::testing::own_traversal_test

// Lamps that joints and morph targets flatten.
#include "renderer/scene/animation/deform.h"
#include "tests/passes/flat_nodes.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::flat_deform_test {

using glm::vec3;

namespace {

constexpr vec3 kColor{0.25f, 0.5f, 0.75f};

class FlatDeform : public VulkanTest {
  protected:
    // The radiance of a small wall in the plane z = 0, which is white.
    double LightOnWall(bool isSampled, uint32_t samples) {
        passes::TraceSettings settings = LookAt({0.5f, 0.0f, 0.5f}, {0, 0, 0}, 0.0005f, 64);
        settings.biases.maxDepth = 1;
        settings.lights.isOn = isSampled;
        settings.lights.mis = MisHeuristic::Off;  // or paths make up for a part
        return render.Render(settings, samples).mean.Mean().y;
    }

    SceneRender render{Device()};
};

}  // namespace

// Joints of a scale of 0, and targets, which place vertices themselves. Light sampling leaves out the inside
// of a flattened lamp. Its sides are at the same place, though, and rays that meet the inside add its light.
TEST_F(FlatDeform, TheInsideOfALampIsNotSampled) {
    for (const bool isByJoint : {false, true}) {
        SCOPED_TRACE(isByJoint ? "a joint" : "a target");
        scene::SceneData scene = SceneOf({BoxMesh(0.5f, 0), QuadMesh(0.001f, 1)},
                                         {Lambert(vec3(0.0f), kColor), Lambert(vec3(1.0f))});
        scene.nodes = {Scaled({1, 1, 0}), Scaled(vec3(1))};
        scene.nodeOrder = {0, 1};
        for (scene::Node& node : scene.nodes) node.translation.z = 1.0f;
        scene.nodes[1].mesh = 0;
        scene.instances[0].node = 1;
        scene::Primitive& box = scene.meshes[0].primitives[0];
        if (isByJoint) {
            scene.nodes[1].skin = 0;
            scene.skins.push_back({.name = "", .joints = {0}, .inverseBinds = {glm::mat4x3(1.0f)}});
            box.influences.perVertex = 1;
            box.influences.joints.assign(box.positions.size(), 0);
            box.influences.weights.assign(box.positions.size(), 1.0f);
        } else {
            scene::MorphTarget& target = box.targets.emplace_back();
            for (const vec3& p : box.positions) target.positions.emplace_back(0.0f, 0.0f, -p.z);
            scene.meshes[0].weights = {1.0f};
        }
        scene::UpdateDeformationBounds(box);
        scene::DeformInstances(scene);
        render.scene.SetScene(std::move(scene));
        const FloatImage seen = render.TraceOnce(LookAt({0.3f, 0.2f, 4.0f}, {0, 0, 1}, 0.2f, 8));
        for (const glm::vec4& value : seen.values) EXPECT_EQ(vec3(value), kColor);
        render.scene.SetEnvironment({.defaultLight = DefaultLight::None});
        const double expected = 0.239456 * double{kColor.y};
        const double light = LightOnWall(true, 16);
        EXPECT_GT(light, 0.99 * expected);
        EXPECT_LT(light, 1.3 * expected) << "2 where both sides are sampled";
        EXPECT_NEAR(LightOnWall(false, 64), expected, 0.02 * expected);
    }
}

}  // namespace raygraph::testing::flat_deform_test

// Poses applied to a scene, and what is said to have changed.
#include "renderer/scene/animation/pose.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/scene/pose_scene.h"
#include "tests/support/error_of.h"

namespace raygraph::scene::pose_applier_test {
namespace {

using glm::vec3;
using List = std::vector<uint32_t>;

class Applied : public ::testing::Test {
  protected:
    SceneData m_scene = Chain();
    std::optional<PoseEvaluator> m_evaluator;
    std::optional<PoseApplier> m_applier;

    const PoseChanges& At(double seconds, uint32_t animation = 0) {
        if (!m_evaluator) m_evaluator.emplace(m_scene);
        if (!m_applier) m_applier.emplace(m_scene);
        const std::array clips{ClipState{animation, seconds}};
        const PoseChanges& changes = m_applier->Apply(m_scene, m_evaluator->Evaluate(m_scene, clips));
        EXPECT_NO_THROW(Check(m_scene));
        return changes;
    }
    // Expects what a scene would have that was built with these nodes.
    void ExpectAsIfLoadedSo() {
        SceneData fresh = m_scene;
        UpdateWorldTransforms(fresh);
        for (size_t i = 0; i < fresh.instances.size(); ++i) {
            EXPECT_EQ(fresh.instances[i].objectToWorld, m_scene.instances[i].objectToWorld);
            EXPECT_EQ(fresh.instances[i].translationResidual, m_scene.instances[i].translationResidual);
        }
        EXPECT_EQ(fresh.cameras[0].cameraToWorld, m_scene.cameras[0].cameraToWorld);
        EXPECT_EQ(fresh.lights[0].lightToWorld, m_scene.lights[0].lightToWorld);
        EXPECT_EQ(fresh.bounds.min, m_scene.bounds.min);
        EXPECT_EQ(fresh.bounds.max, m_scene.bounds.max);
    }
};

// Makes this many nodes along +x, each with a triangle.
SceneData ManyInstances(uint32_t count) {
    SceneData scene = Chain();
    scene.nodes.assign(count, {});
    scene.nodeOrder.clear();
    scene.instances.clear();
    scene.cameras.clear();
    scene.lights.clear();
    for (uint32_t i = 0; i < count; ++i) {
        scene.nodes[i].mesh = 0;
        scene.nodes[i].translation.x = float(i);
        scene.nodeOrder.push_back(i);
        scene.instances.push_back({.mesh = 0, .node = i});
    }
    scene.meshes[0].primitives[0].targets.clear();
    scene.meshes[0].weights.clear();
    UpdateWorldTransforms(scene);
    return scene;
}

TEST_F(Applied, MovedNodesMoveAllBelowThem) {
    Add(m_scene, OfNode(AnimatedProperty::Rotation, 0), AboutZ(0), AboutZ(M_PI / 2));
    EXPECT_TRUE(At(0).IsEmpty());
    const PoseChanges& changes = At(1);
    EXPECT_EQ(changes.instances, List{0});
    EXPECT_EQ(changes.cameras, List{0});
    EXPECT_EQ(changes.lights, List{0});
    EXPECT_TRUE(changes.deformed.empty());
    EXPECT_TRUE(changes.areBoundsChanged);
    const vec3 tip = m_scene.instances[0].objectToWorld * glm::vec4(1, 0, 0, 1);
    EXPECT_NEAR(tip.x, 0, 1e-6f);
    EXPECT_NEAR(tip.y, 3, 1e-6f);
    ExpectAsIfLoadedSo();
    EXPECT_TRUE(At(1).IsEmpty()) << "nothing has changed since";
}

TEST_F(Applied, NodesBelowLeaveThoseAboveAlone) {
    Add(m_scene, OfNode(AnimatedProperty::Translation, 2), {0, 0, 0}, {0, 0, 5});
    const PoseChanges& changes = At(0.5);
    EXPECT_EQ(changes.instances, List{0});
    EXPECT_TRUE(changes.cameras.empty());
    EXPECT_TRUE(changes.lights.empty());
    EXPECT_EQ(m_scene.instances[0].objectToWorld[3], vec3(1, 0, 2.5f));
    ExpectAsIfLoadedSo();
}

// 10,000 km away a float's step is 1 m, that of the pose is not.
TEST_F(Applied, TranslationsKeepTheDigitsBetweenTheirKeys) {
    Add(m_scene, OfNode(AnimatedProperty::Translation, 0), {1e7f, 0, 0}, {1e7f + 1, 0, 0});
    At(0.25);
    const Instance& instance = m_scene.instances[0];
    EXPECT_EQ((PlacedTransform{instance.objectToWorld, instance.translationResidual}.Place().x), 1e7 + 2.25);
    ExpectAsIfLoadedSo();
}

TEST_F(Applied, WeightsDeformAndWidenTheBounds) {
    Add(m_scene, OfNode(AnimatedProperty::Weights, 2), {0.5f, 0}, {0.5f, 3});
    const PoseChanges& changes = At(1);
    EXPECT_EQ(changes.reweighted, List{0});
    EXPECT_EQ(changes.deformed, List{0});
    EXPECT_TRUE(changes.instances.empty());
    EXPECT_EQ(m_scene.nodes[2].weights, (std::vector<float>{0.5f, 3}));
    EXPECT_EQ(m_scene.meshes[0].weights, (std::vector<float>{0.5f, 0})) << "the node's own are set";
    EXPECT_EQ(m_scene.bounds.max.z, 3.0f);
    ExpectAsIfLoadedSo();
}

TEST_F(Applied, OneWeightLeavesTheOthers) {
    AnimationTarget target = OfNode(AnimatedProperty::Weights, 2);
    target.element = 1;
    Add(m_scene, target, {0}, {2});
    At(0.5);
    EXPECT_EQ(m_scene.nodes[2].weights, (std::vector<float>{0.5f, 1}));
}

TEST_F(Applied, VisibilityHidesWhatIsBelow) {
    AnimationSampler sampler{.interpolation = Interpolation::Step, .times = {0, 1, 2}, .values = {1, 0, 1}};
    m_scene.animations.push_back({.name = "",
                                  .samplers = {sampler},
                                  .channels = {{0, OfNode(AnimatedProperty::Visibility, 1)}},
                                  .duration = 2.0f});
    EXPECT_TRUE(At(0.9).IsEmpty());
    const PoseChanges& hidden = At(1.5);
    EXPECT_EQ(hidden.shown, List{0});
    EXPECT_EQ(hidden.lightsShown, List{0});
    EXPECT_FALSE(m_applier->IsVisible(0));
    EXPECT_TRUE(m_scene.bounds.IsEmpty());
    EXPECT_EQ(At(2).shown, List{0});
    EXPECT_TRUE(m_applier->IsVisible(0));
    ExpectAsIfLoadedSo();
}

// Scaled to nothing there is no transform that a ray could be taken through: the instance is hidden meanwhile.
TEST_F(Applied, WhatOthersHaveEditedIsFollowed) {
    Add(m_scene, OfNode(AnimatedProperty::Translation, 0), {0, 0, 0}, {4, 0, 0});
    At(0.5);
    m_scene.nodes[1].matrix = glm::mat4x3(1.0f);
    m_scene.nodes[1].isVisible = false;
    const std::array clips{ClipState{0, 0.5}};
    const std::array<uint32_t, 1> edited{1};
    const PoseChanges& changes = m_applier->Apply(m_scene, m_evaluator->Evaluate(m_scene, clips), edited);
    EXPECT_EQ(changes.instances, List{0});
    EXPECT_EQ(changes.lights, List{0});
    EXPECT_EQ(changes.shown, List{0});
    EXPECT_EQ(changes.lightsShown, List{0});
    EXPECT_FALSE(m_applier->IsNodeVisible(2));
    EXPECT_TRUE(m_applier->IsNodeVisible(0));
    EXPECT_EQ(m_scene.instances[0].objectToWorld[3], vec3(3, 0, 0));
    EXPECT_EQ(m_applier->BoundsOf(0).min, vec3(3, 0, 0));
    ExpectAsIfLoadedSo();
}

TEST_F(Applied, WhatIsScaledToNothingIsHidden) {
    Add(m_scene, OfNode(AnimatedProperty::Scale, 0), {2, 2, 2}, {0, 0, 0});
    At(0.5);
    EXPECT_EQ(m_scene.instances[0].objectToWorld[0].x, 1.0f);
    const PoseChanges& changes = At(1);
    EXPECT_EQ(changes.shown, List{0});
    EXPECT_TRUE(changes.instances.empty());
    EXPECT_TRUE(m_scene.instances[0].isCollapsed);
    EXPECT_TRUE(m_scene.bounds.IsEmpty());
    ExpectAsIfLoadedSo();
    At(0);
    EXPECT_FALSE(m_scene.instances[0].isCollapsed);
    EXPECT_TRUE(m_applier->IsVisible(0));
    EXPECT_EQ(m_scene.instances[0].objectToWorld[0].x, 2.0f);
}

template <typename List, typename Member>
uint8_t IndexOf(const List& list, Member member) {
    uint8_t index = 0, found = 255;
    const auto look = [&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), Member>)
            if (field.member == member) found = index;
        ++index;
    };
    std::apply([&](const auto&... field) { (look(field), ...); }, list);
    return found;
}

TEST_F(Applied, MaterialsArePutIntoTheirRange) {
    const uint8_t field = IndexOf(material_fields::kAll, &Material::roughnessFactor);
    Add(m_scene, {.property = AnimatedProperty::MaterialField, .field = field}, {0}, {4});
    EXPECT_EQ(At(0.125).materials, List{0});
    EXPECT_EQ(m_scene.materials[0].roughnessFactor, 0.5f);
    At(1);
    EXPECT_EQ(m_scene.materials[0].roughnessFactor, 1.0f);
    EXPECT_TRUE(At(0.5).IsEmpty()) << "2 is 1, too";
}

TEST_F(Applied, CamerasAndLightsChange) {
    Add(m_scene, {.property = AnimatedProperty::CameraField}, {1}, {9});
    Add(m_scene, {.property = AnimatedProperty::LightField, .field = 4}, {0.5f}, {0});
    m_scene.lights[0].innerConeAngle = 0.4f;
    EXPECT_EQ(At(0.125).cameras, List{0});
    EXPECT_EQ(m_scene.cameras[0].yFov, 2.0f);
    At(1);
    EXPECT_LT(m_scene.cameras[0].yFov, 3.1415927f);
    EXPECT_EQ(At(1, 1).lights, List{0});
    EXPECT_GT(m_scene.lights[0].outerConeAngle, m_scene.lights[0].innerConeAngle) << "a cone all the same";
}

class AppliedSkin : public Applied {
  protected:
    // The mesh follows nodes 0 and 1, half each.
    AppliedSkin() {
        Primitive& primitive = m_scene.meshes[0].primitives[0];
        primitive.influences = {2, {0, 1, 0, 1, 0, 1}, {0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f}, {}};
        UpdateDeformationBounds(primitive);
        Skin& skin = m_scene.skins.emplace_back();
        skin.joints = {0, 1};
        skin.inverseBinds.assign(2, glm::mat4x3(1.0f));
        skin.inverseBinds[1][3].x = -1.0f;
        m_scene.nodes[2].skin = 0;
        m_scene.nodes[2].parent = kNone;
    }
};

TEST_F(AppliedSkin, MovedAsAWholeOnlyTheInstanceMoves) {
    Add(m_scene, OfNode(AnimatedProperty::Translation, 0), {0, 0, 0}, {0, 0, 5});
    const PoseChanges& changes = At(1);
    EXPECT_EQ(changes.instances, List{0});
    EXPECT_TRUE(changes.deformed.empty());
    EXPECT_TRUE(changes.skins.empty());
    EXPECT_EQ(m_scene.instances[0].objectToWorld[3], vec3(0, 0, 5));
    ExpectAsIfLoadedSo();
}

TEST_F(AppliedSkin, ABentJointDeforms) {
    Add(m_scene, OfNode(AnimatedProperty::Translation, 1), {1, 0, 0}, {1, 2, 0});
    const PoseChanges& changes = At(1);
    EXPECT_TRUE(changes.instances.empty());
    EXPECT_EQ(changes.skins, List{0});
    EXPECT_EQ(changes.deformed, List{0});
    EXPECT_TRUE(changes.reweighted.empty());
    const std::span<const glm::mat4x3> matrices = m_applier->JointMatricesOf(0);
    ASSERT_EQ(matrices.size(), 2u);
    EXPECT_EQ(matrices[0], glm::mat4x3(1.0f));
    EXPECT_EQ(matrices[1][3], vec3(0, 2, 0));
    DeformedStreams streams;
    DeformPrimitive(m_scene.meshes[0].primitives[0], MorphWeights(m_scene, m_scene.instances[0]), matrices,
                    streams);
    EXPECT_EQ(streams.positions[1], vec3(1, 1, 0));
    EXPECT_GE(m_scene.bounds.max.y, 2.0f);
    ExpectAsIfLoadedSo();
}

// Whatever an animation or a skin contains, the scene passes Check, which At calls.
TEST_F(Applied, HugeNumbersStayFinite) {
    constexpr float kMost = std::numeric_limits<float>::max();
    Add(m_scene, OfNode(AnimatedProperty::Scale, 0), {1, 1, 1}, {kMost, -kMost, kMost});
    Add(m_scene, OfNode(AnimatedProperty::Translation, 0), {0, 0, 0}, {kMost, -kMost, kMost});
    Add(m_scene, OfNode(AnimatedProperty::Weights, 2), {0, 0}, {kMost, kMost});
    Add(m_scene, {.property = AnimatedProperty::LightField}, {0, 0, 0}, {kMost, kMost, kMost});
    m_scene.lights[0].intensity = 1e30f;
    for (const uint32_t animation : {0u, 1u, 2u, 3u}) At(1, animation);
}

TEST_F(AppliedSkin, HugeMatricesLeaveTheBoundsFinite) {
    m_scene.skins[0].inverseBinds[0] = glm::mat4x3(vec3(3e38f), vec3(3e38f), vec3(3e38f), vec3(0));
    Add(m_scene, OfNode(AnimatedProperty::Translation, 0), {0, 0, 0}, {0, 0, 5});
    At(1);
    EXPECT_TRUE(m_scene.bounds.IsEmpty());
}

TEST_F(AppliedSkin, ItsOwnNodeDoesNotCount) {
    Add(m_scene, OfNode(AnimatedProperty::Translation, 2), {0, 0, 0}, {0, 0, 5});
    EXPECT_TRUE(At(1).IsEmpty());
    Add(m_scene, OfNode(AnimatedProperty::Scale, 2), {1, 1, 1}, {0, 0, 0});
    m_evaluator.reset();
    EXPECT_TRUE(At(1, 1).IsEmpty());
    EXPECT_TRUE(m_applier->IsVisible(0));
}

// Instances of a triangle in a line, which go up and down one by one, a few and all at once, and hide: the bounds are
// those of all that are seen.
TEST(PoseApplier, BoundsOfManyInstancesAreThoseOfAllThatAreSeen) {
    for (const uint32_t count : {1u, 2u, 3u, 1000u}) {
        SceneData scene = ManyInstances(count);
        PoseApplier applier(scene);
        std::mt19937 random(count);
        for (int step = 0; step < 60; ++step) {
            std::vector<uint32_t> edited;
            const uint32_t editCount = step % 3 == 0 ? 1 : step % 3 == 1 ? 1 + count / 50 : count;
            for (uint32_t i = 0; i < editCount; ++i) {
                edited.push_back(uint32_t(random() % count));
                Node& node = scene.nodes[edited.back()];
                node.translation.y = float(int(random() % 100) - 50);
                node.isVisible = random() % 4 != 0;
            }
            applier.Apply(scene, {}, edited);
            const std::vector<bool> isVisible = VisibleNodes(scene);
            Bounds expected;
            for (uint32_t i = 0; i < count; ++i)
                if (isVisible[i]) expected.Extend(applier.BoundsOf(i));
            ASSERT_EQ(scene.bounds.min, expected.min) << count << " instances, step " << step;
            ASSERT_EQ(scene.bounds.max, expected.max) << count << " instances, step " << step;
        }
    }
}

TEST(PoseApplier, OneOfManyInstancesTakesLittleOfTheTimeOfAll) {
    constexpr uint32_t kCount = 100'000;
    SceneData scene = ManyInstances(kCount);
    Add(scene, OfNode(AnimatedProperty::Translation, kCount / 2), {0, 0, 0}, {0, 0, 9});
    PoseEvaluator evaluator(scene);
    PoseApplier applier(scene);
    List all(kCount);
    std::iota(all.begin(), all.end(), 0u);
    // The shortest of some calls, milliseconds.
    const auto shortest = [&](const List& moved, auto&& apply) {
        double least = 1e9;
        for (int frame = 0; frame < 30; ++frame) {
            const auto start = std::chrono::steady_clock::now();
            const PoseChanges& changes = apply(frame);
            const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
            least = std::min(least, taken.count());
            EXPECT_EQ(changes.instances, moved);
            EXPECT_TRUE(changes.areBoundsChanged);
        }
        return least;
    };
    const double ofOne = shortest({kCount / 2}, [&](int frame) -> const PoseChanges& {
        const std::array clips{ClipState{0, 0.01 + 0.01 * frame}};
        return applier.Apply(scene, evaluator.Evaluate(scene, clips));
    });
    const double ofAll = shortest(all, [&](int frame) -> const PoseChanges& {
        for (Node& node : scene.nodes) node.translation.z = float(10 + frame);
        return applier.Apply(scene, {}, all);
    });
    RecordProperty("all", std::to_string(ofAll));
    RecordProperty("one", std::to_string(ofOne));
    EXPECT_LT(ofOne, ofAll / 15.0) << ofAll << " ms for all";
}

}  // namespace
}  // namespace raygraph::scene::pose_applier_test

// Poses of a scene, and how they are applied.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/support/error_of.h"

// A scene for tests of poses, and animations of it.
namespace raygraph::scene {

// A chain of nodes 0, 1, 2, each 1 m along +x of the one above. Node 2 has a mesh with two morph targets, node 1
// a camera and a light.
inline SceneData Chain() {
    SceneData scene;
    scene.nodes.resize(3);
    for (uint32_t i = 0; i < 3; ++i) {
        scene.nodes[i].parent = i == 0 ? kNone : i - 1;
        scene.nodes[i].translation = {i == 0 ? 0 : 1, 0, 0};
    }
    scene.nodes[2].mesh = 0;
    scene.nodeOrder = {0, 1, 2};
    Primitive triangle;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    triangle.indices = {0, 1, 2};
    triangle.bounds = BoundsOf(triangle.positions);
    triangle.targets.resize(2);
    triangle.targets[1].positions = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    UpdateDeformationBounds(triangle);
    scene.meshes.push_back({.name = "", .primitives = {triangle}, .weights = {0.5f, 0}});
    scene.materials.resize(1);
    scene.instances.push_back({.mesh = 0, .node = 2});
    scene.cameras.emplace_back().node = 1;
    scene.lights.emplace_back().node = 1;
    scene.lights[0].type = LightType::Spot;
    UpdateWorldTransforms(scene);
    return scene;
}

// An animation of one channel, whose values go from `from` at 0 s to `to` at 1 s.
inline uint32_t Add(SceneData& scene, const AnimationTarget& target, const std::vector<float>& from,
                    const std::vector<float>& to) {
    AnimationSampler sampler{.width = uint32_t(from.size()), .times = {0, 1}, .values = from};
    sampler.values.insert(sampler.values.end(), to.begin(), to.end());
    scene.animations.push_back(
        {.name = "", .samplers = {sampler}, .channels = {{0, target}}, .duration = 1.0f});
    Check(scene);
    return uint32_t(scene.animations.size() - 1);
}
inline AnimationTarget OfNode(AnimatedProperty property, uint32_t node) {
    return {.property = property, .object = node};
}
inline std::vector<float> AboutZ(double radians) {
    return {0, 0, float(std::sin(radians / 2)), float(std::cos(radians / 2))};
}

inline std::vector<double> Values(const Pose& pose) {
    return pose.values;
}

}  // namespace raygraph::scene

// Poses: clips blended with each other and with the rest pose.
namespace raygraph::scene::pose_test {
namespace {

using glm::vec3;

TEST(Pose, WithoutClipsIsTheRestPoseToTheBit) {
    SceneData scene = Chain();
    scene.nodes[1].translation = {0.1f, 0.2f, 0.3f};
    scene.nodes[1].translationResidual = {1e-9f, 0, 0};
    scene.nodes[1].rotation = glm::normalize(glm::quat(0.3f, 0.1f, 0.7f, 0.2f));
    Add(scene, OfNode(AnimatedProperty::Translation, 1), {0, 0, 0}, {1, 1, 1});
    Add(scene, OfNode(AnimatedProperty::Rotation, 1), AboutZ(0), AboutZ(1));
    Add(scene, OfNode(AnimatedProperty::Scale, 0), {1, 1, 1}, {2, 2, 2});
    SceneData posed = scene;
    PoseEvaluator evaluator(scene);
    PoseApplier applier(posed);
    applier.Apply(posed,
                  evaluator.Evaluate(scene, std::array{ClipState{0, 1}, ClipState{1, 0.5}, ClipState{2, 1}}));
    EXPECT_EQ(posed.nodes[1].translation, vec3(1));
    applier.Apply(posed, evaluator.Evaluate(scene, {}));
    for (uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(posed.nodes[i].translation, scene.nodes[i].translation);
        EXPECT_EQ(posed.nodes[i].translationResidual, scene.nodes[i].translationResidual);
        EXPECT_EQ(posed.nodes[i].rotation, scene.nodes[i].rotation);
        EXPECT_EQ(posed.nodes[i].scale, scene.nodes[i].scale);
    }
    EXPECT_EQ(Values(evaluator.Rest()), Values(evaluator.Evaluate(scene, {})));
}

TEST(Pose, BlendsClipsByTheirWeightsAndTheRemainderWithTheRest) {
    SceneData scene = Chain();  // node 1 rests at x = 1
    const uint32_t a = Add(scene, OfNode(AnimatedProperty::Translation, 1), {10, 0, 0}, {20, 0, 0});
    const uint32_t b = Add(scene, OfNode(AnimatedProperty::Translation, 1), {0, 8, 0}, {0, 8, 0});
    PoseEvaluator evaluator(scene);
    const auto pose = [&](std::vector<ClipState> clips) {
        const Pose& evaluated = evaluator.Evaluate(scene, clips);
        EXPECT_EQ(evaluated.properties.size(), 1u) << "one of both";
        return vec3(evaluated.values[0], evaluated.values[1], evaluated.values[2]);
    };
    EXPECT_EQ(pose({{a, 0.5}}), vec3(15, 0, 0));
    EXPECT_EQ(pose({{a, 0.5, 0.25f}}), vec3(0.25f * 15 + 0.75f, 0, 0));
    EXPECT_EQ(pose({{a, 0, 0.25f}, {b, 0, 0.5f}}), vec3(0.25f * 10 + 0.25f, 4, 0));
    EXPECT_EQ(pose({{a, 0, 3}, {b, 0, 1}}), vec3(7.5f, 2, 0)) << "above 1: shares";
    EXPECT_EQ(pose({{a, 0, 0.5f}, {a, 1, 0.5f}}), vec3(15, 0, 0)) << "one animation twice";
    EXPECT_EQ(pose({{a, 0, 0}, {b, 0, -1}}), vec3(1, 0, 0)) << "no weight";
    EXPECT_EQ(pose({{a, 0, NAN}}), vec3(1, 0, 0));
    EXPECT_EQ(testing::ErrorTextOf([&] { pose({{7, 0}}); }), "there is no animation 7, the scene has 2");
}

// Half of infinite and of 10 is not 5.
TEST(Pose, BlendsWhatIsInfiniteAtZeroByReciprocals) {
    SceneData scene = Chain();
    scene.lights.emplace_back();  // whose range is infinite
    const AnimationTarget range{.property = AnimatedProperty::LightField, .field = 2};
    const uint32_t a = Add(scene, range, {10}, {20}), b = Add(scene, range, {40}, {40});
    PoseEvaluator evaluator(scene);
    const auto pose = [&](std::vector<ClipState> clips) {
        return evaluator.Evaluate(scene, clips).values[0];
    };
    EXPECT_DOUBLE_EQ(pose({{a, 0.5}}), 15) << "within a clip as it says";
    EXPECT_DOUBLE_EQ(pose({{a, 0, 0.5f}}), 20);
    EXPECT_DOUBLE_EQ(pose({{a, 0, 0.25f}}), 40);
    EXPECT_EQ(pose({}), 0);
    EXPECT_EQ(pose({{a, 0, 0}}), 0);
    EXPECT_DOUBLE_EQ(pose({{a, 0, 0.5f}, {b, 0, 0.5f}}), 16);
    EXPECT_DOUBLE_EQ(pose({{a, 0, 2}, {b, 0, 2}}), 16);
    scene.lights[0].range = 40;
    evaluator.ReadRest(scene);
    EXPECT_DOUBLE_EQ(pose({{a, 0, 0.5f}}), 16);
}

// A clip that has no channel for a property takes no part in it.
TEST(Pose, ClipsCountOnlyForWhatTheyMove) {
    SceneData scene = Chain();
    const uint32_t a = Add(scene, OfNode(AnimatedProperty::Translation, 1), {10, 0, 0}, {10, 0, 0});
    const uint32_t b = Add(scene, OfNode(AnimatedProperty::Scale, 1), {3, 3, 3}, {3, 3, 3});
    PoseEvaluator evaluator(scene);
    const Pose& pose = evaluator.Evaluate(scene, std::array{ClipState{a, 0}, ClipState{b, 0}});
    ASSERT_EQ(pose.values.size(), 6u);
    EXPECT_EQ(pose.values[0], 10);
    EXPECT_EQ(pose.values[3], 3);
}

double AngleOf(const Pose& pose) {
    return 2.0 * std::atan2(pose.values[2], pose.values[3]);
}

TEST(Pose, RotationsAreBlendedOnOneSide) {
    SceneData scene = Chain();
    std::vector<float> turned = AboutZ(1.0);
    for (float& value : turned) value = -value;  // the same rotation
    const uint32_t a = Add(scene, OfNode(AnimatedProperty::Rotation, 1), AboutZ(0.5), AboutZ(0.5));
    const uint32_t b = Add(scene, OfNode(AnimatedProperty::Rotation, 1), turned, turned);
    PoseEvaluator evaluator(scene);
    const std::array half{ClipState{a, 0, 0.5f}, ClipState{b, 0, 0.5f}};
    EXPECT_NEAR(AngleOf(evaluator.Evaluate(scene, half)), 0.75, 1e-6);
    // And the rest, which is no turn
    const std::array quarter{ClipState{b, 0, 0.5f}};
    EXPECT_NEAR(std::abs(AngleOf(evaluator.Evaluate(scene, quarter))), 2 * M_PI - 0.5, 1e-6)
        << "or its negative";
    const Pose& pose = evaluator.Evaluate(scene, half);
    double square = 0.0;
    for (const double value : pose.values) square += value * value;
    EXPECT_NEAR(square, 1.0, 1e-12);
}

TEST(Pose, ChannelsOfNodesWithAMatrixAreLeftOut) {
    SceneData scene = Chain();
    Add(scene, OfNode(AnimatedProperty::Translation, 1), {10, 0, 0}, {20, 0, 0});
    scene.nodes[1].matrix = glm::mat4x3(1.0f);
    PoseEvaluator evaluator(scene);
    EXPECT_TRUE(evaluator.Evaluate(scene, std::array{ClipState{0, 1}}).properties.empty());
}

TEST(Pose, TenThousandNodesTakeMilliseconds) {
    constexpr uint32_t kCount = 10000;
    SceneData scene = Chain();
    scene.nodes.resize(3 + kCount);
    Animation& animation = scene.animations.emplace_back();
    animation.duration = 9.0f;
    for (const uint32_t width : {3u, 4u, 3u}) {
        AnimationSampler sampler{.width = width, .times = {}, .values = {}};
        for (uint32_t key = 0; key < 10; ++key) {
            sampler.times.push_back(float(key));
            for (uint32_t i = 0; i < width; ++i) sampler.values.push_back(1.0f + float(key * i));
        }
        animation.samplers.push_back(sampler);
    }
    for (uint32_t i = 3; i < 3 + kCount; ++i) {
        scene.nodes[i].mesh = 0;
        scene.nodeOrder.push_back(i);
        scene.instances.push_back({.mesh = 0, .node = i});
        animation.channels.push_back({0, OfNode(AnimatedProperty::Translation, i)});
        animation.channels.push_back({1, OfNode(AnimatedProperty::Rotation, i)});
        animation.channels.push_back({2, OfNode(AnimatedProperty::Scale, i)});
    }
    Check(scene);
    PoseEvaluator evaluator(scene);
    PoseApplier applier(scene);
    double fastest = 1e9;
    for (int frame = 0; frame < 20; ++frame) {
        const auto start = std::chrono::steady_clock::now();
        const std::array clips{ClipState{0, 0.1 + 0.4 * frame}};
        const PoseChanges& changes = applier.Apply(scene, evaluator.Evaluate(scene, clips));
        const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
        fastest = std::min(fastest, taken.count());
        EXPECT_EQ(changes.instances.size(), kCount);
    }
    RecordProperty("milliseconds", std::to_string(fastest));
    // A search from the start or a list for each node would take a hundred times as long
    EXPECT_LT(fastest, 200.0);
}

}  // namespace
}  // namespace raygraph::scene::pose_test

// Poses applied to a scene, and what is said to have changed.
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

// Poses whose values belong together: what is applied is legal, and the rest comes back as it was.
namespace raygraph::scene::pose_legal_test {
namespace {

using List = std::vector<uint32_t>;

uint8_t EmissiveFactor() {
    uint8_t index = 0, found = 255;
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), glm::vec3 Material::*>)
            if (field.member == &Material::emissiveFactor) found = index;
        ++index;
    });
    return found;
}

// A mesh with two morph targets, a camera and a spot light.
class LegalPose : public ::testing::Test {
  protected:
    const PoseChanges& At(double seconds, uint32_t animation = 0) {
        if (!m_evaluator) m_evaluator.emplace(m_scene);
        if (!m_applier) m_applier.emplace(m_scene);
        const std::array clips{ClipState{animation, seconds}};
        const PoseChanges& changes = m_applier->Apply(m_scene, m_evaluator->Evaluate(m_scene, clips));
        EXPECT_NO_THROW(Check(m_scene));
        return changes;
    }

    SceneData m_scene = Chain();
    std::optional<PoseEvaluator> m_evaluator;
    std::optional<PoseApplier> m_applier;
};

// An inner angle above the outer one is cut off, whatever came before, and is back at rest. Only one of both is
// animated.
TEST_F(LegalPose, ConesStayCones) {
    m_scene.lights[0].innerConeAngle = 0.4f;
    m_scene.lights[0].outerConeAngle = 0.7f;
    Add(m_scene, {.property = AnimatedProperty::LightField, .field = 4}, {0.7f}, {0.1f});
    Add(m_scene, {.property = AnimatedProperty::LightField, .field = 3}, {0.4f}, {0.9f});
    const Light& light = m_scene.lights[0];
    for (int i = 0; i < 2; ++i) {
        At(1);
        EXPECT_EQ(light.outerConeAngle, 0.1f);
        EXPECT_EQ(light.innerConeAngle, std::nextafter(0.1f, 0.0f));
        At(1, 1);
        EXPECT_EQ(light.outerConeAngle, 0.7f);
        EXPECT_EQ(light.innerConeAngle, std::nextafter(0.7f, 0.0f));
        At(0);
        EXPECT_EQ(light.outerConeAngle, 0.7f);
        EXPECT_EQ(light.innerConeAngle, 0.4f);
    }
}

TEST_F(LegalPose, CamerasKeepTheirNearPlaneBeforeTheFarOne) {
    m_scene.cameras[0].zNear = 0.5f;
    m_scene.cameras[0].zFar = 100.0f;
    Add(m_scene, {.property = AnimatedProperty::CameraField, .field = 3}, {100}, {0.25f});
    const Camera& camera = m_scene.cameras[0];
    EXPECT_EQ(At(1).cameras, List{0});
    EXPECT_EQ(camera.zFar, 0.25f);
    EXPECT_EQ(camera.zNear, std::nextafter(0.25f, 0.0f));
    At(0);
    EXPECT_EQ(camera.zFar, 100.0f);
    EXPECT_EQ(camera.zNear, 0.5f);
}

TEST_F(LegalPose, ProductsOfColorAndStrengthStayFinite) {
    constexpr float kMax = std::numeric_limits<float>::max();
    m_scene.materials[0].emissiveStrength = 1e38f;
    const uint8_t color = EmissiveFactor();
    Add(m_scene, {.property = AnimatedProperty::MaterialField, .field = color}, {1, 1, 1}, {9, 1, 1});
    m_scene.lights[0].intensity = 1e38f;
    Add(m_scene, {.property = AnimatedProperty::LightField, .field = 0}, {1, 1, 1}, {9, 1, 1});
    const Material& material = m_scene.materials[0];
    At(1);
    const bool isFinite = std::isfinite(material.EmittedRadiance().x);
    EXPECT_TRUE(isFinite);
    EXPECT_EQ(material.emissiveStrength, kMax / std::max(1.0f, material.emissiveFactor.x));
    At(1, 1);
    EXPECT_EQ(m_scene.lights[0].intensity, kMax / 9);
    EXPECT_EQ(material.emissiveStrength, 1e38f);
    At(0, 1);
    EXPECT_EQ(m_scene.lights[0].intensity, 1e38f);
}

// Numbers beyond what a float holds are at no place.
TEST_F(LegalPose, WhatIsDeformedBeyondNumbersIsHidden) {
    m_scene.meshes[0].primitives[0].targets[1].positions.assign(3, {0, 0, 10});
    UpdateDeformationBounds(m_scene.meshes[0].primitives[0]);
    Add(m_scene, OfNode(AnimatedProperty::Weights, 2), {0.5f, 0}, {0.5f, 3e38f});
    EXPECT_EQ(At(1).shown, List{0});
    EXPECT_FALSE(m_applier->IsVisible(0));
    EXPECT_TRUE(m_scene.instances[0].isCollapsed);
    EXPECT_TRUE(m_scene.bounds.IsEmpty());
    EXPECT_EQ(At(0).shown, List{0});
    EXPECT_TRUE(m_applier->IsVisible(0));
}

}  // namespace
}  // namespace raygraph::scene::pose_legal_test

// Poses: clips blended with each other and with the rest pose.
#include "renderer/scene/animation/pose.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/scene/pose_scene.h"
#include "tests/support/error_of.h"

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

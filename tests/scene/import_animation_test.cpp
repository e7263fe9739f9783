// Animations of glTF: what is read, repaired and refused.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "renderer/scene/animation/pose.h"
#include "tests/scene/motion_document.h"
#include "tests/support/error_of.h"

namespace raygraph::test::import_animation_test {
namespace {

using glm::vec3;
using scene::AnimatedProperty;
using scene::Interpolation;

Json Target(const char* path, size_t node = 0) {
    return {{"node", node}, {"path", path}};
}

// A triangle that moves from (1, 2, 3) to (3, 2, 1) within a second.
GltfDocument Moving() {
    GltfDocument document;
    document.AddTriangle();
    Animate(document, Target("translation"), {0, 1}, {1, 2, 3, 3, 2, 1}, 3);
    document.json["animations"][0]["name"] = "walk";
    return document;
}

scene::SceneData PosedAt(scene::SceneData scene, double seconds, uint32_t animation = 0) {
    scene::PoseEvaluator evaluator(scene);
    scene::PoseApplier applier(scene);
    applier.Apply(scene, evaluator.Evaluate(scene, std::array{scene::ClipState{animation, seconds}}));
    return scene;
}

TEST(ImportAnimation, ChannelsHaveTheirSamplersAndTargets) {
    GltfDocument document = Moving();
    document.json["animations"][0]["samplers"].push_back(
        {{"input", document.AddAccessor<float>({0.5f, 2.5f}, 1)},
         {"output", document.AddAccessor<float>({0, 0, 0, 1, 1, 0, 0, 0}, 4)},
         {"interpolation", "STEP"}});
    document.json["animations"][0]["channels"].push_back({{"sampler", 1}, {"target", Target("rotation")}});
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.animations.size(), 1u);
    const scene::Animation& animation = scene.animations[0];
    EXPECT_EQ(animation.name, "walk");
    EXPECT_EQ(animation.duration, 2.5f);
    ASSERT_EQ(animation.samplers.size(), 2u);
    EXPECT_EQ(animation.samplers[0].interpolation, Interpolation::Linear);
    EXPECT_EQ(animation.samplers[0].width, 3u);
    EXPECT_EQ(animation.samplers[0].times, (std::vector<float>{0, 1}));
    EXPECT_EQ(animation.samplers[0].values, (std::vector<float>{1, 2, 3, 3, 2, 1}));
    EXPECT_EQ(animation.samplers[1].interpolation, Interpolation::Step);
    ASSERT_EQ(animation.channels.size(), 2u);
    EXPECT_EQ(animation.channels[1].sampler, 1u);
    EXPECT_EQ(animation.channels[1].target.property, AnimatedProperty::Rotation);
    EXPECT_EQ(animation.channels[1].target.object, 0u);
    EXPECT_EQ(PosedAt(scene, 0.5).instances[0].objectToWorld[3], vec3(2, 2, 2));
    EXPECT_EQ(PosedAt(scene, 2.5).instances[0].objectToWorld[1], vec3(0, -1, 0)) << "half a turn about +x";
}

TEST(ImportAnimation, CubicSplinesHaveThreeValuesAKey) {
    GltfDocument document;
    document.AddTriangle();
    Animate(document, Target("scale"), {0, 2}, {9, 9, 9, 1, 1, 1, 1, 0, 0, -1, 0, 0, 1, 1, 1, 9, 9, 9}, 3,
            "CUBICSPLINE");
    const scene::SceneData scene = Load(document);
    // Tangents of 1 and -1 a second over 2 s: 1 + 1/8 * 2 + 1/8 * 2 in the middle
    EXPECT_FLOAT_EQ(PosedAt(scene, 1).nodes[0].scale.x, 1.5f);
    EXPECT_FLOAT_EQ(PosedAt(scene, 1).nodes[0].scale.y, 1.0f);
}

TEST(ImportAnimation, RotationsMayBeNormalizedIntegers) {
    const auto angle = [](auto values) {
        GltfDocument document;
        document.AddTriangle();
        const size_t input = document.AddAccessor<float>({0}, 1);
        AddAnimation(document, input, document.AddAccessor(values, 4, true), Target("rotation"));
        const scene::SceneData scene = PosedAt(Load(document), 0);
        EXPECT_TRUE(scene.warnings.empty());
        EXPECT_NEAR(glm::length(scene.nodes[0].rotation), 1.0f, 1e-6f);
        return 2.0f * std::atan2(scene.nodes[0].rotation.z, scene.nodes[0].rotation.w);
    };
    EXPECT_NEAR(angle(std::vector<int8_t>{0, 0, 90, 90}), M_PI / 2, 1e-6);
    EXPECT_NEAR(angle(std::vector<uint8_t>{0, 0, 180, 180}), M_PI / 2, 1e-6);
    EXPECT_NEAR(angle(std::vector<int16_t>{0, 0, -23170, 23170}), -M_PI / 2, 1e-6);
    EXPECT_NEAR(angle(std::vector<uint16_t>{0, 0, 65535, 0}), M_PI, 1e-6);
}

TEST(ImportAnimation, AccessorsMayBeSparse) {
    GltfDocument document = Moving();
    const size_t ids = document.AddBufferView(BytesOf<uint8_t>({1}));
    const size_t values = document.AddBufferView(BytesOf<float>({7, 8, 9}));
    const size_t output = document.json["animations"][0]["samplers"][0]["output"];
    document.json["accessors"][output]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", ids}, {"componentType", kUint8}}},
        {"values", {{"bufferView", values}}}};
    EXPECT_EQ(PosedAt(Load(document), 1).nodes[0].translation, vec3(7, 8, 9));
}

TEST(ImportAnimation, WhatCannotBeMovedIsLeftOutWithAWarning) {
    const auto warning = [](const Json& target, const char* node = nullptr) {
        GltfDocument document = Moving();
        document.json["animations"][0]["channels"][0]["target"] = target;
        if (node) document.json["nodes"][0].update(Json::parse(node));
        const scene::SceneData scene = Load(document);
        EXPECT_TRUE(scene.animations[0].channels.empty());
        EXPECT_TRUE(scene.animations[0].samplers.empty());
        return scene.warnings.size() == 1 ? scene.warnings[0] : "not one";
    };
    EXPECT_EQ(warning({{"path", "translation"}}),
              "scene.gltf: animations[0].channels[0].target: has no node, ignored");
    EXPECT_EQ(warning(Target("color")),
              "scene.gltf: animations[0].channels[0].target.path: is none that is read, ignored");
    EXPECT_EQ(warning(Target("weights")),
              "scene.gltf: animations[0].channels[0].target: nodes[0] has no such morph targets, ignored");
    EXPECT_EQ(warning(Target("translation"), R"({"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]})"),
              "scene.gltf: animations[0].channels[0].target: nodes[0] has a matrix, and cannot be animated");
}

TEST(ImportAnimation, FirstChannelOfATargetCounts) {
    GltfDocument document = Moving();
    Json& animation = document.json["animations"][0];
    animation["samplers"].push_back(animation["samplers"][0]);
    animation["samplers"][1]["output"] = document.AddAccessor<float>({0, 0, 0, 0, 0, 0}, 3);
    animation["channels"].push_back({{"sampler", 1}, {"target", Target("translation")}});
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0],
              "scene.gltf: animations[0].channels[1].target: is that of another channel, too: the first one "
              "counts");
    EXPECT_EQ(PosedAt(scene, 0).nodes[0].translation, vec3(1, 2, 3));
}

TEST(ImportAnimation, NodesOutsideTheSceneAreMovedAndNotSeen) {
    GltfDocument document = Moving();
    document.Add("nodes", {{"name", "elsewhere"}});
    document.json["animations"][0]["channels"][0]["target"]["node"] = 1;
    const scene::SceneData scene = PosedAt(Load(document), 1);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.nodes[1].translation, vec3(3, 2, 1));
    EXPECT_EQ(scene.instances[0].objectToWorld[3], vec3(0));
}

// A mesh that grows from nothing is there from the start, unseen.
TEST(ImportAnimation, WhatGrowsFromNothingIsKept) {
    GltfDocument document;
    document.AddTriangle();
    document.json["nodes"][0]["scale"] = {0, 0, 0};
    EXPECT_TRUE(Load(document).instances.empty());
    Animate(document, Target("scale"), {0, 1}, {0, 0, 0, 2, 2, 2}, 3);
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_TRUE(scene.instances[0].isCollapsed);
    EXPECT_TRUE(scene.bounds.IsEmpty());
    const scene::SceneData grown = PosedAt(scene, 1);
    EXPECT_FALSE(grown.instances[0].isCollapsed);
    EXPECT_EQ(grown.instances[0].objectToWorld[0].x, 2.0f);
    EXPECT_EQ(grown.bounds.max, vec3(2, 2, 0));
}

TEST(ImportAnimation, BadOnesAreRefused) {
    GltfDocument document = Moving();
    const size_t three = document.AddAccessor<float>({0, 1, 2}, 1);
    const size_t bytes = document.AddAccessor<uint8_t>({0, 1}, 1, true);
    const size_t wholes = document.AddAccessor<int8_t>({0, 0, 0, 1, 0, 0, 0, 1}, 4);
    const size_t matrices = AddMatrices(document, std::vector<float>(32, 1.0f));
    const auto named = [](size_t accessor) { return "accessors[" + std::to_string(accessor) + "]"; };
    const auto change = [&](const char* where, const Json& value, const std::string& message) {
        GltfDocument changed = document;
        changed.json["animations"][0].merge_patch(
            Json::parse(R"({"channels": [{"sampler": 0, "target": {"node": 0,
            "path": "translation"}}]})"));
        changed.json["animations"][0][Json::json_pointer(where)] = value;
        EXPECT_EQ(LoadError(changed), "scene.gltf: animations[0]" + message) << where;
    };
    const char *input = "/samplers/0/input", *output = "/samplers/0/output";
    change(input, bytes, ".samplers[0].input: " + named(bytes) + " must be SCALAR of float");
    change(input, 99,
           ".samplers[0].input: is 99, but there are " + std::to_string(matrices + 1) + " accessors");
    change(output, three, ".samplers[0].output: " + named(three) + " must be VEC3 of float, bytes or shorts");
    change(output, matrices,
           ".samplers[0].output: " + named(matrices) + " must be VEC3 of float, bytes or shorts");
    change("/samplers/0/interpolation", "SMOOTH",
           ".samplers[0].interpolation: is \"SMOOTH\", must be LINEAR, STEP or CUBICSPLINE");
    change("/channels/0/sampler", 1, ".channels[0].sampler: is 1, but there is 1 sampler");
    change("/channels/0/target/node", 5, ".channels[0].target.node: is 5, but there is 1 node");
    change("/channels/0/target", Json::object(), ".channels[0].target.path: is absent, must be a string");
    change("/channels/0/target/path", 7, ".channels[0].target.path: is 7, must be a string");
    change("/samplers", 7, ".channels[0].sampler: is 0, but there are 0 samplers");
    GltfDocument rotated = document;
    rotated.json["animations"][0]["channels"][0]["target"]["path"] = "rotation";
    rotated.json["animations"][0]["samplers"][0]["output"] = wholes;
    EXPECT_EQ(LoadError(rotated), "scene.gltf: animations[0].samplers[0].output: " + named(wholes) +
                                      " must be VEC4 of float, normalized bytes or normalized shorts");
}

// Exporters write such files; the scene at rest is as it should be, and the animation says why it cannot be played.
TEST(ImportAnimation, UnusableKeysOfWhatIsShownAreADefectOfTheAnimation) {
    const auto defect = [](const char* path, const std::vector<float>& times,
                           const std::vector<float>& values, size_t components) {
        GltfDocument document = Moving();
        Json& animation = document.json["animations"][0];
        animation["samplers"].push_back({{"input", document.AddAccessor<float>(times, 1)},
                                         {"output", document.AddAccessor<float>(values, components)}});
        animation["channels"].insert(animation["channels"].begin(),
                                     Json{{"sampler", 1}, {"target", Target(path)}});
        animation["channels"][1]["target"]["path"] = "translation";
        const scene::SceneData scene = Load(document);
        EXPECT_EQ(scene.animations[0].channels.size(), 1u);
        EXPECT_EQ(scene.animations[0].samplers.size(), 1u);
        EXPECT_EQ(scene.animations[0].duration, 1.0f);
        const Error error = testing::ErrorOf([&] { PosedAt(scene, 1); });
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        EXPECT_EQ(error.what(), scene.animations[0].defect);
        EXPECT_EQ(scene.warnings,
                  std::vector{error.what() + std::string("; the animation cannot be played")});
        return scene.animations[0].defect;
    };
    const std::string at = "scene.gltf: animations[0].samplers[1].";
    EXPECT_EQ(defect("scale", {1, 1}, {1, 1, 1, 1, 1, 1}, 3),
              at + "input: accessors[4] element 1 is 1, not greater than the one before it");
    EXPECT_EQ(defect("scale", {-1, 9}, {1, 1, 1, 1, 1, 1}, 3),
              at + "input: accessors[4] element 0 is -1, a time must not be negative");
    EXPECT_EQ(defect("scale", {0, 1, 9}, {1, 1, 1, 1, 1, 1}, 3),
              at + "output: accessors[5] has 2 elements, must have 3 for 3 keys of LINEAR");
    EXPECT_EQ(defect("scale", {0}, {1, 1, 1, 1, 1, 1}, 3),
              at + "output: accessors[5] has 2 elements, must have 1 for 1 key of LINEAR");
    EXPECT_EQ(defect("rotation", {0, 9}, {0, 0, 0, 1, 0, 0, 0, 0}, 4),
              at + "output: key 1 is a quaternion of length 0");
}

// Weights are scalars, vectors are not: what one sampler is for one channel says nothing about another.
TEST(ImportAnimation, SharedSamplersAreCheckedForEachUse) {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    const size_t lifted = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    primitive["targets"] = {{{"POSITION", lifted}}, {{"POSITION", lifted}}, {{"POSITION", lifted}}};
    Animate(document, Target("weights"), {0}, {1, 2, 3}, 1);
    Json& channels = document.json["animations"][0]["channels"];
    channels.push_back({{"sampler", 0}, {"target", Target("translation")}});
    const std::string first = LoadError(document);
    EXPECT_NE(first.find("must be VEC3 of float"), std::string::npos) << first;
    std::swap(channels[0], channels[1]);
    EXPECT_EQ(LoadError(document), first);
}

// Samplers that no channel uses are checked as far as their accessors, and not decoded.
TEST(ImportAnimation, SamplersWithoutAChannelAreNotRead) {
    GltfDocument document = Moving();
    const size_t falling = document.AddAccessor<float>({1, 0}, 1);
    document.json["animations"][0]["samplers"].push_back({{"input", falling}, {"output", 0}});
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.animations[0].samplers.size(), 1u);
}

TEST(ImportAnimation, MemoryIsCharged) {
    GltfDocument document = Moving();
    const size_t many =
        document.Add("accessors", {{"componentType", kFloat}, {"count", 4000000000u}, {"type", "SCALAR"}});
    const size_t vectors =
        document.Add("accessors", {{"componentType", kFloat}, {"count", 4000000000u}, {"type", "VEC3"}});
    document.json["animations"][0]["samplers"][0] = {{"input", many}, {"output", vectors}};
    EXPECT_EQ(
        LoadError(document).find("scene.gltf: animations[0].samplers[0].input: decoded geometry exceeds the "
                                 "limit of "),
        0u)
        << LoadError(document);
}

}  // namespace
}  // namespace raygraph::test::import_animation_test

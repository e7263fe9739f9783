// A scene at one time: which clips a list names, and what freezing makes of nodes, skins and targets.
#include "renderer/scene/gltf/still_scene.h"

#include <gtest/gtest.h>

#include <array>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/check.h"
#include "tests/scene/motion_document.h"
#include "tests/scene/same_scene.h"
#include "tests/support/error_of.h"

namespace raygraph::test::still_scene_test {
namespace {

using glm::vec3;
using scene::ClipState;
using scene::kNone;
using scene::SceneData;
using testing::ErrorOf;

SceneData WithAnimations(const std::vector<std::string>& names) {
    SceneData scene;
    for (const std::string& name : names) scene.animations.emplace_back().name = name;
    return scene;
}

TEST(FindClips, NamesIndicesAndWeights) {
    const SceneData scene = WithAnimations({"walk", "run", "1", "look: left", "run", ""});
    const auto find = [&](std::string_view list) { return scene::FindClips(scene, list, 2.5); };
    using Clips = std::vector<ClipState>;
    EXPECT_EQ(find(""), (Clips{{0, 2.5, 1.0f}}));
    EXPECT_EQ(find("run"), (Clips{{1, 2.5, 1.0f}})) << "the first of that name";
    EXPECT_EQ(find("4"), (Clips{{4, 2.5, 1.0f}}));
    EXPECT_EQ(find("1"), (Clips{{2, 2.5, 1.0f}})) << "a name comes before an index";
    EXPECT_EQ(find("walk:0.25,3:2"), (Clips{{0, 2.5, 0.25f}, {3, 2.5, 2.0f}}));
    EXPECT_EQ(find("look: left"), (Clips{{3, 2.5, 1.0f}})) << "a colon of its name";
    EXPECT_EQ(find("look: left:0.5"), (Clips{{3, 2.5, 0.5f}}));
    EXPECT_EQ(find("all").size(), 6u);
    EXPECT_EQ(find("all")[5], (ClipState{5, 2.5, 1.0f}));
    EXPECT_TRUE(scene::FindClips(SceneData(), "", 1.0).empty());
}

TEST(FindClips, ReadsTheTextOfItsClips) {
    const SceneData scene = WithAnimations({"walk", "run", "run", "a, b", "all", "half:0.5", ""});
    const auto text = [&](const std::vector<ClipState>& clips) { return scene::ClipsText(scene, clips); };
    EXPECT_EQ(text({{0}, {1, 0, 0.25f}}), "walk,run:0.25");
    EXPECT_EQ(text({{2}}), "2") << "another one has the name before it";
    EXPECT_EQ(text({{0, 0, 0}, {1}}), "run");
    EXPECT_EQ(text({}), "");
    std::vector<ClipState> all;
    for (uint32_t i = 0; i < 7; ++i) {
        const std::vector<ClipState> one{{i, 2.5}};
        EXPECT_EQ(scene::FindClips(scene, text(one), 2.5), one) << text(one);
        all.push_back({i, 2.5});
    }
    EXPECT_EQ(text(all), "all");
    all[1].weight = 0.1f;
    EXPECT_EQ(scene::FindClips(scene, text(all), 2.5), all) << text(all);
}

TEST(FindClips, WhatIsNotThereIsRefusedWithWhatIs) {
    const SceneData scene = WithAnimations({"walk", "run"});
    for (const std::string_view list : {"fly", "2", "-1", "walk,,run", "walk:much", ",walk"}) {
        const Error error = testing::ErrorOf([&] { scene::FindClips(scene, list, 0.0); });
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput) << list;
        EXPECT_NE(std::string(error.what()).find("the scene has 0 \"walk\", 1 \"run\""), std::string::npos)
            << error.what();
    }
    EXPECT_EQ(std::string(testing::ErrorOf([&] { scene::FindClips(scene, "run:-1", 0.0); }).what()),
              "the weight of \"run:-1\" is not from 0 to 1e6");
    EXPECT_EQ(std::string(testing::ErrorOf([] { scene::FindClips(SceneData(), "walk", 0.0); }).what()),
              "there is no animation \"walk\"; the scene has none");
}

vec3 WorldPosition(const SceneData& scene, uint32_t instance, uint32_t vertex) {
    const scene::Instance& of = scene.instances[instance];
    return of.objectToWorld * glm::vec4(scene.meshes[of.mesh].primitives[0].positions[vertex], 1.0f);
}

TEST(FreezePose, SceneWithoutMotionStaysAsItIs) {
    GltfDocument document = SkinnedTriangle();
    document.json.erase("skins");
    document.json["nodes"][0].erase("skin");
    const SceneData before = Load(document);
    SceneData after = before;
    scene::FreezePose(after, {});
    ExpectSame(after, before);
}

TEST(FreezePose, SkinsCountInTheRestPoseAndAtATime) {
    GltfDocument document = SkinnedTriangle();
    document.json["nodes"][2]["translation"] = {1, 0, 2};
    Animate(document, {{"node", 2}, {"path", "translation"}}, {0, 1}, {1, 0, 2, 1, 0, 4}, 3);
    for (const bool isRest : {true, false}) {
        SceneData scene = Load(document);
        std::vector<ClipState> clips;
        if (!isRest) clips.push_back({.animation = 0, .seconds = 0.5});
        scene::FreezePose(scene, clips);
        EXPECT_NO_THROW(scene::Check(scene, "frozen"));
        const float z = isRest ? 2.0f : 3.0f;
        EXPECT_EQ(WorldPosition(scene, 0, 0), vec3(0, 0, 0));
        EXPECT_EQ(WorldPosition(scene, 0, 1), vec3(1, 0, z));
        EXPECT_EQ(WorldPosition(scene, 0, 2), vec3(0, 1, 0.5f * z));
        EXPECT_EQ(scene.bounds.max, vec3(1, 1, z));
        EXPECT_EQ(scene.nodes[2].translation, vec3(1, 0, z));
        EXPECT_TRUE(scene.skins.empty());
        EXPECT_TRUE(scene.animations.empty());
    }
}

// The mesh's node is rotated, scaled and 10,000 km away; the vertices stay where the joints put them, and
// then follow the node.
TEST(FreezePose, SkinnedMeshFollowsItsNodeFromThenOn) {
    GltfDocument document = SkinnedTriangle();
    document.json["nodes"][0]["translation"] = {1e7, 2, 3};
    document.json["nodes"][0]["rotation"] = {0.5, 0.5, 0.5, 0.5};
    document.json["nodes"][0]["scale"] = {2, 4, 8};
    SceneData scene = Load(document);
    scene::FreezePose(scene, {});
    scene::UpdateWorldTransforms(scene);
    EXPECT_LT(glm::distance(WorldPosition(scene, 0, 2), vec3(0, 1, 0)), 2.0f) << "a float's step there";
    scene.nodes[0].translation = {2, 2, 3};
    scene::UpdateWorldTransforms(scene);
    const vec3 moved = WorldPosition(scene, 0, 1) - WorldPosition(scene, 0, 0);
    EXPECT_LT(glm::distance(moved, vec3(1, 0, 0)), 1e-5f);
}

// A triangle with a target that lifts it by 1 m, three times 10 m apart: with weights .5, .5 and 2.
SceneData Lifted() {
    SceneData scene;
    scene.nodes.resize(3);
    scene::Primitive triangle;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.normals.assign(3, {0, 0, 1});
    triangle.indices = {0, 1, 2};
    triangle.bounds = scene::BoundsOf(triangle.positions);
    triangle.targets.resize(1);
    triangle.targets[0].positions.assign(3, {0, 0, 1});
    scene::UpdateDeformationBounds(triangle);
    scene.meshes.push_back({.name = "lifted", .primitives = {triangle}, .weights = {0.5f}});
    scene.materials.resize(1);
    for (uint32_t i = 0; i < 3; ++i) {
        scene.nodes[i].translation.x = 10.0f * float(i);
        scene.nodes[i].mesh = 0;
        scene.nodeOrder.push_back(i);
        scene.instances.push_back({.mesh = 0, .node = i});
    }
    scene.nodes[2].weights = {2.0f};
    scene::UpdateWorldTransforms(scene);
    return scene;
}

TEST(FreezePose, InstancesOfOneShapeShareItsMesh) {
    SceneData scene = Lifted();
    scene::FreezePose(scene, {});
    EXPECT_NO_THROW(scene::Check(scene, "frozen"));
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.instances[0].mesh, 0u);
    EXPECT_EQ(scene.instances[1].mesh, 0u);
    EXPECT_EQ(scene.instances[2].mesh, 1u);
    EXPECT_EQ(scene.meshes[1].name, "lifted");
    EXPECT_EQ(WorldPosition(scene, 1, 0), vec3(10, 0, 0.5f));
    EXPECT_EQ(WorldPosition(scene, 2, 0), vec3(20, 0, 2));
    EXPECT_EQ(scene.meshes[1].primitives[0].bounds.max, vec3(1, 1, 2));
    EXPECT_EQ(scene.bounds.min, vec3(0, 0, 0.5f));
    EXPECT_EQ(scene.bounds.max, vec3(21, 1, 2));
    for (const scene::Mesh& mesh : scene.meshes) EXPECT_TRUE(mesh.primitives[0].targets.empty());
}

// A mesh with joints that one instance has no skin for is as it was there.
TEST(FreezePose, InstanceWithoutASkinKeepsTheBaseShape) {
    GltfDocument document = SkinnedTriangle();
    document.json["nodes"][2]["translation"] = {1, 0, 2};
    document.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 5, 0}}});
    document.json["scenes"][0]["nodes"].push_back(document.json["nodes"].size() - 1);
    SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 2u);
    scene::FreezePose(scene, {});
    EXPECT_NO_THROW(scene::Check(scene, "frozen"));
    const uint32_t plain = scene.instances[0].node == 0 ? 1 : 0;
    EXPECT_EQ(WorldPosition(scene, plain, 1), vec3(1, 5, 0));
    EXPECT_EQ(WorldPosition(scene, 1 - plain, 1), vec3(1, 0, 2));
}

TEST(FreezePose, InstancesOfOneMeshWithOtherSkins_AreBentByTheirOwn) {
    GltfDocument document = SkinnedTriangle();
    Json skin = document.json["skins"][0];
    skin["joints"] = {1, 3};
    document.Add("skins", std::move(skin));
    document.AddNode({{"translation", {1, 0, 4}}});
    document.AddNode({{"mesh", 0}, {"skin", 1}});
    document.json["nodes"][2]["translation"] = {1, 0, 2};
    SceneData scene = Load(document);
    scene::FreezePose(scene, {});
    ASSERT_EQ(scene.meshes.size(), 2u);
    for (const uint32_t i : {0u, 1u})
        EXPECT_EQ(WorldPosition(scene, i, 1), vec3(1, 0, scene.instances[i].node == 0 ? 2 : 4));
}

TEST(FreezePose, CopiesOfMeshesAreLimited) {
    SceneData scene = Lifted();
    const uint64_t streams = 3 * (2 * sizeof(vec3) + sizeof(uint32_t));
    const uint64_t copy = sizeof(scene::Mesh) + sizeof(scene::Primitive) + streams;
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::FreezePose(scene, {}, copy - 1); }, ErrorKind::BadInput),
              "meshes[0] \"lifted\": deformed copies of meshes take more than " + std::to_string(copy - 1) +
                  " bytes");
    scene = Lifted();
    scene::FreezePose(scene, {}, copy);
    EXPECT_EQ(scene.meshes.size(), 2u);
}

// A host's mesh may have spheres beside what is morphed.
TEST(FreezePose, WhatNothingDeformsKeepsItsBox) {
    SceneData scene = Lifted();
    scene::Primitive sphere;
    sphere.positions = {{0, 0, 0}};
    sphere.indices = {0, 0};
    sphere.radii = {2};
    sphere.bounds = {vec3(-2.5f), vec3(2.5f)};
    scene.meshes[0].primitives.push_back(sphere);
    scene::Check(scene, "before");
    scene::FreezePose(scene, {});
    EXPECT_NO_THROW(scene::Check(scene, "frozen"));
    for (const scene::Mesh& mesh : scene.meshes) {
        EXPECT_EQ(mesh.primitives[1].bounds.max, vec3(2.5f));
        EXPECT_EQ(mesh.primitives[1].positions, sphere.positions);
    }
}

TEST(FreezePose, CollapsedInstancesAreLeftOut) {
    GltfDocument document;
    document.AddTriangle();
    Animate(document, {{"node", 0}, {"path", "scale"}}, {0, 1}, {0, 0, 0, 2, 2, 2}, 3);
    for (const double seconds : {0.0, 1.0}) {
        SceneData scene = Load(document);
        scene::FreezePose(scene, std::array{ClipState{0, seconds}});
        EXPECT_NO_THROW(scene::Check(scene, "frozen"));
        EXPECT_EQ(scene.instances.size(), seconds > 0.0 ? 1u : 0u);
    }
}

// The node is flat, so that the mesh cannot follow it, and hidden: without the node it would be seen.
TEST(FreezePose, HiddenInstancesOfFlatNodesStayUnseen) {
    GltfDocument document = SkinnedTriangle();
    document.json["nodes"][0]["scale"] = {1, 0, 1};
    SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 1u);
    scene.nodes[0].isVisible = false;
    SceneData shown = scene;
    scene::FreezePose(scene, {});
    EXPECT_TRUE(scene.instances.empty());
    shown.nodes[0].isVisible = true;
    scene::FreezePose(shown, {});
    ASSERT_EQ(shown.instances.size(), 1u);
    EXPECT_EQ(shown.instances[0].node, kNone);
}

TEST(FreezePose, VerticesThatAreNotFiniteAreNotShown) {
    SceneData scene = Lifted();
    scene.nodes[2].weights = {3e38f};
    scene.meshes[0].primitives[0].targets[0].positions.assign(3, {0, 0, 10});
    scene::UpdateDeformationBounds(scene.meshes[0].primitives[0]);
    scene::FreezePose(scene, {});
    EXPECT_NO_THROW(scene::Check(scene, "frozen"));
    EXPECT_EQ(scene.instances.size(), 2u);
}

}  // namespace
}  // namespace raygraph::test::still_scene_test

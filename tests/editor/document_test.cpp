// Tests edits of the open scene, and their history.
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "editor/app/document.h"
#include "editor/app/hierarchy.h"
#include "editor/app/inspector_fields.h"
#include "editor/app/mesh_facts.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/editor/moving_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::editor::document_test {

namespace {

class DocumentTest : public testing::VulkanTest {
  protected:
    DocumentTest() {
        scene::SceneData data = scene::LoadGltf(test::SourceFile("scenes/cornell.gltf"));
        document = Document("cornell.gltf", data);
        gpu.SetScene(std::move(data));
    }

    // instance that a node with a mesh places
    uint32_t instance = 0;
    uint32_t Node() const { return document.Scene().instances[instance].node; }
    scene::Material Red() const {
        scene::Material material = document.Scene().materials[0];
        material.baseColorFactor = {1, 0, 0, 1};
        return material;
    }

    Renderer renderer{Device()};
    GpuScene gpu{renderer};
    Document document;
};

// Makes a mesh that no instance places.
scene::SceneData OneTriangle() {
    scene::SceneData data;
    data.materials.resize(1);
    data.meshes.resize(1);
    scene::Primitive& triangle = data.meshes[0].primitives.emplace_back();
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.normals.assign(3, {0, 0, 1});
    triangle.indices = {0, 1, 2};
    triangle.bounds = scene::BoundsOf(triangle.positions);
    return data;
}

const glm::mat4x3 kUp{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 5, 0}};

}  // namespace

TEST_F(DocumentTest, KnowsTheHierarchyWithoutVertices) {
    EXPECT_FALSE(document.Roots().empty());
    EXPECT_GT(document.Statistics().placedTriangles, 0u);
    for (const scene::Mesh& mesh : document.Scene().meshes)
        for (const scene::Primitive& primitive : mesh.primitives) EXPECT_TRUE(primitive.positions.empty());
    EXPECT_FALSE(document.BoundsOf(Node()).IsEmpty());
}

TEST_F(DocumentTest, TransformMovesInstanceAndBoundsAndIsUndone) {
    const glm::mat4x3 before = gpu.Transform(instance).matrix;
    const scene::Bounds bounds = document.Scene().bounds;
    document.Apply(TransformEdit{Node(), kUp}, gpu);
    EXPECT_NE(gpu.Transform(instance).matrix, before);
    EXPECT_EQ(gpu.Transform(instance).matrix, document.Scene().instances[instance].objectToWorld);
    EXPECT_GT(document.Scene().bounds.max.y, bounds.max.y);
    document.Undo(gpu);
    EXPECT_EQ(gpu.Transform(instance).matrix, before);
    EXPECT_EQ(document.Scene().bounds.max, bounds.max);
    document.Redo(gpu);
    EXPECT_NE(gpu.Transform(instance).matrix, before);
}

TEST_F(DocumentTest, TransformMovesAllBelowAndNothingElse) {
    // Nodes 0 -> 1 -> 2, and 3 beside them; a light and a camera below
    scene::SceneData data = OneTriangle();
    data.nodes.resize(4);
    data.nodes[1].parent = 0;
    data.nodes[2].parent = 1;
    data.nodes[2].scale = glm::vec3(2.0f);
    data.nodeOrder = {3, 0, 1, 2};
    data.instances = {{0, 3, glm::mat4x3(1.0f)}, {0, 1, glm::mat4x3(1.0f)}, {0, 2, glm::mat4x3(1.0f)}};
    data.lights = {scene::Light{.name = "bulb", .node = 2}};
    data.cameras = {scene::Camera{.name = "eye", .node = 1}};
    scene::UpdateWorldTransforms(data);
    scene::SceneData expected = data;
    Document moved("", data);
    gpu.SetScene(std::move(data));
    EXPECT_EQ(moved.InstancesUnder(0), (std::vector<uint32_t>{1, 2}));
    EXPECT_EQ(moved.InstancesUnder(2), (std::vector<uint32_t>{2}));
    moved.Apply(TransformEdit{0, kUp}, gpu);
    moved.Apply(TransformEdit{1, kUp}, gpu);
    expected.nodes[0].matrix = expected.nodes[1].matrix = kUp;
    scene::UpdateWorldTransforms(expected);
    for (uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(moved.Scene().instances[i].objectToWorld, expected.instances[i].objectToWorld) << i;
        EXPECT_EQ(gpu.Transform(i).matrix, expected.instances[i].objectToWorld) << i;
    }
    EXPECT_EQ(moved.Scene().lights[0], expected.lights[0]);
    EXPECT_EQ(gpu.Light(0), expected.lights[0]);
    EXPECT_EQ(moved.Scene().cameras[0].cameraToWorld, expected.cameras[0].cameraToWorld);
    EXPECT_EQ(moved.Scene().bounds.min, expected.bounds.min);
    EXPECT_EQ(moved.Scene().bounds.max, expected.bounds.max);
}

TEST_F(DocumentTest, TransformMovesAllInstancesOfTheNode) {
    scene::SceneData data = OneTriangle();
    data.nodes.resize(2);
    data.nodeOrder = {0, 1};
    const glm::mat4x3 turned{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {3, 0, 0}};
    data.instances = {{.node = 0}, {.node = 1, .objectToNode = turned}, {.node = 1, .objectToNode = kUp}};
    scene::UpdateWorldTransforms(data);
    Document moved("", data);
    gpu.SetScene(scene::SceneData(data));
    EXPECT_EQ(moved.InstancesUnder(1), (std::vector<uint32_t>{1, 2}));
    moved.Apply(TransformEdit{1, kUp}, gpu);
    data.nodes[1].matrix = kUp;
    scene::UpdateWorldTransforms(data);
    EXPECT_EQ(data.instances[1].objectToWorld[3], glm::vec3(3, 5, 0));
    for (uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(moved.Scene().instances[i].objectToWorld, data.instances[i].objectToWorld) << i;
        EXPECT_EQ(gpu.Transform(i).matrix, data.instances[i].objectToWorld) << i;
    }
    EXPECT_EQ(moved.BoundsOf(1).max, data.bounds.max);
    moved.Undo(gpu);
    EXPECT_EQ(gpu.Transform(1).matrix, turned);
}

TEST_F(DocumentTest, VisibilityHidesAllBelowAndIsUndone) {
    scene::SceneData data = OneTriangle();
    data.nodes.resize(3);
    data.nodes[1].parent = 0;
    data.nodeOrder = {0, 1, 2};
    data.instances = {{.node = 1}, {.node = 2, .objectToWorld = kUp, .objectToNode = kUp}};
    data.lights = {scene::Light{.node = 1}};
    scene::UpdateWorldTransforms(data);
    Document edited("", data);
    gpu.SetScene(std::move(data));
    edited.Apply(VisibilityEdit{0, false}, gpu);
    EXPECT_FALSE(gpu.IsVisible(0));
    EXPECT_TRUE(gpu.IsVisible(1));
    EXPECT_FALSE(gpu.IsLightVisible(0));
    EXPECT_FALSE(edited.IsVisible(1));
    EXPECT_TRUE(edited.Scene().nodes[1].isVisible) << "its own";
    EXPECT_EQ(edited.Scene().bounds.min.y, 5.0f);
    edited.Settle();
    edited.Apply(VisibilityEdit{1, false}, gpu);
    edited.Apply(VisibilityEdit{0, true}, gpu);
    EXPECT_TRUE(edited.IsVisible(0));
    EXPECT_FALSE(gpu.IsVisible(0)) << "hidden itself";
    EXPECT_EQ(edited.EditCount(), 3u) << "another node is another step";
    for (int i = 0; i < 3; ++i) edited.Undo(gpu);
    EXPECT_TRUE(gpu.IsVisible(0));
    EXPECT_TRUE(gpu.IsLightVisible(0));
    EXPECT_EQ(edited.Scene().bounds.min.y, 0.0f);
}

TEST_F(DocumentTest, EachEditDoesTheSmallestWork) {
    const SceneRevisions before = gpu.Revisions();
    document.Apply(MaterialEdit{0, Red()}, gpu);
    EXPECT_EQ(gpu.Revisions().materials, before.materials + 1);
    EXPECT_EQ(gpu.Revisions().transforms, before.transforms);
    EXPECT_EQ(gpu.Revisions().geometry, before.geometry);
}

TEST_F(DocumentTest, EditsWithoutAPauseAreOneStep) {
    const glm::vec4 color = document.Scene().materials[0].baseColorFactor;
    for (const float red : {0.2f, 0.4f, 0.6f}) {
        scene::Material material = document.Scene().materials[0];
        material.baseColorFactor.x = red;
        document.Apply(MaterialEdit{0, material}, gpu);
    }
    EXPECT_EQ(document.EditCount(), 1u);
    document.Undo(gpu);
    EXPECT_EQ(document.Scene().materials[0].baseColorFactor, color);
}

TEST_F(DocumentTest, SettledAndOtherThingsAreStepsOfTheirOwn) {
    document.Apply(MaterialEdit{0, Red()}, gpu);
    document.Settle();
    document.Apply(MaterialEdit{0, Red()}, gpu);
    document.Apply(MaterialEdit{1, Red()}, gpu);
    document.Apply(TransformEdit{Node(), kUp}, gpu);
    EXPECT_EQ(document.EditCount(), 4u);
}

TEST_F(DocumentTest, NewEditForgetsWhatCouldBeRedone) {
    document.Apply(MaterialEdit{0, Red()}, gpu);
    document.Undo(gpu);
    EXPECT_TRUE(document.CanRedo());
    document.Apply(MaterialEdit{1, Red()}, gpu);
    EXPECT_FALSE(document.CanRedo());
    document.Undo(gpu);
    EXPECT_FALSE(document.CanUndo());
    document.Undo(gpu);  // does nothing
    EXPECT_EQ(document.EditCount(), 0u);
}

TEST_F(DocumentTest, RefusedEditChangesNothing) {
    const SceneRevisions before = gpu.Revisions();
    EXPECT_ANY_THROW(document.Apply(MaterialEdit{9999, Red()}, gpu));
    EXPECT_EQ(document.EditCount(), 0u);
    EXPECT_EQ(gpu.Revisions(), before);
}

TEST_F(DocumentTest, RefusedTransformChangesNothing) {
    const glm::mat4x3 before = gpu.Transform(instance).matrix;
    glm::mat4x3 endless = kUp;
    endless[3].x = std::numeric_limits<float>::infinity();
    EXPECT_THROW(document.Apply(TransformEdit{Node(), endless}, gpu), Error);
    EXPECT_EQ(gpu.Transform(instance).matrix, before);
    EXPECT_EQ(document.Scene().instances[instance].objectToWorld, before);
    EXPECT_FALSE(document.CanUndo());
}

TEST_F(DocumentTest, AMeshMayBeFlattenedAndNotToALine) {
    glm::mat4x3 flat = kUp;
    flat[1] = glm::vec3(0.0f);
    document.Apply(TransformEdit{Node(), flat}, gpu);
    EXPECT_TRUE(gpu.IsVisible(instance));
    EXPECT_EQ(gpu.Transform(instance).matrix, document.Scene().instances[instance].objectToWorld);
    EXPECT_EQ(document.LocalTransform(Node()), flat);
    glm::mat4x3 line = flat;
    line[0] = glm::vec3(0.0f);
    EXPECT_THROW(document.Apply(TransformEdit{Node(), line}, gpu), Error);
    EXPECT_EQ(document.LocalTransform(Node()), flat);
    document.Apply(TransformEdit{Node(), kUp}, gpu);
    EXPECT_EQ(gpu.Transform(instance).matrix, kUp);
}

TEST_F(DocumentTest, LightThatWouldBeFlatKeepsItsPlace) {
    scene::SceneData data;
    data.nodes.resize(1);
    data.nodeOrder = {0};
    data.lights = {scene::Light{.name = "bulb", .node = 0}};
    Document lit("", data);
    gpu.SetScene(std::move(data));
    glm::mat4x3 flat = kUp;
    flat[0] = glm::vec3(0.0f);
    EXPECT_THROW(lit.Apply(TransformEdit{0, flat}, gpu), Error);
    EXPECT_EQ(lit.Scene().lights[0], gpu.Light(0));
    EXPECT_FALSE(lit.CanUndo());
}

}  // namespace raygraph::editor::document_test

// Tests edits of an animated scene.
namespace raygraph::editor::pose_edit_test {

namespace {

class PoseEditTest : public testing::VulkanTest {
  protected:
    PoseEditTest() : file(folder.Write("scene.gltf", moving::Document().Text())) {
        scene::SceneData data = scene::LoadGltf(file);
        scene::DeformInstances(data);
        document = Document(file, data);
        gpu.SetScene(std::move(data));
    }
    bool Show(uint32_t clip, double seconds) {
        return document.ShowPose(std::array{scene::ClipState{clip, seconds}}, gpu);
    }
    void ShowRest() { document.ShowPose({}, gpu); }
    // Returns an edit that moves the node to a position, relative to the pose that is shown.
    TransformEdit MovedTo(uint32_t node, const glm::vec3& place) const {
        glm::mat4x3 local = document.LocalTransform(node);
        local[3] = place;
        return {node, local};
    }
    glm::vec3 PlaceOf(uint32_t node) const { return document.WorldTransform(node)[3]; }
    // Returns the position of the node's first instance on the device.
    glm::vec3 OnDevice(uint32_t node) const {
        return gpu.Transform(document.InstancesUnder(node).front()).matrix[3];
    }
    scene::SceneData Saved() {
        const std::filesystem::path copy = folder.Path() / "saved.gltf";
        document.Save(copy);
        return scene::LoadGltf(copy);
    }
    void ExpectRefused(const Edit& edit) {
        EXPECT_EQ(testing::ErrorTextOf([&] { document.Apply(edit, gpu); }, ErrorKind::Usage),
                  "an animation changes this: it can be edited in the rest pose");
    }

    test::SceneFolder folder;
    std::filesystem::path file;
    Renderer renderer{Device()};
    GpuScene gpu{renderer};
    Document document;
};

const glm::mat4x3 kTurned{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, 0}};

}  // namespace

TEST_F(PoseEditTest, PoseMovesNodesBoundsAndDeviceAndRestComesBackToTheBit) {
    const glm::vec3 before = PlaceOf(moving::Rider);
    const scene::Bounds bounds = document.Scene().bounds;
    const float right = document.BoundsOf(moving::Rider).max.x;
    EXPECT_TRUE(Show(moving::Slide, 0.5));
    EXPECT_EQ(PlaceOf(moving::Rider), glm::vec3(1, 1, 0));
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(1, 1, 0));
    EXPECT_EQ(document.BoundsOf(moving::Rider).max.x, right + 0.75f);
    EXPECT_GT(document.Scene().bounds.max.x, bounds.max.x);
    const SceneRevisions shown = gpu.Revisions();
    EXPECT_FALSE(Show(moving::Slide, 0.5)) << "it is shown already";
    EXPECT_EQ(gpu.Revisions(), shown);
    EXPECT_EQ(document.EditCount(), 0u);
    ShowRest();
    EXPECT_EQ(PlaceOf(moving::Rider), before);
    EXPECT_EQ(OnDevice(moving::Rider), before);
    EXPECT_EQ(document.Scene().bounds.max, bounds.max);
}

TEST_F(PoseEditTest, NodeBelowAnAnimatedOneIsEditedInAnyPose) {
    Show(moving::Slide, 0.5);
    document.Apply(MovedTo(moving::Rider, {0, 1, 3}), gpu);
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(1, 1, 3));
    Show(moving::Slide, 1.0);
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(2, 1, 3));
    const scene::SceneData saved = Saved();
    EXPECT_EQ(saved.nodes[moving::Rider].translation, glm::vec3(0, 1, 3));
    EXPECT_EQ(saved.nodes[moving::Slider].translation, glm::vec3(0.25f, 0, 0)) << "the pose is not saved";
    document.Undo(gpu);
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(2, 1, 0));
    document.Redo(gpu);
    ShowRest();
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(0.25f, 1, 3));
}

TEST_F(PoseEditTest, WhatAnAnimationShowsIsEditedInTheRestPoseOnly) {
    Show(moving::Slide, 0.5);
    const SceneRevisions before = gpu.Revisions();
    ExpectRefused(MovedTo(moving::Slider, {0, 0, 3}));
    EXPECT_EQ(gpu.Revisions(), before);
    EXPECT_FALSE(document.CanUndo());
    ShowRest();
    document.Apply(MovedTo(moving::Slider, {0.25f, 0, 3}), gpu);
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(0.25f, 1, 3));
    Show(moving::Slide, 0.5);
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(1, 1, 0));
    document.Undo(gpu);
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(1, 1, 0)) << "of the rest pose";
    document.Redo(gpu);
    EXPECT_EQ(Saved().nodes[moving::Slider].translation, glm::vec3(0.25f, 0, 3));
    document.Undo(gpu);
    ShowRest();
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(0.25f, 1, 0));
    Show(moving::Pan, 0.5);
    document.Apply(MovedTo(moving::Slider, {0, 0, 1}), gpu);  // no clip that is shown animates it
    EXPECT_EQ(OnDevice(moving::Rider), glm::vec3(0, 1, 1));
}

TEST_F(PoseEditTest, PartsThatNoAnimationChangesAreEditedBesideThoseThatOneDoes) {
    Show(moving::Slide, 0.5);
    glm::mat4x3 turned = kTurned;
    turned[3] = {1, 0, 0};
    document.Apply(TransformEdit{moving::Slider, turned}, gpu);
    EXPECT_LT(glm::length(PlaceOf(moving::Rider) - glm::vec3(0, 0, 0)), 1e-6f);
    document.Apply(TransformEdit{moving::Slider, turned}, gpu);
    EXPECT_EQ(document.EditCount(), 1u) << "as while a handle is held";
    const scene::SceneData saved = Saved();
    EXPECT_EQ(saved.nodes[moving::Slider].translation, glm::vec3(0.25f, 0, 0));
    EXPECT_NEAR(saved.nodes[moving::Slider].rotation.z, std::sqrt(0.5f), 1e-6f);
    EXPECT_FALSE(saved.nodes[moving::Slider].matrix) << "an animation would have no effect on it";
    // Even the smallest change is refused
    ExpectRefused(MovedTo(moving::Slider, {1.000001f, 0, 0}));
    EXPECT_EQ(document.Rest().nodes[moving::Slider].translation, glm::vec3(0.25f, 0, 0));
    glm::mat4x3 sheared = kTurned;
    sheared[0].x = 0.5f;
    EXPECT_ANY_THROW(document.Apply(TransformEdit{moving::Slider, sheared}, gpu));
    document.Undo(gpu);
    EXPECT_EQ(PlaceOf(moving::Rider), glm::vec3(1, 1, 0));
    EXPECT_EQ(document.Rest().nodes[moving::Slider].rotation, glm::quat(1, 0, 0, 0)) << "to the bit";
}

TEST_F(PoseEditTest, SavingInAPoseChangesNothingInTheFile) {
    document.Save(folder.Path() / "rest.gltf");
    document.ShowPose(std::array{scene::ClipState{moving::Slide, 0.7}, scene::ClipState{moving::Bend, 0.7},
                                 scene::ClipState{moving::Fade, 0.7}},
                      gpu);
    document.Save(folder.Path() / "posed.gltf");
    EXPECT_EQ(ReadFile(folder.Path() / "posed.gltf"), ReadFile(folder.Path() / "rest.gltf"));
    EXPECT_EQ(ReadFile(document.SaveRecoveryCopy()), ReadFile(folder.Path() / "rest.gltf"));
}

TEST_F(PoseEditTest, JointsThatAreMovedTakeTheMeshAlong) {
    const scene::Bounds before = document.BoundsOf(moving::Skinned);
    const SceneRevisions revisions = gpu.Revisions();
    document.Apply(MovedTo(moving::SecondJoint, {1, 0, 3}), gpu);
    EXPECT_EQ(document.BoundsOf(moving::Skinned).max.z, 3.0f);
    EXPECT_EQ(gpu.Revisions().shapes, revisions.shapes + 1);
    document.Undo(gpu);
    EXPECT_EQ(document.BoundsOf(moving::Skinned).max, before.max);
    // All joints are edited, and then the mesh as a whole
    document.Apply(MovedTo(moving::FirstJoint, {0, 0, 2}), gpu);
    EXPECT_EQ(OnDevice(moving::Skinned), glm::vec3(0, 0, 2));
    EXPECT_TRUE(document.IsPlacedBySkin(moving::Skinned));
    EXPECT_FALSE(document.IsPlacedBySkin(moving::Rider));
    EXPECT_FALSE(document.IsPlacedBySkin(moving::FirstJoint));
}

TEST_F(PoseEditTest, FieldsOfAMaterialThatAnAnimationLeavesAloneAreEdited) {
    Show(moving::Fade, 0.5);
    EXPECT_EQ(document.Scene().materials[0].baseColorFactor, glm::vec4(0.5f, 0, 0.5f, 1));
    scene::Material material = document.Scene().materials[0];
    material.roughnessFactor = 0.25f;
    document.Apply(MaterialEdit{0, material}, gpu);
    EXPECT_EQ(document.Scene().materials[0].roughnessFactor, 0.25f);
    EXPECT_EQ(document.Scene().materials[0].baseColorFactor, glm::vec4(0.5f, 0, 0.5f, 1));
    material.baseColorFactor = {0, 1, 0, 1};
    ExpectRefused(MaterialEdit{0, material});
    const scene::SceneData saved = Saved();
    EXPECT_EQ(saved.materials[0].roughnessFactor, 0.25f);
    EXPECT_EQ(saved.materials[0].baseColorFactor, glm::vec4(1, 0, 0, 1));
    document.Undo(gpu);
    ShowRest();
    EXPECT_EQ(document.Scene().materials[0].roughnessFactor, 1.0f);
    EXPECT_EQ(document.Scene().materials[0].baseColorFactor, glm::vec4(1, 0, 0, 1));
}

}  // namespace raygraph::editor::pose_edit_test

namespace raygraph::editor::placement_test {

namespace {

const glm::mat4x3 kSheared(glm::vec3(2, 0, 0), glm::vec3(0.6f, 1, 0), glm::vec3(0, 0.3f, 0.5f),
                           glm::vec3(1, 2, 3));

float Apart(const glm::mat4x3& a, const glm::mat4x3& b) {
    float most = 0.0f;
    for (int i = 0; i < 4; ++i) most = std::max(most, glm::length(a[i] - b[i]));
    return most;
}

}  // namespace

TEST(Placement, MoveLeavesTheAxesToTheBit) {
    const Placement before = PlacementOf(kSheared);
    Placement after = before;
    after.translation.y = 7.0f;
    glm::mat4x3 moved = kSheared;
    moved[3].y = 7.0f;
    EXPECT_EQ(Placed(kSheared, before, after), moved);
    EXPECT_EQ(Placed(kSheared, before, before), kSheared);
}

TEST(Placement, RotationTurnsAShearedNodeAsAWhole) {
    const Placement before = PlacementOf(kSheared);
    Placement after = before;
    after.degrees = {20.0f, -30.0f, 40.0f};
    const glm::mat4x3 turned = Placed(kSheared, before, after);
    // Lengths and angles of the axes are the shear
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(glm::dot(turned[i], turned[k]), glm::dot(kSheared[i], kSheared[k]), 1e-5f);
    const Placement read = PlacementOf(turned);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(read.degrees[i], after.degrees[i], 1e-3f) << "what was typed";
    EXPECT_LT(Apart(Placed(turned, read, before), kSheared), 1e-5f) << "and back";
}

TEST(Placement, ScaleStretchesOneAxisAlone) {
    const Placement before = PlacementOf(kSheared);
    Placement after = before;
    after.scale.y *= 3.0f;
    glm::mat4x3 wanted = kSheared;
    wanted[1] *= 3.0f;
    EXPECT_LT(Apart(Placed(kSheared, before, after), wanted), 1e-6f);
    const Placement read = PlacementOf(wanted);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(read.degrees[i], before.degrees[i], 1e-3f);
}

TEST(Placement, MirroredAndFlatNodes) {
    const glm::mat4x3 mirrored(glm::scale(glm::mat4(1.0f), glm::vec3(-2.0f, 1.0f, 1.0f)));
    const Placement placed = PlacementOf(mirrored);
    EXPECT_EQ(placed.scale, glm::vec3(-2.0f, 1.0f, 1.0f));
    EXPECT_LT(glm::length(placed.degrees), 1e-4f);
    Placement after = placed;
    after.scale.x = 2.0f;
    EXPECT_LT(Apart(Placed(mirrored, placed, after), glm::mat4x3(glm::scale(glm::mat4(1.0f), {2, 1, 1}))),
              1e-6f);
    glm::mat4x3 flat(1.0f);
    flat[2] = glm::vec3(0.0f);
    const Placement of = PlacementOf(flat);
    after = of;
    after.scale.z = 2.0f;
    EXPECT_LT(glm::length(Placed(flat, of, after)[2] - glm::vec3(0, 0, 2)), 1e-5f);
}

}  // namespace raygraph::editor::placement_test

// Tests the rows of the hierarchy.
namespace raygraph::editor::hierarchy_test {

namespace {

std::string RowsOf(const Hierarchy& hierarchy) {
    std::string rows;
    for (const Hierarchy::Row& row : hierarchy.Rows())
        rows += std::string(row.depth, '-') + std::to_string(row.node) + ' ';
    return rows;
}

}  // namespace

TEST(Hierarchy, ShowsWhatIsOpen) {
    Hierarchy hierarchy({{2, 3}, {}, {4}, {}, {}}, {0, 1});
    EXPECT_EQ(RowsOf(hierarchy), "0 1 ");
    hierarchy.SetOpen(0, true);
    EXPECT_EQ(RowsOf(hierarchy), "0 -2 -3 1 ");
    hierarchy.SetOpen(2, true);
    EXPECT_EQ(RowsOf(hierarchy), "0 -2 --4 -3 1 ");
    hierarchy.SetOpen(0, false);
    EXPECT_EQ(RowsOf(hierarchy), "0 1 ");
    EXPECT_EQ(hierarchy.Reveal(4), 2u) << "what was picked is shown";
    EXPECT_EQ(RowsOf(hierarchy), "0 -2 --4 -3 1 ");
}

TEST(Hierarchy, FilterListsMatchesWithTheirAncestors) {
    Hierarchy hierarchy({{2, 3}, {}, {4}, {}, {}}, {0, 1});
    hierarchy.SetFilter({false, false, false, false, true});
    EXPECT_EQ(RowsOf(hierarchy), "0 -2 --4 ");
    EXPECT_FALSE(hierarchy.HasRowsBelow(4));
    EXPECT_EQ(hierarchy.Reveal(3), 3u) << "it is not listed";
    hierarchy.EndFilter();
    EXPECT_EQ(RowsOf(hierarchy), "0 -2 -3 1 ") << "what was open before, and what was to be revealed";
    hierarchy.SetFilter(std::vector<bool>(5));
    EXPECT_EQ(RowsOf(hierarchy), "");
}

TEST(Hierarchy, OneRootIsOpenAndADeepChainNeedsNoStack) {
    std::vector<std::vector<uint32_t>> chain(200'000);
    for (uint32_t i = 0; i + 1 < chain.size(); ++i) chain[i] = {i + 1};
    Hierarchy hierarchy(chain, {0});
    EXPECT_EQ(RowsOf(hierarchy), "0 -1 ");
    EXPECT_EQ(hierarchy.Reveal(199'999), 199'999u);
    EXPECT_EQ(Hierarchy().Rows().size(), 0u);
}

}  // namespace raygraph::editor::hierarchy_test

// Tests how the inspector shows fields of materials and lights, and which values edits give them.
namespace raygraph::editor::inspector_fields_test {

using scene::FieldOf;
using scene::Light;
using scene::LightType;
using scene::Material;

namespace {

template <typename Field>
NumberStyle Style(float value, const Field& field) {
    return StyleOf(value, field.range, field.unit, field.ZeroIsInfinite());
}

}  // namespace

TEST(InspectorFields, LabelsAreWords) {
    EXPECT_EQ(LabelOf("baseColorFactor"), "base color");
    EXPECT_EQ(LabelOf("isDoubleSided"), "double sided");
    EXPECT_EQ(LabelOf("alphaMode"), "alpha");
}

TEST(InspectorFields, AreInGroupsOfWhichUnusedOnesAreClosed) {
    EXPECT_EQ(GroupOf("pbrMetallicRoughness", "metallicFactor"), "Base");
    EXPECT_EQ(GroupOf("", "emissiveFactor"), "Emission");
    EXPECT_EQ(GroupOf("KHR_materials_emissive_strength", "emissiveStrength"), "Emission");
    EXPECT_EQ(GroupOf("KHR_materials_ior", "ior"), "Specular");
    EXPECT_EQ(GroupOf("KHR_materials_diffuse_transmission", "diffuseTransmissionFactor"),
              "Diffuse transmission");
    scene::Material material;
    EXPECT_TRUE(IsUnused(material, "Sheen"));
    material.sheenColorFactor.y = 0.5f;
    EXPECT_FALSE(IsUnused(material, "Sheen"));
    EXPECT_TRUE(IsUnused(material, "Clearcoat"));
    material.clearcoatTexture.texture = 0;
    EXPECT_FALSE(IsUnused(material, "Clearcoat"));
}

TEST(InspectorFields, EachTextureSaysWhichChannelsAreRead) {
    scene::ForEachMaterialField([](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), scene::TextureRef Material::*>) {
            EXPECT_STRNE(ChannelsOf(field.name), "") << field.name;
        }
    });
    EXPECT_STREQ(ChannelsOf("metallicRoughnessTexture"), "GB");
}

TEST(MeshFacts, AreWhatTheMeshHas) {
    scene::Mesh mesh;
    mesh.weights = {0.0f, 0.5f};
    for (uint32_t material : {4u, 5u}) {
        scene::Primitive& triangle = mesh.primitives.emplace_back();
        triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}};
        triangle.normals.assign(3, {0, 0, 1});
        triangle.indices = {0, 1, 2, 2, 1, 0};
        triangle.material = material;
        triangle.bounds = scene::BoundsOf(triangle.positions);
    }
    mesh.primitives[1].uv0.resize(3);
    mesh.primitives[1].influences.perVertex = 4;
    EXPECT_EQ(LinesOf(FactsOf(mesh)),
              (std::vector<std::string>{"4 triangles, 6 vertices", "2 primitives, 2 materials",
                                        "POSITION, NORMAL, TEXCOORD_0, JOINTS, WEIGHTS", "1 x 2 x 0 m",
                                        "2 morph targets", "skinned"}));
}

TEST(InspectorFields, ColorsArePickedInSrgb) {
    const PickedColor gray = ToPicked(glm::vec3(0.21404114f));
    EXPECT_NEAR(gray.encoded.x, 0.5f, 1e-5f) << "IEC 61966-2-1";
    EXPECT_EQ(gray.brightness, 1.0f);
    for (const glm::vec3 linear : {glm::vec3(0.0f, 0.002f, 1.0f), glm::vec3(12.0f, 3.0f, 0.5f)}) {
        const glm::vec3 back = ToLinear(ToPicked(linear));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(back[c], linear[c], 1e-5f * (1.0f + linear[c]));
    }
    EXPECT_EQ(ToPicked(glm::vec3(12.0f, 3.0f, 0.5f)).brightness, 12.0f);
}

TEST(InspectorFields, ValuesReadBackFromTheClipboard) {
    const float color[] = {0.1f, 0.25f, 1e-7f};
    EXPECT_EQ(NumbersFrom(ValueText(color)), (std::vector<float>(std::begin(color), std::end(color))));
    EXPECT_EQ(NumbersFrom("[1, 0.5; 2]"), (std::vector<float>{1.0f, 0.5f, 2.0f}));
    for (const char* text : {"", "red", "1 2 three", "nan", "1e99"})
        EXPECT_TRUE(NumbersFrom(text).empty()) << text;
}

TEST(InspectorFields, SpecularColorMayBeAboveOne) {
    const auto range = FieldOf(&Material::specularColorFactor).range;
    EXPECT_EQ(Bounded(glm::vec3(1.0f), glm::vec3(2.5f, 1.0f, -1.0f), range), glm::vec3(2.5f, 1.0f, 0.0f));
}

TEST(InspectorFields, ColorsBesideAStrengthGoToOneAndKeepWhatAFileHas) {
    for (const scene::FieldRange& range :
         {FieldOf(&Material::emissiveFactor).range, FieldOf(&Light::color).range}) {
        EXPECT_EQ(Bounded(glm::vec3(0.5f), glm::vec3(2.5f, 1.0f, -1.0f), range), glm::vec3(1.0f, 1.0f, 0.0f));
        EXPECT_EQ(Bounded(glm::vec3(3.0f, 0.5f, 0.5f), glm::vec3(3.0f, 2.0f, 0.25f), range),
                  glm::vec3(3.0f, 1.0f, 0.25f));
    }
}

TEST(InspectorFields, SharesStayBelowOne) {
    const auto range = FieldOf(&Material::baseColorFactor).range;
    EXPECT_EQ(Bounded(glm::vec4(1.0f), glm::vec4(2.0f, 0.5f, -1.0f, 1.0f), range),
              glm::vec4(1.0f, 0.5f, 0.0f, 1.0f));
    EXPECT_TRUE(Style(0.5f, FieldOf(&Material::metallicFactor)).isSlider);
    EXPECT_FALSE(Style(0.0f, FieldOf(&Material::metallicFactor)).isInfinite);
}

// A number that scales a texture has an effect if the material has the texture, wherever glTF stores it.
TEST(InspectorFields, ScalesOfTexturesCountWhereTheTextureIs) {
    const auto counts = [](const Material& material, const auto& field) {
        return Counts(material, field.object, field.key, field.name);
    };
    const auto expectWith = [&](const auto& field, scene::TextureRef Material::*texture) {
        Material material;
        for (scene::TextureRef Material::*other :
             {&Material::normalTexture, &Material::occlusionTexture, &Material::clearcoatNormalTexture})
            if (other != texture) (material.*other).texture = 0;
        EXPECT_FALSE(counts(material, field)) << field.name;
        (material.*texture).texture = 0;
        EXPECT_TRUE(counts(material, field)) << field.name;
    };
    expectWith(FieldOf(&Material::normalScale), &Material::normalTexture);
    expectWith(FieldOf(&Material::occlusionStrength), &Material::occlusionTexture);
    expectWith(FieldOf(&Material::clearcoatNormalScale), &Material::clearcoatNormalTexture);
    EXPECT_TRUE(counts(Material(), FieldOf(&Material::clearcoatFactor)));
    EXPECT_TRUE(counts(Material(), FieldOf(&Material::baseColorFactor)));
    EXPECT_FALSE(counts(Material(), FieldOf(&Material::attenuationDistance)));
}

TEST(InspectorFields, InfinityIsShownAsAWordAndNotAsZero) {
    const auto expectInfinite = [](const auto& field, const char* finiteFormat) {
        const NumberStyle infinite = Style(0.0f, field);
        EXPECT_TRUE(infinite.isInfinite) << field.name;
        EXPECT_EQ(infinite.format, "infinite");
        const NumberStyle finite = Style(2.0f, field);
        EXPECT_FALSE(finite.isInfinite);
        EXPECT_EQ(finite.format, finiteFormat);
        EXPECT_GT(finite.min, 0.0f) << "dragging does not end there";
    };
    expectInfinite(FieldOf(&Material::ior), "%.3f");
    expectInfinite(FieldOf(&Material::attenuationDistance), "%.3f m");
    expectInfinite(FieldOf(&Light::range), "%.3f m");
    EXPECT_EQ(Style(1.5f, FieldOf(&Material::ior)).min, 1.0f);
    EXPECT_EQ(Style(0.0f, FieldOf(&Material::thicknessFactor)).format, "%.3f m") << "a zero that is one";
    EXPECT_EQ(Style(0.0f, FieldOf(&Light::intensity)).format, "%.3f cd");
}

TEST(InspectorFields, WhatIsInfiniteNoMoreHasAValueThatItMayHave) {
    EXPECT_EQ(FiniteValue(FieldOf(&Material::ior)), 1.5f);
    EXPECT_EQ(FiniteValue(FieldOf(&Material::attenuationDistance)), 1.0f);
    EXPECT_EQ(FiniteValue(FieldOf(&Light::range)), 1.0f);
}

TEST(InspectorFields, AnglesAreShownInDegrees) {
    const NumberStyle style = Style(0.5f, FieldOf(&Light::outerConeAngle));
    EXPECT_TRUE(style.isAngle);
    EXPECT_EQ(style.format, "%.1f deg");
}

TEST(InspectorFields, EachKindOfLightShowsWhatItHas) {
    const auto fieldsOf = [](LightType type) {
        std::vector<std::string> names;
        scene::ForEachLightField(type, [&](const auto& field) { names.push_back(field.name); });
        return names;
    };
    using Names = std::vector<std::string>;
    EXPECT_EQ(fieldsOf(LightType::Directional), (Names{"color", "intensity"}));
    EXPECT_EQ(fieldsOf(LightType::Point), (Names{"color", "intensity", "range"}));
    EXPECT_EQ(fieldsOf(LightType::Spot),
              (Names{"color", "intensity", "range", "innerConeAngle", "outerConeAngle"}));
}

}  // namespace raygraph::editor::inspector_fields_test

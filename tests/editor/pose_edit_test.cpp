// Tests edits of an animated scene.
#include <array>

#include "base/files.h"
#include "editor/app/document.h"
#include "renderer/scene/animation/deform.h"
#include "tests/editor/moving_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

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

// GpuScene::SetPose: everything that an applier changes arrives, and poses that it allows are taken.
#include <limits>

#include "renderer/scene/model/light_fields.h"
#include "renderer/scene/model/material_fields.h"
#include "tests/passes/deform_fixture.h"
#include "tests/support/error_of.h"

namespace raygraph::testing::deform_pose_test {

namespace {

using scene::AnimatedProperty;

// Values from `from` at 0 s to `to` at 1 s.
void Animate(scene::Animation& clip, const scene::AnimationTarget& target, std::vector<float> from,
             const std::vector<float>& to) {
    scene::AnimationSampler sampler{.width = uint32_t(to.size()), .times = {0, 1}, .values = std::move(from)};
    sampler.values.insert(sampler.values.end(), to.begin(), to.end());
    if (target.property == AnimatedProperty::Visibility) sampler.interpolation = scene::Interpolation::Step;
    clip.samplers.push_back(sampler);
    clip.channels.push_back({uint32_t(clip.samplers.size() - 1), target});
    clip.duration = 1.0f;
}

uint8_t BaseColor() {
    uint8_t index = 0, found = 255;
    scene::ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), glm::vec4 scene::Material::*>)
            if (field.member == &scene::Material::baseColorFactor) found = index;
        ++index;
    });
    return found;
}

// The sheet; a quad on node 5, which moves; one on node 6, which is hidden later, with a light, as is what is
// in node 7: another light, which moves and changes its color.
scene::SceneData SceneOfEverything() {
    scene::SceneData scene = SheetScene({.influences = 2, .targets = 1});
    scene.meshes.push_back(QuadMesh(0.5f, 1));
    scene.materials.push_back(Lambert(glm::vec3(0.2f)));
    scene.nodes.resize(8);
    for (const uint32_t node : {5u, 6u}) {
        scene.nodes[node].mesh = 1;
        scene.nodes[node].translation = {node == 5 ? 1.5f : -1.5f, 1, 0};
        scene.instances.push_back({.mesh = 1, .node = node});
    }
    for (const uint32_t node : {6u, 7u}) {
        scene::Light& light = scene.lights.emplace_back();
        light.node = node;
        light.intensity = 5.0f;
    }
    for (uint32_t node = 5; node < 8; ++node) scene.nodeOrder.push_back(node);
    scene::Animation& clip = scene.animations[0];
    Animate(clip, {.property = AnimatedProperty::Translation, .object = 5}, {1.5f, 1, 0}, {1.5f, 3, 0});
    Animate(clip, {.property = AnimatedProperty::Visibility, .object = 6}, {1}, {0});
    Animate(clip, {.property = AnimatedProperty::MaterialField, .field = BaseColor(), .object = 1},
            {0.2f, 0.2f, 0.2f, 1}, {0.9f, 0.1f, 0.2f, 1});
    Animate(clip, {.property = AnimatedProperty::LightField, .field = 0, .object = 1}, {1, 1, 1},
            {0.5f, 0.25f, 0});
    Animate(clip, {.property = AnimatedProperty::Translation, .object = 7}, {0, 0, 0}, {0, 2, 3});
    scene::DeformInstances(scene);
    return scene;
}

// Nodes 0 and 1 together scale by 1e60 at the end of clip 1: no matrix holds that.
void AnimateBeyondNumbers(scene::SceneData& scene, uint32_t node) {
    scene::Animation& clip = scene.animations.emplace_back();
    for (const uint32_t scaled : {node, node + 1})
        Animate(clip, {.property = AnimatedProperty::Scale, .object = scaled}, {1, 1, 1},
                {1e30f, 1e30f, 1e30f});
}

}  // namespace

TEST_F(DeformTest, EverythingThatAnApplierChangesArrives) {
    PosedScene posed(SceneOfEverything());
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    const SceneRevisions before = render.scene.Revisions();
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(1.0));
    EXPECT_EQ(render.scene.Transform(1).Place(), glm::dvec3(1.5, 3, 0));
    EXPECT_TRUE(render.scene.IsVisible(1));
    EXPECT_FALSE(render.scene.IsVisible(2));
    EXPECT_FALSE(render.scene.IsLightVisible(0));
    EXPECT_TRUE(render.scene.IsLightVisible(1));
    EXPECT_EQ(render.scene.Light(1).color, glm::vec3(0.5f, 0.25f, 0));
    EXPECT_EQ(render.scene.Light(1).lightToWorld[3], glm::vec3(0, 2, 3));
    EXPECT_EQ(render.scene.Revisions().transforms, before.transforms + 1);
    EXPECT_EQ(render.scene.Revisions().geometry, before.geometry + 1);
    EXPECT_EQ(render.scene.Revisions().materials, before.materials + 1);
    EXPECT_EQ(render.scene.Revisions().lights, before.lights + 2);
    EXPECT_EQ(render.scene.Revisions().shapes, before.shapes + 2) << "joints and weights";
    const SceneRender::Hits hits = render.PrimaryHits(Front());
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    still.scene.SetVisible(2, false);
    const SceneRender::Hits expected = still.PrimaryHits(Front());
    ExpectSameHits(hits, expected, 2);
    size_t colored = 0;
    for (size_t i = 0; i < hits.ids.size(); ++i) {
        if (hits.ids[i].x != 1 || expected.ids[i].x != 1) continue;
        ++colored;
        ASSERT_EQ(hits.albedo.values[i], expected.albedo.values[i]);
    }
    EXPECT_GT(colored, 10u);
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.0));
    EXPECT_TRUE(render.scene.IsVisible(2));
    EXPECT_TRUE(render.scene.IsLightVisible(0));
}

// After changes that were lost, as those are that come after the one with an Error.
TEST_F(DeformTest, AWholePoseBringsBackWhatWasLost) {
    PosedScene posed(SceneOfEverything());
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    render.PrimaryHits(Front());
    posed.MoveTo(1.0);
    posed.applier.Refresh(posed.scene);
    render.scene.SetPose(posed.scene, posed.applier);
    EXPECT_EQ(render.scene.Transform(1).Place(), glm::dvec3(1.5, 3, 0));
    EXPECT_FALSE(render.scene.IsVisible(2));
    EXPECT_FALSE(render.scene.IsLightVisible(0));
    EXPECT_EQ(render.scene.Light(1).color, glm::vec3(0.5f, 0.25f, 0));
    EXPECT_EQ(render.scene.Light(1).lightToWorld[3], glm::vec3(0, 2, 3));
    const SceneRender::Hits hits = render.PrimaryHits(Front());
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    still.scene.SetVisible(2, false);
    ExpectSameHits(hits, still.PrimaryHits(Front()), 2);
    const SceneRevisions revisions = render.scene.Revisions();
    render.scene.SetPose(posed.scene, posed.applier);
    EXPECT_EQ(render.scene.Revisions(), revisions) << "it has all of it";
}

// The applier hides such an instance. What else has changed arrives, and so does the instance later.
TEST_F(DeformTest, PosesBeyondTheNumbersAreTakenAndHidden) {
    scene::SceneData scene = SheetScene({.influences = 2});
    AnimateBeyondNumbers(scene, 0);
    scene.nodes.resize(7);
    scene.nodes[5].translation = {1.5f, 0, 0};
    scene.nodes[6].mesh = 0;
    scene.nodes[6].skin = 1;
    scene.nodeOrder.insert(scene.nodeOrder.end(), {5, 6});
    scene.skins.push_back(scene.skins[0]);
    for (uint32_t& joint : scene.skins[1].joints) joint = 5;
    for (glm::mat4x3& bind : scene.skins[1].inverseBinds) bind = glm::mat4x3(1.0f);
    scene.instances.push_back({.mesh = 0, .node = 6});
    Animate(scene.animations[1], {.property = AnimatedProperty::Scale, .object = 5}, {1, 1, 1}, {1, 0.5f, 1});
    scene::DeformInstances(scene);
    PosedScene posed(scene);
    render.scene.SetScene(std::move(scene));
    render.PrimaryHits(Front());
    for (const double seconds : {1.0, 0.99}) {
        const scene::PoseChanges& changes = posed.MoveTo(seconds, 1);
        EXPECT_EQ(changes.skins, (std::vector<uint32_t>{0, 1}));
        ASSERT_NO_THROW(render.scene.SetPose(posed.scene, posed.applier, changes));
        EXPECT_FALSE(render.scene.IsVisible(0));
        EXPECT_TRUE(render.scene.IsVisible(1));
        const std::vector<scene::DeformedStreams> actual = {
            OnDevice({{posed.Streams(0)}, {posed.Streams(1)}})[1][0]};
        ExpectNear(actual[0], posed.Streams(1));
    }
    posed.MoveTo(0.0, 1);
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.5));
    EXPECT_FALSE(render.scene.IsVisible(0)) << "that it is shown again was in the changes before";
    render.scene.SetPose(posed.scene, posed.applier);
    EXPECT_TRUE(render.scene.IsVisible(0));
    ExpectNear(OnDevice({{posed.Streams(0)}, {posed.Streams(1)}})[0][0], posed.Streams(0));
}

// The applier hides what they move; a host may show it all the same.
TEST_F(DeformTest, JointsBeyondTheNumbersDoNotKeepAnEarlierPose) {
    std::vector<std::vector<glm::vec3>> positions;
    for (const double before : {0.2, 0.9}) {
        scene::SceneData scene = SheetScene({.influences = 2});
        AnimateBeyondNumbers(scene, 0);
        PosedScene posed(scene);
        render.scene.SetScene(std::move(scene));
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(before));
        render.PrimaryHits(Front());
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(1.0, 1));
        EXPECT_FALSE(render.scene.IsVisible(0));
        render.scene.SetVisible(0, true);
        positions.push_back(OnDevice(posed.Streams()).positions);
    }
    EXPECT_EQ(positions[0], positions[1]);
}

// A joint that moves no vertex may go where it likes.
TEST_F(DeformTest, AJointThatMovesNothingDoesNotStopTheOthers) {
    scene::SceneData scene = SheetScene({.influences = 2});
    scene.nodes.resize(7);
    scene.nodes[6].parent = 5;
    scene.nodeOrder.insert(scene.nodeOrder.end(), {5, 6});
    scene.skins[0].joints.push_back(6);
    scene.skins[0].inverseBinds.push_back(glm::mat4x3(1.0f));
    AnimateBeyondNumbers(scene, 5);
    std::swap(scene.animations[1], scene.animations[0]);
    for (const scene::AnimationChannel& channel : scene.animations[1].channels) {
        scene.animations[0].samplers.push_back(scene.animations[1].samplers[channel.sampler]);
        scene.animations[0].channels.push_back(
            {uint32_t(scene.animations[0].samplers.size() - 1), channel.target});
    }
    PosedScene posed(scene);
    render.scene.SetScene(std::move(scene));
    for (const double seconds : {0.6, 1.0, 0.3}) {
        SCOPED_TRACE(seconds);
        const scene::PoseChanges& changes = posed.MoveTo(seconds);
        ASSERT_NO_THROW(render.scene.SetPose(posed.scene, posed.applier, changes));
        EXPECT_TRUE(render.scene.IsVisible(0));
        ExpectNear(OnDevice(posed.Streams()), posed.Streams());
        const SceneRevisions revisions = render.scene.Revisions();
        render.scene.SetPose(posed.scene, posed.applier);
        EXPECT_EQ(render.scene.Revisions(), revisions) << "what is no number is no change, either";
    }
}

// The weights of a mesh without targets move nothing, though a clip may change them.
TEST_F(DeformTest, WeightsWithoutTargetsAreNoError) {
    scene::SceneData scene = SheetScene({.influences = 2});
    scene.meshes[0].weights = {0.0f};
    Animate(scene.animations[0], {.property = AnimatedProperty::Weights, .object = 4}, {0}, {1});
    PosedScene posed(scene);
    render.scene.SetScene(std::move(scene));
    const scene::PoseChanges& changes = posed.MoveTo(0.5);
    EXPECT_FALSE(changes.reweighted.empty());
    ASSERT_NO_THROW(render.scene.SetPose(posed.scene, posed.applier, changes));
    ASSERT_NO_THROW(render.scene.SetPose(posed.scene, posed.applier));
    ExpectNear(OnDevice(posed.Streams()), posed.Streams());
}

// A host that forgot DeformInstances, or sets Instance::isDeformed by itself: refused before anything moves.
TEST_F(DeformTest, PosesOfOtherInstancesThanTheDeformedOnesAreRefusedAsAWhole) {
    PosedScene posed(SceneOfEverything());
    const auto refused = [&](const std::vector<bool>& areDeformed) {
        scene::SceneData data = posed.scene;
        for (size_t i = 0; i < data.instances.size(); ++i) data.instances[i].isDeformed = areDeformed[i];
        render.scene.SetScene(std::move(data));
        const SceneRevisions before = render.scene.Revisions();
        const std::string text = ErrorTextOf(
            [&] { render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(1.0)); }, ErrorKind::Usage);
        EXPECT_EQ(render.scene.Revisions(), before);
        EXPECT_EQ(ErrorTextOf([&] { render.scene.SetPose(posed.scene, posed.applier); }, ErrorKind::Usage),
                  text);
        EXPECT_EQ(render.scene.Revisions(), before);
        posed.MoveTo(0.0);
        return text;
    };
    EXPECT_EQ(refused({false, false, false}), "GpuScene: SetPose: 1 skins, the scene has 0");
    scene::SceneData& scene = posed.scene;
    scene.skins.push_back(scene.skins[0]);
    scene.nodes[5].skin = 1;
    scene.nodes[5].mesh = scene.instances[1].mesh = 0;
    posed.applier.Refresh(scene);
    EXPECT_EQ(refused({true, false, false}), "GpuScene: SetPose: 4 matrices for skin 1, which has 0");
    scene.skins.clear();
    scene.nodes[4].skin = scene.nodes[5].skin = scene::kNone;
    scene.nodes[5].mesh = scene.instances[1].mesh = 1;
    scene.meshes[0].primitives[0].influences = {};
    posed.applier.Refresh(scene);
    EXPECT_EQ(refused({false, false, false}), "GpuScene: SetPose: instance 0 is not deformed");
    scene.nodes[5].mesh = scene.instances[1].mesh = 0;
    posed.applier.Refresh(scene);
    EXPECT_EQ(refused({false, true, false}), "GpuScene: SetPose: 1 weight for instance 0, which has 0");
}

}  // namespace raygraph::testing::deform_pose_test

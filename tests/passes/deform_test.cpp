#include <limits>
#include <tuple>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "shaders/shared/deform_records.h"
#include "tests/passes/deforming_scene.h"
#include "tests/passes/flat_nodes.h"
#include "tests/support/error_of.h"
#include "tests/support/vulkan_test.h"

// GpuScene: meshes that deform are where the CPU's formula has them, for every view.
namespace raygraph::testing::deform_test {

TEST_F(DeformTest, VerticesAreThoseOfTheFormula) {
    for (const SheetOptions& options : {SheetOptions{.influences = 2},
                                        {.influences = 7},
                                        {.influences = 0, .targets = 3},
                                        {.influences = 4, .targets = 2},
                                        {.influences = 3, .targets = 1, .isFlat = true}}) {
        SCOPED_TRACE(::testing::Message()
                     << options.influences << " influences, " << options.targets << " targets");
        ExpectFormula(options);
    }
}

TEST_F(DeformTest, RaysAndRasterSeeTheDeformedSurface) {
    PosedScene posed(SheetScene({.influences = 3, .targets = 1}));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    SceneRender still(Device());
    for (const double seconds : {0.0, 0.4, 0.8}) {
        SCOPED_TRACE(seconds);
        const scene::PoseChanges& changes = posed.MoveTo(seconds);
        render.scene.SetPose(posed.scene, posed.applier, changes);
        const SceneRender::Hits traced = render.PrimaryHits(Front());
        still.scene.SetScene(posed.Frozen());
        ExpectSameHits(traced, still.PrimaryHits(Front()), 2);
        ExpectSameHits(Drawn(Front()), traced, 20);
    }
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 1u);
    EXPECT_EQ(render.scene.Statistics().blasRefits + render.scene.Statistics().blasRebuilds, 2u);
}

// Each triangle is where another one was.
scene::SceneData ScrambledSheet(uint32_t step) {
    scene::SceneData scene = SheetScene({.influences = 0, .targets = 1});
    scene::Primitive& sheet = scene.meshes[0].primitives[0];
    scene::MorphTarget& target = sheet.targets[0];
    const size_t count = sheet.TriangleCount();
    for (size_t i = 0; i < count; ++i) {
        const size_t to = i * step % count;
        for (size_t k = 0; k < 3; ++k)
            target.positions[3 * i + k] = sheet.positions[3 * to + k] - sheet.positions[3 * i + k];
    }
    scene::UpdateDeformationBounds(sheet);
    return scene;
}

TEST_F(DeformTest, WhatRefitsHaveSpoiledIsRebuiltInPlace) {
    PosedScene posed(ScrambledSheet(37));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    render.PrimaryHits(Front());
    const auto show = [&](float weight) {
        posed.scene.nodes[4].weights = {weight};
        render.scene.SetMorphWeights(0, std::array{weight});
        return render.PrimaryHits(Front());
    };
    show(0.001f);
    EXPECT_EQ(render.scene.Statistics().blasRefits, 1u);
    EXPECT_EQ(render.scene.Statistics().blasRebuilds, 0u);
    const SceneRender::Hits scrambled = show(1.0f);
    EXPECT_EQ(render.scene.Statistics().blasRefits, 1u);
    EXPECT_EQ(render.scene.Statistics().blasRebuilds, 1u);
    EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::Update) << "the address is the same";
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    ExpectSameHits(scrambled, still.PrimaryHits(Front()), 2);
    show(0.999f);
    EXPECT_EQ(render.scene.Statistics().blasRebuilds, 1u) << "the tree fits since";
    show(0.0f);
    EXPECT_EQ(render.scene.Statistics().blasRebuilds, 2u);
}

TEST_F(DeformTest, WhatHasMovedIntoViewIsDrawn) {
    scene::SceneData scene = SheetScene({.influences = 0, .targets = 1});
    scene::Primitive& sheet = scene.meshes[0].primitives[0];
    for (glm::vec3& displacement : sheet.targets[0].positions) displacement = {30, 0, 0};
    scene::UpdateDeformationBounds(sheet);
    render.scene.SetScene(std::move(scene));
    const passes::TraceSettings there = LookAt({30, 2, 9}, {30, 2, 0}, 0.7f, 48);
    EXPECT_EQ(Drawn(there).ids[24 * 48 + 24].x, 0xFFFFFFFFu);
    render.scene.SetMorphWeights(0, std::array{1.0f});
    ExpectSameHits(Drawn(there), render.PrimaryHits(there), 20);
}

TEST_F(DeformTest, NothingIsDoneInAFrameWithoutAChange) {
    PosedScene posed(SheetScene({.influences = 2, .targets = 1}));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    render.PrimaryHits(Front());
    EXPECT_NE(render.renderer.DescribePlan().find("Deform"), std::string::npos);
    const auto expectNothing = [&] {
        const GpuSceneStatistics before = render.scene.Statistics();
        const SceneRevisions revisions = render.scene.Revisions();
        EXPECT_TRUE(render.scene.IsSettled());
        render.PrimaryHits(Front());
        for (const char* pass :
             {" Deform ", "RefitBlas", "RefreshTlas", "UploadPoses", "UploadTlasInstances"})
            EXPECT_EQ(render.renderer.DescribePlan().find(pass), std::string::npos) << pass;
        EXPECT_EQ(render.scene.Statistics().deformations, before.deformations);
        EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::None);
        EXPECT_EQ(render.scene.Revisions(), revisions);
    };
    for (int frame = 0; frame < 8; ++frame) render.PrimaryHits(Front());  // past compaction
    expectNothing();
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.3));
    EXPECT_FALSE(render.scene.IsSettled());
    EXPECT_GT(render.scene.Revisions().shapes, 0u);
    render.PrimaryHits(Front());
    EXPECT_EQ(render.scene.Statistics().deformations, 2u);
    EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::Update);
    expectNothing();
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.3));
    render.scene.SetJointMatrices(0, posed.applier.JointMatricesOf(0));
    render.scene.SetMorphWeights(0, scene::MorphWeights(posed.scene, posed.scene.instances[0]));
    expectNothing();
}

TEST_F(DeformTest, WorkOfADroppedFrameStaysDue) {
    PosedScene posed(SheetScene({.influences = 2, .targets = 1}));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    const auto drop = [&] {
        render.renderer.BeginFrame();
        const SceneIds ids = render.Declare();
        const Readback radiance =
            render.renderer.ReadBack(passes::Trace(render.renderer, ids, Front()).radiance);
        render.renderer.AddPass(
            "Fails", PassKind::Transfer, [](PassBuilder& pass) { pass.KeepAlive(); },
            [](CommandList&) { throw std::runtime_error("the pass fails"); });
        EXPECT_THROW(render.renderer.Execute(), std::runtime_error);
    };
    drop();
    ExpectNear(OnDevice(posed.Streams()), posed.Streams());
    render.PrimaryHits(Front());
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.7));
    drop();
    EXPECT_EQ(render.scene.Statistics().blasRefits, 0u);
    const SceneRender::Hits traced = render.PrimaryHits(Front());
    EXPECT_EQ(render.scene.Statistics().blasRefits + render.scene.Statistics().blasRebuilds, 1u);
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    ExpectSameHits(traced, still.PrimaryHits(Front()), 2);
    ExpectNear(OnDevice(posed.Streams()), posed.Streams());
}

// A frame that reads the vertices alone, as raster views do, refits nothing; a later one does.
TEST_F(DeformTest, RefitsOfFramesThatTraceNothingStayDue) {
    PosedScene posed(SheetScene({.influences = 2}));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    render.PrimaryHits(Front());
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.7));
    const SceneRender::Hits drawn = Drawn(Front());
    EXPECT_EQ(render.scene.Statistics().blasRefits, 0u);
    ExpectSameHits(drawn, render.PrimaryHits(Front()), 20);
    EXPECT_EQ(render.scene.Statistics().blasRefits, 1u);
    EXPECT_EQ(render.scene.Statistics().deformations, 2u) << "not again for the refit";
}

TEST_F(DeformTest, ChangedSidesOfADeformedMeshAreBuiltWhereItIs) {
    scene::Material oneSided = Lambert(glm::vec3(0.5f));
    oneSided.isDoubleSided = false;
    PosedScene posed(SheetScene({.influences = 2}, oneSided));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.7));
    render.PrimaryHits(Front());
    scene::Material blended = oneSided;
    blended.alphaMode = scene::AlphaMode::Blend;
    blended.baseColorFactor.a = 0.999f;
    render.scene.SetMaterial(0, blended);
    posed.scene.materials[0] = blended;
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.9));
    const SceneRender::Hits hits = render.PrimaryHits(Front());
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 2u);
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    ExpectSameHits(hits, still.PrimaryHits(Front()), 20);
    ExpectSameHits(Drawn(Front()), hits, 40);
}

TEST_F(DeformTest, BrokenPosesAreRefusedAndChangeNothing) {
    PosedScene posed(SheetScene({.influences = 2, .targets = 1}));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    GpuScene& scene = render.scene;
    std::vector<glm::mat4x3> matrices(posed.applier.JointMatricesOf(0).begin(),
                                      posed.applier.JointMatricesOf(0).end());
    const SceneRevisions before = scene.Revisions();
    const auto message = [](auto&& call) { return ErrorTextOf(call, ErrorKind::Usage); };
    EXPECT_EQ(message([&] { scene.SetJointMatrices(1, matrices); }),
              "GpuScene: skin 1 does not exist; the scene has 1");
    EXPECT_EQ(message([&] { scene.SetJointMatrices(0, std::span(matrices).first(3)); }),
              "GpuScene: SetJointMatrices: 3 matrices for skin 0, which has 4");
    matrices[2][3].x = std::numeric_limits<float>::infinity();
    EXPECT_EQ(message([&] { scene.SetJointMatrices(0, matrices); }),
              "GpuScene: SetJointMatrices: skin 0 has numbers that are not finite");
    EXPECT_EQ(message([&] { scene.SetMorphWeights(1, std::array{1.0f}); }),
              "GpuScene: instance 1 does not exist; the scene has 1");
    EXPECT_EQ(message([&] {
                  scene.SetMorphWeights(0, std::array{1.0f, 2.0f});
              }),
              "GpuScene: SetMorphWeights: 2 weights for instance 0, which has 1");
    EXPECT_EQ(message([&] { scene.SetMorphWeights(0, std::array{std::nanf("")}); }),
              "GpuScene: SetMorphWeights: instance 0 has numbers that are not finite");
    scene::SceneData other = posed.scene;
    other.instances.push_back(other.instances[0]);
    EXPECT_EQ(message([&] { scene.SetPose(other, posed.applier, posed.MoveTo(0.5)); }),
              "GpuScene: SetPose: 2 instances, the scene has 1");
    EXPECT_EQ(scene.Revisions(), before);
    render.renderer.BeginFrame();
    std::ignore = scene.Declare(render.renderer);
    EXPECT_EQ(
        message([&] { scene.SetMorphWeights(0, std::array{1.0f}); }),
        "GpuScene: SetMorphWeights between Declare and Execute; it comes before Declare or after Execute");
    render.renderer.DropFrame();
    scene.SetScene(SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))}));
    EXPECT_EQ(message([&] { scene.SetMorphWeights(0, std::array{1.0f}); }),
              "GpuScene: SetMorphWeights: instance 0 is not deformed");
    EXPECT_EQ(message([&] { scene.SetJointMatrices(0, {}); }),
              "GpuScene: skin 0 does not exist; the scene has 0");
}

// An outline of the scene is all that a host has to keep.
TEST_F(DeformTest, PosesOfAnOutlineAreThoseOfTheScene) {
    PosedScene full(SheetScene({.influences = 2, .targets = 2}));
    PosedScene outline(scene::PoseOutline(full.scene));
    EXPECT_TRUE(outline.scene.meshes[0].primitives[0].positions.empty());
    scene::SceneData data = full.scene;
    render.scene.SetScene(std::move(data));
    full.MoveTo(0.4);
    render.scene.SetPose(outline.scene, outline.applier, outline.MoveTo(0.4));
    EXPECT_EQ(outline.scene.bounds.min, full.scene.bounds.min);
    EXPECT_EQ(outline.scene.bounds.max, full.scene.bounds.max);
    ExpectNear(OnDevice(full.Streams()), full.Streams());
}

}  // namespace raygraph::testing::deform_test

// GpuScene::SetPose: everything that an applier changes arrives, and poses that it allows are taken.
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

// GpuScene: deforming meshes of several primitives, large ones, mirrored ones and broken ones.
namespace raygraph::testing::deform_parts_test {

namespace {

scene::Primitive SheetAt(float x, const SheetOptions& options, uint32_t material) {
    scene::Primitive sheet = Sheet(options, material).primitives[0];
    sheet.bounds = {};
    for (glm::vec3& position : sheet.positions) {
        position.x = 0.3f * position.x + x;
        sheet.bounds.Extend(position);
    }
    scene::UpdateDeformationBounds(sheet);
    return sheet;
}

// One mesh, placed with two skins. Of its primitives three share a group with other influences each, one that
// no joint moves among them; one has a group of its own, and one a group that does not deform. Vertices are
// of odd numbers.
scene::SceneData SceneOfParts() {
    scene::SceneData scene = SheetScene({.influences = 2, .targets = 1});
    std::vector<scene::Primitive>& parts = scene.meshes[0].primitives;
    parts = {
        SheetAt(-0.8f, {.influences = 2, .targets = 1, .cells = {3, 5}}, 0),
        SheetAt(-0.4f, {.influences = 0, .cells = {1, 7}}, 0),
        SheetAt(0.0f, {.influences = 3, .targets = 1, .isFlat = true, .cells = {5, 3}}, 0),
        SheetAt(0.4f, {.influences = 5, .cells = {1, 9}}, 1),
        SheetAt(0.8f, {.influences = 0, .cells = {3, 3}}, 2),
    };
    parts[1].influences = {};
    scene::Material blended = Lambert(glm::vec3(0.9f)), oneSided = Lambert(glm::vec3(0.3f));
    blended.alphaMode = scene::AlphaMode::Blend;
    blended.baseColorFactor.a = 0.999f;
    oneSided.isDoubleSided = false;
    scene.materials.push_back(blended);
    scene.materials.push_back(oneSided);
    scene.nodes.resize(10);
    for (uint32_t joint = 5; joint < 9; ++joint) {
        scene.nodes[joint] = scene.nodes[joint - 5];
        if (joint > 5) scene.nodes[joint].parent = joint - 1;
    }
    scene.nodes[5].translation = {2.2f, 0.5f, 0};
    scene.nodes[9].mesh = 0;
    scene.nodes[9].skin = 1;
    for (uint32_t node = 5; node < 10; ++node) scene.nodeOrder.push_back(node);
    scene.skins.push_back(scene.skins[0]);
    for (uint32_t& joint : scene.skins[1].joints) joint += 5;
    scene.instances.push_back({.mesh = 0, .node = 9});
    scene::DeformInstances(scene);
    return scene;
}

}  // namespace

TEST_F(DeformTest, PartsOfGroupsAndCopiesAreDeformedEachByItsOwn) {
    PosedScene posed(SceneOfParts());
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    const passes::TraceSettings view = LookAt({1, 2.5f, 13}, {1, 2, 0}, 0.6f, 96);
    SceneRender still(Device());
    for (const double seconds : {0.0, 0.7}) {
        SCOPED_TRACE(seconds);
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(seconds));
        std::vector<Group> expected;
        for (const uint32_t instance : {0u, 1u})
            for (const std::vector<uint32_t>& parts : {std::vector{0u, 1u, 2u}, {3u}}) {
                Group& group = expected.emplace_back();
                for (const uint32_t part : parts) group.push_back(posed.Streams(instance, part));
            }
        const std::vector<Group> actual = OnDevice(expected);
        for (size_t group = 0; group < expected.size(); ++group)
            for (size_t part = 0; part < expected[group].size(); ++part) {
                SCOPED_TRACE(::testing::Message() << "group " << group << ", part " << part);
                ExpectNear(actual[group][part], expected[group][part]);
            }
        still.scene.SetScene(posed.Frozen());
        const SceneRender::Hits traced = render.PrimaryHits(view);
        ExpectSameHits(traced, still.PrimaryHits(view), 4);
        ExpectSameHits(Drawn(view), traced, 60);
    }
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 2u);
    EXPECT_EQ(render.scene.Statistics().blasCount, 5u) << "what does not deform is shared";
}

// Joints that mirror: the object space of the instance is mirrored in turn.
TEST_F(DeformTest, MirroredFiguresKeepTheirFront) {
    scene::Material oneSided = Lambert(glm::vec3(0.5f));
    oneSided.isDoubleSided = false;
    scene::SceneData scene = SheetScene({.influences = 3, .targets = 1}, oneSided);
    scene.nodes[0].scale = {-1.2f, 0.9f, 1.0f};
    scene.nodes[0].translation = {0.2f, 0.3f, -0.1f};
    scene::DeformInstances(scene);
    ASSERT_TRUE(scene.instances[0].IsMirrored());
    PosedScene posed(std::move(scene));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    SceneRender still(Device());
    for (const double seconds : {0.0, 0.6}) {
        SCOPED_TRACE(seconds);
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(seconds));
        ExpectNear(OnDevice(posed.Streams()), posed.Streams());
        still.scene.SetScene(posed.Frozen());
        const SceneRender::Hits traced = render.PrimaryHits(Front());
        ExpectSameHits(traced, still.PrimaryHits(Front()), 2);
        ExpectSameHits(Drawn(Front()), traced, 20);
    }
}

// A host's matrices may take vertices beyond the numbers. These stay where the base shape has them; what
// moves by other joints is drawn where it is.
TEST_F(DeformTest, VerticesBeyondTheNumbersStayAndOthersAreDrawn) {
    scene::SceneData scene = SheetScene({.influences = 1, .cells = {5, 24}});  // none at x = 0
    const float huge = std::numeric_limits<float>::max();
    std::vector<glm::mat4x3> matrices(4, Translation({30, 0, 0}));
    matrices[0] = {{huge, huge, 0}, {0, 1, 0}, {0, 0, 1}, {huge, -huge, 0}};
    const scene::Primitive& sheet = scene.meshes[0].primitives[0];
    scene::DeformedStreams expected;
    expected.positions = sheet.positions;
    size_t stayed = 0;
    for (size_t i = 0; i < sheet.positions.size(); ++i) {
        if (sheet.influences.joints[i] != 0) {
            expected.positions[i] += glm::vec3(30, 0, 0);
            continue;
        }
        ++stayed;
        const glm::vec3 beyond = matrices[0] * glm::vec4(sheet.positions[i], 1.0f);
        ASSERT_FALSE(scene::IsFinite(beyond));
    }
    ASSERT_GT(stayed, 20u);
    render.scene.SetScene(std::move(scene));
    render.scene.SetJointMatrices(0, matrices);
    const scene::DeformedStreams actual = OnDevice(expected);
    for (size_t i = 0; i < expected.positions.size(); ++i)
        ASSERT_EQ(actual.positions[i], expected.positions[i]) << i;
    const passes::TraceSettings there = LookAt({30, 2.5f, 9}, {30, 2.5f, 0}, 0.7f, 48);
    ExpectSameHits(Drawn(there), render.PrimaryHits(there), 20, 40.0f);
}

// More groups of vertices than a row of a dispatch has, and records on both sides of its end.
TEST_F(DeformTest, MeshesOfMillionsOfVerticesAreDeformedToTheLast) {
    constexpr uint32_t kCount = gpu::kDeformRowGroups * gpu::kDeformGroupSize + 3 * 100;
    scene::SceneData scene = SheetScene({.influences = 0, .targets = 1});
    scene::Primitive large;
    large.material = 0;
    large.positions.resize(kCount);
    for (uint32_t i = 0; i < kCount; ++i) large.positions[i] = glm::vec3(i % 1024, i / 1024, i % 3) / 1024.0f;
    large.normals.assign(kCount, {0, 0, 1});
    large.targets.resize(1);
    large.targets[0].positions.assign(kCount, {0, 0, 1});
    large.indices = {0, 1, 2, kCount - 3, kCount - 2, kCount - 1};
    large.bounds = {glm::vec3(0.0f), glm::vec3(4.0f)};
    scene::UpdateDeformationBounds(large);
    std::vector<scene::Primitive>& parts = scene.meshes[0].primitives;
    const scene::Primitive small = parts[0];
    parts.insert(parts.begin(), large);
    render.scene.SetScene(std::move(scene));
    render.scene.SetMorphWeights(0, std::array{0.5f});
    scene::DeformedStreams ofSmall;
    scene::DeformPrimitive(small, std::array{0.5f}, {}, ofSmall);
    for (glm::vec3& position : large.positions) position.z += 0.5f;
    const std::vector<Group> actual =
        OnDevice({{scene::DeformedStreams{large.positions, large.normals, {}}, ofSmall}});
    const std::vector<glm::vec3>& positions = actual[0][0].positions;
    size_t others = 0;
    for (uint32_t i = 0; i < kCount; ++i) others += positions[i] == large.positions[i] ? 0 : 1;
    EXPECT_EQ(others, 0u);
    ExpectNear(actual[0][1], ofSmall);
}

}  // namespace raygraph::testing::deform_parts_test

// Lamps that joints and morph targets flatten.
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

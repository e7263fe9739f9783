// GpuScene: deformed copies that nobody sees cost nothing, and what deformed leaves nothing behind.
#include "tests/passes/deform_fixture.h"
#include "tests/support/error_of.h"

namespace raygraph::testing::deform_hidden_test {

namespace {

// Two sheets with a skin each, side by side; clip 0 bends the first one. The second one glows.
scene::SceneData TwoFigures() {
    scene::SceneData scene = SheetScene({.influences = 2, .targets = 1});
    const auto first = static_cast<uint32_t>(scene.nodes.size());
    for (uint32_t joint = 0; joint < 5; ++joint) {
        scene::Node node = scene.nodes[joint];
        if (node.parent != scene::kNone) node.parent += first;
        if (joint == 0) node.translation = {1.5f, 0, 0};
        if (node.mesh != scene::kNone) node.mesh = node.skin = 1;
        scene.nodes.push_back(node);
        scene.nodeOrder.push_back(first + joint);
    }
    scene.skins.push_back(scene.skins[0]);
    for (uint32_t& joint : scene.skins[1].joints) joint += first;
    scene.meshes.push_back(scene.meshes[0]);
    scene.meshes[1].primitives[0].material = 1;
    scene.materials.push_back(Lambert(glm::vec3(0.2f), glm::vec3(1.0f)));
    scene.instances.push_back({.mesh = 1, .node = first + 4});
    scene::Animation& both = scene.animations.emplace_back(scene.animations[0]);
    for (const scene::AnimationChannel& channel : scene.animations[0].channels) {
        both.channels.push_back(channel);
        both.channels.back().target.object += first;
    }
    scene::DeformInstances(scene);
    return scene;
}

passes::TraceSettings BothFigures() {
    return LookAt({0.8f, 2.5f, 12.0f}, {0.8f, 2, 0}, 0.7f, 48);
}

}  // namespace

TEST_F(DeformTest, WhatNobodySeesIsDeformedOnceItIsShown) {
    constexpr uint32_t kBoth = 1;
    PosedScene posed(TwoFigures());
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    render.scene.SetVisible(1, false);
    for (int frame = 0; frame < 8; ++frame) render.PrimaryHits(BothFigures());  // past compaction
    ASSERT_TRUE(render.scene.IsSettled()) << "what is hidden is built as well";
    const GpuSceneStatistics before = render.scene.Statistics();
    const SceneRevisions revisions = render.scene.Revisions();
    posed.MoveTo(0.6, kBoth);
    for (const float x : {0.1f, 0.2f}) {
        std::vector<glm::mat4x3> matrices(posed.applier.JointMatricesOf(1).begin(),
                                          posed.applier.JointMatricesOf(1).end());
        matrices[3][3].x += x;
        render.scene.SetJointMatrices(1, matrices);
        render.scene.SetMorphWeights(1, std::array{x});
        EXPECT_TRUE(render.scene.IsSettled());
        EXPECT_EQ(render.scene.Revisions(), revisions) << "the picture stays as it is";
        render.PrimaryHits(BothFigures());
        EXPECT_EQ(render.scene.Statistics().deformations, before.deformations);
        EXPECT_EQ(render.scene.Statistics().blasRefits, before.blasRefits);
        EXPECT_EQ(render.scene.Statistics().lightRebuilds, before.lightRebuilds);
        EXPECT_EQ(render.scene.Statistics().lightUpdates, before.lightUpdates);
        EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::None);
    }
    render.scene.SetPose(posed.scene, posed.applier);
    EXPECT_FALSE(render.scene.IsSettled()) << "it shows the second one";
    const SceneRender::Hits hits = render.PrimaryHits(BothFigures());
    EXPECT_TRUE(render.scene.IsSettled());
    const GpuSceneStatistics after = render.scene.Statistics();
    EXPECT_EQ(after.deformations, before.deformations + 1);
    EXPECT_EQ(after.blasRefits + after.blasRebuilds, before.blasRefits + before.blasRebuilds + 2);
    EXPECT_EQ(after.lightRebuilds + after.lightUpdates, before.lightRebuilds + before.lightUpdates + 1);
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    ExpectSameHits(hits, still.PrimaryHits(BothFigures()), 2);
    ExpectSameHits(Drawn(BothFigures()), hits, 20);
}

// Its first pose comes before its first frame, in which everything is built.
TEST_F(DeformTest, WhatIsHiddenFromTheStartIsBuiltInItsLatestPose) {
    PosedScene posed(TwoFigures());
    scene::SceneData data = posed.scene;
    data.nodes[9].isVisible = false;
    render.scene.SetScene(std::move(data));
    ASSERT_FALSE(render.scene.IsVisible(1));
    posed.MoveTo(0.6, 1);
    render.scene.SetJointMatrices(1, posed.applier.JointMatricesOf(1));
    render.scene.SetMorphWeights(1, scene::MorphWeights(posed.scene, posed.scene.instances[1]));
    render.PrimaryHits(BothFigures());
    EXPECT_EQ(render.scene.Statistics().deformations, 1u);
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 2u);
    render.scene.SetPose(posed.scene, posed.applier);
    const SceneRender::Hits hits = render.PrimaryHits(BothFigures());
    EXPECT_EQ(render.scene.Statistics().blasRefits + render.scene.Statistics().blasRebuilds, 1u)
        << "the first one alone has moved since";
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    ExpectSameHits(hits, still.PrimaryHits(BothFigures()), 2);
}

// A host's mesh may have joints and no triangles.
TEST_F(DeformTest, WhatHasNoTrianglesIsSettled) {
    scene::SceneData scene = SheetScene({.influences = 2});
    scene.meshes[0].primitives[0].indices.clear();
    render.scene.SetScene(std::move(scene));
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 1u);
    for (int frame = 0; frame < 2; ++frame) {
        render.PrimaryHits(Front(8));
        EXPECT_TRUE(render.scene.IsSettled());
        EXPECT_EQ(render.renderer.DescribePlan().find(" Deform "), std::string::npos);
        render.scene.SetJointMatrices(0, std::vector<glm::mat4x3>(4, glm::mat4x3(2.0f)));
    }
}

TEST_F(DeformTest, AnEmptySceneLeavesNothingOfADeformingOne) {
    const auto usedBytes = [] {
        Device().WaitIdle();
        Device().CollectGarbage();
        return Device().Memory().usedBytes;
    };
    const scene::SceneData still = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))});
    const auto show = [&](scene::SceneData data) {
        render.scene.SetScene(std::move(data));
        for (int frame = 0; frame < 4; ++frame) render.PrimaryHits(Front(8));
    };
    show(still);
    render.scene.SetScene({});
    const uint64_t empty = usedBytes();
    PosedScene posed(SheetScene({.influences = 4, .targets = 1, .cells = {32, 128}}));
    show(posed.scene);
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.5));
    render.PrimaryHits(Front(8));
    render.scene.SetScene({});
    EXPECT_EQ(usedBytes(), empty);
    show(still);
    const uint64_t ofStill = usedBytes();
    show(posed.scene);
    show(still);
    EXPECT_LE(usedBytes(), ofStill) << "beside another scene, too";
}

// Instances share what does not deform of a mesh, and do so when its sides change.
TEST_F(DeformTest, VariantsOfCopiesAreBuiltOnceWhereTheyShareAStructure) {
    scene::SceneData scene = TwoFigures();
    scene.variants = {"blended"};
    scene.materials.push_back(Lambert(glm::vec3(0.9f)));
    scene.materials[2].alphaMode = scene::AlphaMode::Blend;
    scene.materials[2].baseColorFactor.a = 0.999f;
    scene.instances[1].mesh = 0;
    scene.nodes[9].mesh = 0;
    scene.meshes.resize(1);
    scene::Primitive& wall = scene.meshes[0].primitives.emplace_back(QuadMesh(0.3f, 1).primitives[0]);
    for (scene::Primitive& primitive : scene.meshes[0].primitives)
        primitive.variants = {{0, 2}, {scene::kNone, primitive.material}};
    scene.materials[1].isDoubleSided = false;  // in a group of its own
    wall.positions[0].z += 0.01f;
    wall.bounds.Extend(wall.positions[0]);
    scene::DeformInstances(scene);
    PosedScene posed(scene);
    render.scene.SetScene(std::move(scene));
    render.PrimaryHits(BothFigures());
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 2u);
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 3u) << "a sheet each, and the wall";
    render.scene.SetVariant(0);
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.6, 1));
    const SceneRender::Hits hits = render.PrimaryHits(BothFigures());
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 6u);
    EXPECT_EQ(render.scene.Statistics().blasCount, 3u);
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    still.scene.SetVariant(0);
    ExpectSameHits(hits, still.PrimaryHits(BothFigures()), 20);
    ExpectSameHits(Drawn(BothFigures()), hits, 40);
}

}  // namespace raygraph::testing::deform_hidden_test

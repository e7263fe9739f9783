// GpuScene: meshes that deform are where the CPU's formula has them, for every view.
#include <tuple>

#include "tests/passes/deform_fixture.h"
#include "tests/support/error_of.h"

namespace raygraph::testing::deform_test {

TEST_F(DeformTest, SkinnedVerticesAreThoseOfTheFormula) {
    ExpectFormula({.influences = 2});
}

TEST_F(DeformTest, VerticesOfSeveralInfluenceSetsAreThoseOfTheFormula) {
    ExpectFormula({.influences = 7});
}

TEST_F(DeformTest, MorphedVerticesAreThoseOfTheFormula) {
    ExpectFormula({.influences = 0, .targets = 3});
}

TEST_F(DeformTest, MorphedThenSkinnedVerticesAreThoseOfTheFormula) {
    ExpectFormula({.influences = 4, .targets = 2});
}

TEST_F(DeformTest, FlatNormalsAreThoseOfTheDeformedTriangles) {
    ExpectFormula({.influences = 3, .targets = 1, .isFlat = true});
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
        const SceneIds ids = render.scene.Declare(render.renderer);
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

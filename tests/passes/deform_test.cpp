// GpuScene: meshes that deform are where the CPU's formula has them, for every view.
#include <tuple>

#include "passes/raster.h"
#include "renderer/scene/load_gltf.h"
#include "tests/passes/deforming_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/reference_assets.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {
namespace {

// All of the sheet, in every pose.
passes::TraceSettings Front(uint32_t size = 48) {
    return LookAt({0.5f, 2.5f, 9.0f}, {0, 2, 0}, 0.7f, size);
}

class DeformTest : public VulkanTest {
  protected:
    // The streams on the device, as in deform_resources.h of one group with one primitive.
    scene::DeformedStreams OnDevice(const scene::DeformedStreams& like) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback streams = render.renderer.ReadBack(ids.deformedStreams);
        render.renderer.Execute();
        streams.Wait();
        scene::DeformedStreams result;
        size_t offset = 0;
        const auto take = [&](auto& into, size_t count) {
            using Value = typename std::remove_reference_t<decltype(into)>::value_type;
            into = As<Value>(streams.Bytes().subspan(offset, count * sizeof(Value)));
            offset += (count * sizeof(Value) + 15) / 16 * 16;
        };
        take(result.positions, like.positions.size());
        take(result.normals, like.normals.size());
        take(result.tangents, like.tangents.size());
        return result;
    }
    static void ExpectNear(const scene::DeformedStreams& actual, const scene::DeformedStreams& expected) {
        constexpr float kSize = 4.0f;
        for (size_t i = 0; i < expected.positions.size(); ++i)
            ASSERT_LE(glm::length(actual.positions[i] - expected.positions[i]), 1e-5f * kSize) << i;
        for (size_t i = 0; i < expected.normals.size(); ++i)
            ASSERT_LE(glm::length(actual.normals[i] - expected.normals[i]), 2e-5f) << i;
        for (size_t i = 0; i < expected.tangents.size(); ++i)
            ASSERT_LE(glm::length(actual.tangents[i] - expected.tangents[i]), 2e-5f) << i;
    }
    void ExpectFormula(const SheetOptions& options) {
        PosedScene posed(SheetScene(options));
        scene::SceneData data = posed.scene;
        render.scene.SetScene(std::move(data));
        scene::DeformedStreams before = posed.Streams();
        ExpectNear(OnDevice(before), before);
        for (const double seconds : {0.2, 0.5, 0.9}) {
            SCOPED_TRACE(seconds);
            const scene::PoseChanges& changes = posed.MoveTo(seconds);
            render.scene.SetPose(posed.scene, posed.applier, changes);
            const scene::DeformedStreams expected = posed.Streams();
            EXPECT_NE(expected.positions, before.positions);
            ExpectNear(OnDevice(expected), expected);
            before = expected;
        }
    }
    // Same surfaces at the same places.
    static void ExpectSameHits(const SceneRender::Hits& actual, const SceneRender::Hits& expected,
                               size_t edgePixels, float size = 4.0f) {
        size_t others = 0, surfaces = 0;
        for (size_t i = 0; i < expected.ids.size(); ++i) {
            if (glm::uvec3(actual.ids[i]) != glm::uvec3(expected.ids[i])) {  // but for the geometry's index
                ++others;
                continue;
            }
            if (expected.ids[i].x == 0xFFFFFFFFu) continue;
            ++surfaces;
            ASSERT_LE(glm::length(glm::vec3(actual.position.values[i] - expected.position.values[i])),
                      5e-5f * size)
                << i;
            ASSERT_LE(glm::length(glm::vec3(actual.normal.values[i] - expected.normal.values[i])), 1e-3f)
                << i;
        }
        EXPECT_LE(others, edgePixels);
        EXPECT_GT(surfaces, 50u);
    }
    SceneRender::Hits Drawn(const passes::TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        return render.TakeHits(passes::RasterHits(render.renderer, ids, settings, seen));
    }

    SceneRender render{Device()};
};

}  // namespace

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

// The sheet four times: deformed by two skins, by the first one of these at another node, which is hidden, and
// not at all.
TEST_F(DeformTest, InstancesShareWhatDeformsThemAlike) {
    scene::SceneData scene = SheetScene({.influences = 2});
    scene.skins.push_back(scene.skins[0]);
    for (uint32_t& joint : scene.skins[1].joints) joint = 0;
    scene.nodes.resize(7);
    for (const uint32_t node : {5u, 6u}) {
        scene.nodes[node].mesh = 0;
        scene.nodes[node].skin = node == 5 ? 1 : 0;
        scene.nodeOrder.push_back(node);
        scene.instances.push_back({.mesh = 0, .node = node});
    }
    scene.instances.push_back({.mesh = 0, .objectToWorld = Translation({2, 0, 0})});
    scene.nodes[6].isVisible = false;  // it is where the first one is
    scene::DeformInstances(scene);
    EXPECT_FALSE(scene.instances[3].isDeformed);
    PosedScene posed(scene);
    render.scene.SetScene(std::move(scene));
    const passes::TraceSettings view = LookAt({0.5f, 2, 12}, {0.5f, 2, 0}, 0.6f, 48);
    render.PrimaryHits(view);
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 2u);
    EXPECT_EQ(render.scene.Statistics().blasCount, 3u);
    const uint64_t triangles = posed.scene.meshes[0].primitives[0].TriangleCount();
    EXPECT_EQ(render.scene.Statistics().trianglesUnique, triangles);
    EXPECT_EQ(render.scene.Statistics().trianglesPlaced, 4 * triangles);
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.6));
    const SceneRender::Hits hits = render.PrimaryHits(view);
    EXPECT_EQ(render.scene.Statistics().blasRefits + render.scene.Statistics().blasRebuilds, 1u)
        << "only the first skin has moved";
    SceneRender still(Device());
    scene::SceneData frozen = posed.scene;
    for (uint32_t i = 0; i < 4; ++i) {  // a mesh of its own for each
        scene::Mesh mesh = posed.scene.meshes[0];
        if (i < 3) {
            scene::DeformedStreams streams = posed.Streams(i);
            mesh.primitives[0].positions = streams.positions;
            mesh.primitives[0].normals = streams.normals;
            mesh.primitives[0].bounds = {};
            for (const glm::vec3& position : streams.positions) mesh.primitives[0].bounds.Extend(position);
        }
        mesh.primitives[0].influences = {};
        frozen.meshes.push_back(mesh);
        frozen.instances[i] = {.mesh = i + 1, .objectToWorld = posed.scene.instances[i].objectToWorld};
    }
    frozen.nodes.clear();
    frozen.nodeOrder.clear();
    frozen.skins.clear();
    frozen.animations.clear();
    still.scene.SetScene(std::move(frozen));
    still.scene.SetVisible(2, false);
    ExpectSameHits(hits, still.PrimaryHits(view), 2);
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

// A lamp that bends over a floor.
scene::SceneData LampScene() {
    scene::SceneData scene = SheetScene({.influences = 2, .targets = 1, .cells = {3, 8}},
                                        Lambert(glm::vec3(0.0f), glm::vec3(3.0f)));
    scene.materials.push_back(Lambert(glm::vec3(0.7f)));
    scene.meshes.push_back(QuadMesh(3.0f, 1));
    scene.instances.push_back({.mesh = 1, .objectToWorld = Translation({0, 2, -1.2f})});
    return scene;
}

TEST_F(DeformTest, ADeformingLampLightsAsItsFrozenPoseDoes) {
    PosedScene posed(LampScene());
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    render.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
    passes::TraceSettings settings = LookAt({0, 2, 8}, {0, 2, 0}, 0.7f, 16);
    render.TraceOnce(settings);
    const uint64_t rebuilds = render.scene.Statistics().lightRebuilds;
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.6));
    const RenderedImage lit = render.Render(settings, 64);
    EXPECT_EQ(render.scene.Statistics().lightRebuilds, rebuilds + 1);
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 48u);
    settings.lights.isOn = false;
    const RenderedImage found = render.Render(settings, 256);
    settings.lights.isOn = true;
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    still.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
    const RenderedImage frozen = still.Render(settings, 64);
    for (const auto& [a, b] : {std::pair{&lit, &frozen}, std::pair{&lit, &found}}) {
        const double error = glm::length(glm::dvec2(a->StandardErrorOfMean().x, b->StandardErrorOfMean().x));
        EXPECT_NEAR(a->mean.Mean().x, b->mean.Mean().x, 4.0 * error);
        EXPECT_LT(error, 0.02 * b->mean.Mean().x);
    }
    // Without MIS, a light that is elsewhere or shadowed by itself would show
    settings.lights.mis = MisHeuristic::Off;
    const RenderedImage sampled = render.Render(settings, 64), expected = still.Render(settings, 64);
    const double error =
        glm::length(glm::dvec2(sampled.StandardErrorOfMean().x, expected.StandardErrorOfMean().x));
    EXPECT_NEAR(sampled.mean.Mean().x, expected.mean.Mean().x, 4.0 * error);
}

// What poses need is taken when the scene is set: frames with next to no memory left still deform.
TEST_F(DeformTest, SceneThatDoesNotFitLeavesTheOldOneAndOneThatDoesCanBePosed) {
    const auto leaveMemory = [](uint64_t bytes) {
        Device().WaitIdle();
        Device().LimitMemory(Device().Memory().usedBytes + bytes);
    };
    constexpr uint64_t kStep = 2u << 20, kOfFrames = 512u << 10;
    PosedScene posed(SheetScene({.influences = 4, .targets = 1, .cells = {32, 128}}));
    render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))}));
    const SceneRender::Hits before = render.PrimaryHits(Front());
    uint32_t failureCount = 0;
    for (bool isSet = false; !isSet && failureCount < 32;) {
        leaveMemory(failureCount * kStep);
        try {
            scene::SceneData data = posed.scene;
            render.scene.SetScene(std::move(data));
            isSet = true;
        } catch (const Error& error) {
            EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
            ++failureCount;
            leaveMemory(kOfFrames);
            EXPECT_EQ(render.PrimaryHits(Front()).ids, before.ids);
        }
        Device().LimitMemory(0);
    }
    EXPECT_GE(failureCount, 2u);
    leaveMemory(kOfFrames);
    for (const double seconds : {0.0, 0.5, 1.0}) {
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(seconds));
        EXPECT_NO_THROW(render.PrimaryHits(Front()));
    }
    Device().LimitMemory(0);
    ExpectNear(OnDevice(posed.Streams()), posed.Streams());
}

TEST_F(DeformTest, AWalkingFoxIsWhereTheCpuHasIt) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    scene::SceneData fox = scene::LoadGltf(*test::ReferenceAssets() / "scenes/known/Fox.glb");
    uint32_t walk = 0;
    while (fox.animations.at(walk).name != "Walk") ++walk;
    scene::DeformInstances(fox);
    PosedScene posed(fox);
    render.scene.SetScene(std::move(fox));
    const passes::TraceSettings settings = LookAt({180, 90, 160}, {0, 40, 0}, 0.7f, 96);
    SceneRender still(Device());
    for (const double seconds : {0.2, 0.5}) {
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(seconds, walk));
        const SceneRender::Hits traced = render.PrimaryHits(settings);
        still.scene.SetScene(posed.Frozen());
        ExpectSameHits(traced, still.PrimaryHits(settings), 4, 160.0f);
        ExpectSameHits(Drawn(settings), traced, 40, 160.0f);
    }
}

}  // namespace raygraph::testing

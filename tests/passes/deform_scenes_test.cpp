// GpuScene: scenes with deforming meshes, as copies, lamps, large ones and published ones.
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/passes/deform_fixture.h"
#include "tests/support/error_of.h"
#include "tests/support/reference_assets.h"

namespace raygraph::testing::deform_scenes_test {

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
    still.scene.SetScene(posed.Frozen());
    still.scene.SetVisible(2, false);
    ExpectSameHits(hits, still.PrimaryHits(view), 2);
}

// As a host may place it: each has weights of its own.
TEST_F(DeformTest, InstancesWithoutANodeAreMorphed) {
    PosedScene posed(SheetScene({.influences = 0, .targets = 1}));
    scene::SceneData data = posed.scene;
    data.animations.clear();
    data.nodes.clear();
    data.nodeOrder.clear();
    data.instances[0].node = scene::kNone;
    data.instances.push_back(data.instances[0]);
    render.scene.SetScene(std::move(data));
    posed.scene.nodes[4].weights = {0.8f};
    render.scene.SetMorphWeights(0, posed.scene.nodes[4].weights);
    const scene::DeformedStreams first = posed.Streams();
    posed.scene.nodes[4].weights = {-0.3f};
    const scene::DeformedStreams second = posed.Streams();
    render.scene.SetMorphWeights(1, posed.scene.nodes[4].weights);
    const std::vector<Group> actual = OnDevice({{first}, {second}});
    ExpectNear(actual[0][0], first);
    ExpectNear(actual[1][0], second);
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 2u);
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
    const auto changes = [&] {
        return render.scene.Statistics().lightRebuilds + render.scene.Statistics().lightUpdates;
    };
    const uint64_t before = changes();
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.6));
    const RenderedImage lit = render.Render(settings, 64);
    EXPECT_EQ(changes(), before + 1);
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
    RAYGRAPH_SKIP_WITHOUT_ASSET_SCENES();
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

}  // namespace raygraph::testing::deform_scenes_test

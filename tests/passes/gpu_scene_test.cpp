// GpuScene: the TLAS is refreshed every frame with the least work, and the rays see it.
#include "rhi/command_list.h"
#include "tests/support/error_of.h"
#include "tests/support/padded_structures.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::gpu_scene_test {

namespace {

class GpuSceneTest : public VulkanTest {
  protected:
    // Which instance each of 3 pixels in a row sees, looking down on x = -1, 0, 1.
    std::array<uint32_t, 3> Seen() {
        scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = 1.0f;
        view.aspect = 3.0f;
        passes::TraceSettings settings;
        settings.extent = {3, 1};
        settings.camera = ToRecord(view);
        const SceneRender::Hits hits = render.PrimaryHits(settings);
        return {hits.ids[0].x, hits.ids[1].x, hits.ids[2].x};
    }
    static constexpr uint32_t kMiss = 0xFFFFFFFFu;

    SceneRender render{Device()};
};

}  // namespace

TEST_F(GpuSceneTest, SetTransform_MovesTheHitByATlasUpdate) {
    render.scene.SetScene(SceneOf({BoxMesh(0.3f), BoxMesh(0.3f)}, {Lambert(glm::vec3(0.5f))},
                                  {Translation({-1, 0, 0}), Translation({1, 0, 0})}));
    EXPECT_EQ(Seen(), (std::array<uint32_t, 3>{0, kMiss, 1}));
    EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::Rebuild);
    for (int frame = 0; frame < 8; ++frame) Seen();  // past compaction, which rebuilds
    ASSERT_TRUE(render.scene.IsSettled());

    render.scene.SetTransform(1, Translation({0, 0, 0}));
    EXPECT_EQ(Seen(), (std::array<uint32_t, 3>{0, 1, kMiss}));
    EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::Update);
    EXPECT_EQ(render.scene.Transform(1).matrix, Translation({0, 0, 0}));
}

TEST_F(GpuSceneTest, TlasIsLeftAloneWhenNothingMoved) {
    render.scene.SetScene(SceneOf({BoxMesh(0.3f)}, {Lambert(glm::vec3(0.5f))}));
    for (int frame = 0; frame < 8; ++frame) Seen();  // past build and compaction
    ASSERT_TRUE(render.scene.IsSettled());
    const GpuSceneStatistics before = render.scene.Statistics();
    Seen();
    EXPECT_EQ(render.scene.Statistics().tlasRebuilds, before.tlasRebuilds);
    EXPECT_EQ(render.scene.Statistics().tlasUpdates, before.tlasUpdates);
    EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::None);
    EXPECT_EQ(render.renderer.DescribePlan().find("RefreshTlas"), std::string::npos);
    render.scene.SetTransform(0, render.scene.Transform(0));
    Seen();
    EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::None) << "the same transform moves nothing";
}

TEST_F(GpuSceneTest, CulledRefreshStaysPending) {
    render.scene.SetScene(SceneOf({BoxMesh(0.3f)}, {Lambert(glm::vec3(0.5f))}, {Translation({-1, 0, 0})}));
    for (int frame = 0; frame < 8; ++frame) Seen();
    render.scene.SetTransform(0, Translation({1, 0, 0}));
    // A frame that reads the instance records alone: the TLAS refresh leads to no root
    render.renderer.BeginFrame();
    const SceneIds ids = render.scene.Declare(render.renderer);
    const Readback records = render.renderer.ReadBack(ids.instances);
    render.renderer.Execute();
    records.Wait();
    EXPECT_NE(render.renderer.DescribePlan().find("culled"), std::string::npos);
    EXPECT_EQ(Seen(), (std::array<uint32_t, 3>{kMiss, kMiss, 0}));
}

TEST_F(GpuSceneTest, GeometryBytesAreThoseOfTheMeshesAlone) {
    const auto bytes = [&](std::vector<scene::Mesh> meshes) {
        render.scene.SetScene(SceneOf(std::move(meshes), {Lambert(glm::vec3(0.5f))}));
        return render.scene.Statistics().geometryBytes;
    };
    const uint64_t ofBox = bytes({BoxMesh(0.3f)});
    EXPECT_GE(ofBox, 8u * 12 + 36u * 4);
    EXPECT_EQ(bytes({BoxMesh(0.3f), BoxMesh(0.3f)}), 2 * ofBox);
}

TEST_F(GpuSceneTest, InstancesShareTheirMeshsBlas) {
    scene::SceneData scene = SceneOf({BoxMesh(0.3f), QuadMesh(0.2f)}, {Lambert(glm::vec3(0.5f))});
    for (int i = 0; i < 10; ++i)
        scene.instances.push_back({.mesh = 0, .objectToWorld = Translation({0, float(i), 0})});
    render.scene.SetScene(std::move(scene));
    Seen();
    const GpuSceneStatistics& statistics = render.scene.Statistics();
    EXPECT_EQ(statistics.instanceCount, 12u);
    EXPECT_EQ(statistics.blasCount, 2u);
    EXPECT_EQ(statistics.blasBuilds, 2u);
    EXPECT_EQ(statistics.trianglesUnique, 14u);
    EXPECT_EQ(statistics.trianglesPlaced, 11u * 12u + 2u);
    EXPECT_GT(statistics.blasBytesBuilt, 0u);
}

TEST_F(GpuSceneTest, MeshOfSeveralPrimitivesShowsThemAllWithTheirMaterials) {
    scene::Mesh mesh = QuadMesh(0.3f, 0);
    for (uint32_t i = 1; i < 3; ++i) {
        scene::Primitive primitive = QuadMesh(0.3f, i).primitives[0];
        primitive.bounds = {};
        for (glm::vec3& position : primitive.positions) {
            position.x += float(i);
            primitive.bounds.Extend(position);
        }
        mesh.primitives.push_back(primitive);
    }
    std::vector<scene::Material> materials{Lambert(glm::vec3(0.1f)), Lambert(glm::vec3(0.2f)),
                                           Lambert(glm::vec3(0.3f))};
    materials[1].alphaMode = scene::AlphaMode::Mask;            // another group, another BLAS
    mesh.primitives[1].colors.assign(4, glm::vec4(1.0f));       // whose alpha has to be looked at:
    mesh.primitives[1].colors[3].a = 0.0f;                      // a hole, beside what is looked at
    mesh.primitives[2].uv0 = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};  // a stream that the others lack
    mesh.primitives[2].colors.assign(4, glm::vec4(0.5f, 1.0f, 1.0f, 1.0f));
    render.scene.SetScene(SceneOf({mesh}, materials, {Translation({-1, 0, 0})}));
    EXPECT_EQ(Seen(), (std::array<uint32_t, 3>{0, 0, 0}));
    EXPECT_EQ(render.scene.Statistics().blasCount, 2u);
    EXPECT_EQ(render.scene.Statistics().geometryCount, 3u);

    passes::TraceSettings settings = LookAt({0, 0, 5}, {0, 0, 0}, 0.5f, 33);
    const SceneRender::Hits hits = render.PrimaryHits(settings);
    for (uint32_t i = 0; i < 3; ++i) {
        const size_t pixel = size_t{16} * 33 + (i == 0 ? 3 : i == 1 ? 16 : 29);
        EXPECT_EQ(hits.ids[pixel].y, i);
        EXPECT_LT(hits.ids[pixel].z, 2u) << "triangles are numbered within their primitive";
        const glm::vec3 expected = 0.1f * float(i + 1) * (i == 2 ? glm::vec3(0.5f, 1, 1) : glm::vec3(1.0f));
        EXPECT_LT(glm::length(glm::vec3(hits.albedo.values[pixel]) - expected), 1e-6f);
    }
    render.scene.SetTransform(0, Translation({0, 0, 0}));
    EXPECT_EQ(Seen(), (std::array<uint32_t, 3>{kMiss, 0, 0})) << "every group moves";
}

TEST_F(GpuSceneTest, Compaction_IsPolledAndKeepsEveryHit) {
    render.scene.SetScene(SceneOf({SphereMesh(0.4f, 24), SphereMesh(0.4f, 24)}, {Lambert(glm::vec3(0.5f))},
                                  {Translation({-1, 0, 0}), Translation({1, 0, 0})}));
    const auto before = Seen();
    for (int frame = 0; frame < 8; ++frame) EXPECT_EQ(Seen(), before);
    const GpuSceneStatistics& statistics = render.scene.Statistics();
    EXPECT_EQ(statistics.compactionsPending, 0u);
    if (statistics.isCompactionOff)
        EXPECT_FALSE(statistics.compactionDisabledReason.empty());
    else
        EXPECT_LT(statistics.blasBytesCompacted, statistics.blasBytesBuilt);
}

class CompactionTest : public GpuSceneTest {
  protected:
    CompactionTest() { render.scene.SetScene(Spheres()); }
    static scene::SceneData Spheres() {
        return SceneOf({SphereMesh(0.4f, 24), SphereMesh(0.4f, 24)}, {Lambert(glm::vec3(0.5f))},
                       {Translation({-1, 0, 0}), Translation({1, 0, 0})});
    }
    bool HasCompacted() const {
        return render.renderer.DescribePlan().find("CompactBlas") != std::string::npos;
    }
    static constexpr std::array<uint32_t, 3> kBoth{0, kMiss, 1};
    std::optional<PaddedStructures> padded{std::in_place, Device()};
};

TEST_F(CompactionTest, TlasIsRebuiltOverTheCompactedStructuresInTheSameFrame) {
    EXPECT_EQ(Seen(), kBoth);
    Device().WaitIdle();  // the sizes are there
    const uint64_t rebuilds = render.scene.Statistics().tlasRebuilds;
    EXPECT_EQ(Seen(), kBoth);
    ASSERT_TRUE(HasCompacted());
    const std::string plan = render.renderer.DescribePlan();
    EXPECT_LT(plan.find("CompactBlas"), plan.find("RefreshTlas"));
    EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::Rebuild);
    EXPECT_EQ(render.scene.Statistics().tlasRebuilds, rebuilds + 1);
    EXPECT_EQ(render.scene.Statistics().compactionsPending, 0u);
    EXPECT_FALSE(render.scene.Statistics().isCompactionOff);
    EXPECT_TRUE(render.scene.IsSettled());
    EXPECT_EQ(Seen(), kBoth);
    EXPECT_FALSE(HasCompacted()) << "once";
}

// Freed memory is given out again: rays that still went through the old structures would read what is
// written there now.
TEST_F(CompactionTest, NoRayReadsTheOldStructures) {
    EXPECT_EQ(Seen(), kBoth);
    Device().WaitIdle();
    EXPECT_EQ(Seen(), kBoth);
    ASSERT_TRUE(HasCompacted());
    Device().WaitIdle();
    const GpuSceneStatistics statistics = render.scene.Statistics();
    std::vector<rhi::Buffer> others;
    rhi::CommandList commands = Device().BeginCommands("write over what is free");
    for (int i = 0; i < 16; ++i) {
        others.push_back(Device().CreateBuffer(
            {.name = "other",
             .size = statistics.blasBytesBuilt / statistics.blasCount,
             .usage = rhi::BufferUsage::AccelerationStructure | rhi::BufferUsage::CopyDestination}));
        commands.Fill(others.back(), 0);
    }
    Device().Submit(std::move(commands));
    EXPECT_EQ(Seen(), kBoth);
    render.scene.SetTransform(1, Translation({0, 0, 0}));
    EXPECT_EQ(Seen(), (std::array<uint32_t, 3>{0, 1, kMiss}));
}

TEST_F(CompactionTest, OldStructuresAreFreed) {
    int64_t structureBytes = 0;
    // Returns what frames after the first one add: staging memory of SetScene varies
    const auto added = [&] {
        SceneRender other(Device());
        other.scene.SetScene(Spheres());
        const auto used = [&] {
            other.TraceOnce(LookAt({0, 0, 5}, {0, 0, 0}, 0.5f, 4));
            Device().WaitIdle();
            return int64_t(Device().Memory().usedBytes);
        };
        const int64_t before = used();
        for (int frame = 0; frame < 6; ++frame) used();
        EXPECT_EQ(other.scene.Statistics().compactionsPending, 0u);
        structureBytes = int64_t(other.scene.Statistics().blasBytesBuilt);
        return used() - before;
    };
    added();  // what a Renderer keeps for its next frames is not of the structures
    const int64_t with = added();
    padded.reset();
    const int64_t without = added();
    EXPECT_LE(with, without + structureBytes / 4) << "of " << structureBytes;
}

TEST_F(GpuSceneTest, SetScene_ReplacesTheSceneInFlight) {
    for (int i = 0; i < 6; ++i) {
        const float x = float(i % 3 - 1);
        render.scene.SetScene(SceneOf({BoxMesh(0.3f)}, {Lambert(glm::vec3(0.5f))}, {Translation({x, 0, 0})}));
        std::array<uint32_t, 3> expected{kMiss, kMiss, kMiss};
        expected[size_t(i % 3)] = 0;
        EXPECT_EQ(Seen(), expected);
    }
    render.scene.SetScene(scene::SceneData{});
    EXPECT_EQ(Seen(), (std::array<uint32_t, 3>{kMiss, kMiss, kMiss}));
    EXPECT_EQ(render.scene.Statistics().blasCount, 0u) << "old BLASes are dropped";
}

TEST_F(GpuSceneTest, EditsOfASceneThatIsDeclaredAreRefused) {
    render.scene.SetScene(SceneOf({QuadMesh(1.4f)}, {Lambert(glm::vec3(0.5f))}));
    render.renderer.BeginFrame();
    render.renderer.Present(
        passes::Trace(render.renderer, render.Declare(), LookAt({0, 0, 2}, {}, 0.3f, 2)).radiance);
    EXPECT_EQ(ErrorTextOf([&] {
                  render.scene.SetTransform(0, Translation({1, 0, 0}));
              }),
              "GpuScene: SetTransform between Declare and Execute; it comes before Declare or after Execute");
    EXPECT_THROW(render.scene.SetVisible(0, false), Error);
    EXPECT_THROW(render.scene.SetMaterial(0, {}), Error);
    EXPECT_THROW(render.scene.SetScene({}), Error);
    EXPECT_THROW(render.scene.SetEnvironment({}), Error);
    EXPECT_THROW(render.scene.RemoveEnvironmentMap(), Error);
    EXPECT_THROW(render.scene.Declare(render.renderer), Error) << "once a frame";
    render.renderer.Execute();
    render.scene.SetTransform(0, Translation({1, 0, 0}));
    EXPECT_EQ(Seen(), (std::array<uint32_t, 3>{kMiss, 0, 0})) << "nothing of the refused edits";

    render.renderer.BeginFrame();
    render.scene.Declare(render.renderer);
    render.renderer.DropFrame();
    render.scene.SetVisible(0, false);
    EXPECT_EQ(Seen(), (std::array<uint32_t, 3>{kMiss, kMiss, kMiss}));
}

TEST_F(GpuSceneTest, IndicesOutOfRangeAreUsageErrorsThatNameTheCount) {
    render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))}));
    EXPECT_EQ(ErrorTextOf([&] { render.scene.SetTransform(1, glm::mat4x3(1.0f)); }),
              "GpuScene: instance 1 does not exist; the scene has 1");
    EXPECT_THROW(render.scene.SetMaterial(7, {}), Error);
    EXPECT_THROW(render.scene.SetVisible(7, true), Error);
}

// The device's coordinates begin where the scene is looked at; the world's do not move.
TEST_F(GpuSceneTest, SetViewpoint_MovesWhatIsOnTheDeviceAndNothingInTheWorld) {
    render.scene.SetEnvironment({});
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f), glm::vec3(1.0f))});
    for (const float x : {0.0f, 5000.0f})
        scene.instances.push_back({.mesh = 0, .objectToWorld = Translation({x, 0, 0})});
    scene.instances.erase(scene.instances.begin());
    render.scene.SetScene(std::move(scene));
    const auto originNow = [&] {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        render.renderer.Present(passes::PrimaryHits(render.renderer, ids,
                                                    LookAt({0, 0, 5}, {0, 0, 0}, 1.0f, 1),
                                                    passes::FilmPosition::Center)
                                    .position);
        render.renderer.Execute();
        return ids.origin;
    };
    EXPECT_EQ(originNow(), glm::dvec3(0.0));
    const SceneRevisions before = render.scene.Revisions();
    for (const double x : {100.0, -127.0, 3.0}) {
        render.scene.SetViewpoint({x, 50.0, 5.0});
        EXPECT_EQ(originNow(), glm::dvec3(0.0)) << x << " is near enough";
    }
    const uint64_t rebuilds = render.scene.Statistics().tlasRebuilds;
    render.scene.SetViewpoint({5003.0, 0.0, 5.0});
    EXPECT_EQ(originNow(), glm::dvec3(39 * 128.0, 0.0, 0.0));
    EXPECT_EQ(render.scene.Statistics().tlasRebuilds, rebuilds + 1);
    render.scene.SetViewpoint({4890.0, 0.0, 5.0});
    EXPECT_EQ(originNow(), glm::dvec3(39 * 128.0, 0.0, 0.0)) << "it stays while the eye is near";
    EXPECT_EQ(render.scene.Revisions(), before);
    EXPECT_EQ(render.scene.Transform(1).matrix[3].x, 5000.0f);

    // Through what is on the device now: places, and light found by its table
    const passes::TraceSettings settings = LookAt({5000.25f, 0.25f, 3.0f}, {5000.25f, 0.25f, 0.0f}, 0.01f, 2);
    const SceneRender::Hits hits = render.PrimaryHits(settings);
    EXPECT_EQ(hits.ids[0].x, 1u);
    EXPECT_NEAR(hits.position.values[0].x, 5000.25f, 0.02f);
    EXPECT_NEAR(hits.position.values[0].w, 3.0f, 1e-5f) << "depth along the view";
    EXPECT_NEAR(render.Render(settings, 1).mean.Mean().y, 1.0, 1e-6);
    render.scene.SetTransform(1, Translation({5000, 0, 1}));
    EXPECT_NEAR(render.PrimaryHits(settings).position.values[0].w, 2.0f, 1e-5f) << "moved in the world";
    render.scene.SetViewpoint({0.0, 0.0, 5.0});
    EXPECT_EQ(originNow(), glm::dvec3(0.0));
    EXPECT_NEAR(render.PrimaryHits(settings).position.values[0].w, 2.0f, 1e-3f);
}

// Each of two viewports tells where it looks from, frame by frame.
TEST_F(GpuSceneTest, SetViewpoint_ThoseThatTakeTurnsLeaveTheOrigin) {
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))});
    scene.instances.push_back({.mesh = 0, .objectToWorld = Translation({600, 0, 0})});
    render.scene.SetScene(std::move(scene));
    const auto rebuilds = [&](std::initializer_list<double> places, int rounds) {
        for (int frame = 0; frame < 4; ++frame) Seen();
        const uint64_t before = render.scene.Statistics().tlasRebuilds;
        for (int round = 0; round < rounds; ++round)
            for (const double x : places) {
                render.scene.SetViewpoint({x, 0.0, 5.0});
                Seen();
            }
        return render.scene.Statistics().tlasRebuilds - before;
    };
    EXPECT_LE(rebuilds({0.0, 600.0}, 8), 1u);
    EXPECT_EQ(rebuilds({600.0}, 20), 1u) << "one that stays there has its origin near";
    EXPECT_EQ(rebuilds({0.0, 600.0}, 8), 0u);
}

// The file's place has a rest that float leaves.
TEST_F(GpuSceneTest, TransformThatIsSetAsItIsMovesNothing) {
    scene::SceneData scene =
        SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))}, {Translation({10000, 0, 0})});
    scene.instances[0].translationResidual = {0.0004f, 0.0f, 0.0f};
    render.scene.SetScene(std::move(scene));
    const SceneRevisions before = render.scene.Revisions();
    render.scene.SetTransform(0, render.scene.Transform(0));
    EXPECT_EQ(render.scene.Revisions(), before);
    scene::PlacedTransform moved = render.scene.Transform(0);
    moved.matrix[3].y += 1.0f;
    render.scene.SetTransform(0, moved);
    EXPECT_EQ(render.scene.Transform(0).Place(), glm::dvec3(10000.0 + double{0.0004f}, 1.0, 0.0));
}

// A light and what it shines on, the two moved together: as bright anywhere.
TEST_F(GpuSceneTest, SetViewpoint_LightsComeAlong) {
    double radiance[2] = {};
    for (const bool isFar : {false, true}) {
        const glm::vec3 place = isFar ? glm::vec3(8000.0f, -4000.0f, 2000.0f) : glm::vec3(0.0f);
        scene::SceneData scene =
            SceneOf({QuadMesh(2.0f), QuadMesh(0.25f, 1)},
                    {Lambert(glm::vec3(0.5f)), Lambert(glm::vec3(0.0f), glm::vec3(3.0f))},
                    {Translation(place), Translation(place + glm::vec3(0, 0, 1))});
        scene::Light point, spot;
        point.lightToWorld = Translation(place + glm::vec3(1.0f, 0.0f, 1.0f));
        spot.type = scene::LightType::Spot;
        spot.lightToWorld = Translation(place + glm::vec3(-1.0f, 0.0f, 1.5f));
        scene.lights = {point, spot};
        render.scene.SetScene(std::move(scene));
        render.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
        passes::TraceSettings settings =
            LookAt(place + glm::vec3(3, 1, 3), place + glm::vec3(-0.5f, 0, 0), 0.2f, 16);
        radiance[isFar ? 1 : 0] = render.Render(settings, 16).mean.Mean().y;
        spot.intensity = 4.0f;
        render.scene.SetLight(1, spot);
        EXPECT_EQ(render.scene.Light(1), spot);
        EXPECT_GT(render.Render(settings, 16).mean.Mean().y, 1.2 * radiance[isFar ? 1 : 0]);
    }
    EXPECT_GT(radiance[0], 0.05);
    EXPECT_NEAR(radiance[1] / radiance[0], 1.0, 0.01);
}

}  // namespace raygraph::testing::gpu_scene_test

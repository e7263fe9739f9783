// Parts that do not fit, or are unusual: what is there stays, and frames go on.
#include "tests/passes/scene_parts.h"
#include "tests/support/error_of.h"

namespace raygraph::testing::part_errors_test {
namespace {

// So many more bytes of the device, while it lives.
class LimitedMemory {
  public:
    LimitedMemory(rhi::Device& device, uint64_t bytes) : m_device(device) {
        device.WaitIdle();
        device.LimitMemory(device.Memory().usedBytes + bytes);
    }
    ~LimitedMemory() { m_device.LimitMemory(0); }
    LimitedMemory(const LimitedMemory&) = delete;
    LimitedMemory& operator=(const LimitedMemory&) = delete;

  private:
    rhi::Device& m_device;
};

// As many lights as triangles.
scene::Mesh Lamp(uint32_t cuts, uint32_t material) {
    scene::Mesh mesh = SphereMesh(0.4f, cuts);
    mesh.primitives[0].material = material;
    return mesh;
}

}  // namespace

// It has brought a square by then, that is placed once more, when there is no room for its second mesh.
TEST_F(SceneParts, PartThatDoesNotFitGoesAndWhatIsUsedStays) {
    scene::SceneData data = SquareOf(1, 1, true);
    data.meshes.push_back(SphereMesh(0.4f, 400));
    data.instances.push_back({.mesh = 1, .objectToWorld = Translation(PartPlace(2))});
    SceneRender slow(Device(), {.streamBudget = 64u << 10});
    slow.scene.SetScene(SquareOf(0, 0, false));
    const auto part = slow.scene.Stream(PreparedScene(std::move(data)));
    const auto seen = [&] { return SeenOf(slow); };
    std::vector<Cell> expected(kCells);
    expected[0] = {0, ColorOf(0)};
    // Staging memory is allocated beside the first frames
    for (int frame = 0; frame < 1000 && part->meshes[0] == scene::kNone; ++frame) seen();
    ASSERT_NE(part->meshes[0], scene::kNone);
    const uint32_t placed =
        slow.scene.AddInstance(part->meshes[0], scene::PlacedTransform{Translation(PartPlace(5))});
    bool isRefused = false;
    {
        const LimitedMemory limit(Device(), 1u << 20);
        for (uint32_t frame = 0; frame < 1000 && !part->isComplete && !isRefused; ++frame) {
            try {
                seen();
            } catch (const Error& error) {
                EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
                isRefused = true;
            }
        }
    }
    ASSERT_TRUE(isRefused);
    expected[5] = {placed, ColorOf(1)};
    EXPECT_EQ(seen(), expected);
    EXPECT_TRUE(part->instances.empty());
    EXPECT_TRUE(slow.scene.Streaming().IsDone());
    EXPECT_EQ(slow.scene.Streaming().of, 0u);
    EXPECT_EQ(slow.scene.Statistics().instanceCount, 2u);
}

// All in one frame: what had been recorded for it before the Error has to arrive.
TEST_F(SceneParts, WhatWasCopiedInTheFrameOfAnErrorIsThere) {
    // With the staging memory there
    const auto before = render.scene.Stream(PreparedScene(SquareOf(7, 7, true)));
    for (int frame = 0; frame < 10'000 && !before->isComplete; ++frame) Seen();
    render.scene.Remove(*before);
    const auto first = render.scene.Stream(PreparedScene(SquareOf(1, 1, true)));
    scene::SceneData data = SquareOf(2, 2, true);
    data.meshes.push_back(SphereMesh(0.4f, 400));
    data.instances.push_back({.mesh = 1, .objectToWorld = Translation(PartPlace(3))});
    const auto second = render.scene.Stream(PreparedScene(std::move(data)));
    {
        const LimitedMemory limit(Device(), 3u << 20);
        for (int frame = 0; frame < 10'000 && second->instances.size() == 2; ++frame) try {
                Seen();
            } catch (const Error& error) {
                EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
            }
    }
    EXPECT_TRUE(second->instances.empty());
    ASSERT_TRUE(first->isComplete);
    std::vector<Cell> expected(kCells);
    expected[0] = {0, ColorOf(0)};
    expected[1] = {first->instances[0], ColorOf(1)};
    EXPECT_EQ(Seen(), expected);
    // Nor do its copies wait for the next part, when their targets are gone
    const auto third = render.scene.Stream(PreparedScene(SquareOf(4, 4, true)));
    for (int frame = 0; frame < 10'000 && !third->isComplete; ++frame) Seen();
    expected[4] = {third->instances[0], ColorOf(4)};
    EXPECT_EQ(Seen(), expected);
}

TEST_F(SceneParts, WhatAStreamingPartHasBroughtStaysUntilItIsThere) {
    scene::SceneData data = SquareOf(1, 1, true);
    data.meshes.push_back(SphereMesh(0.4f, 500));
    data.instances.push_back({.mesh = 1, .objectToWorld = Translation(PartPlace(2))});
    data.instances.push_back({.mesh = 0, .objectToWorld = Translation(PartPlace(3))});
    SceneRender slow(Device(), {.streamBudget = 64u << 10});
    slow.scene.SetScene(SquareOf(0, 0, false));
    const auto part = slow.scene.Stream(PreparedScene(std::move(data)));
    for (int frame = 0; frame < 10'000 && part->instances[0] == scene::kNone; ++frame)
        slow.PrimaryHits(View());
    ASSERT_NE(part->instances[0], scene::kNone);
    ASSERT_FALSE(part->isComplete);
    slow.scene.RemoveInstance(part->instances[0]);
    const std::string mesh = std::to_string(part->meshes[0]);
    EXPECT_EQ(ErrorTextOf([&] { slow.scene.RemoveMesh(part->meshes[0]); }),
              "GpuScene: mesh " + mesh + " cannot be removed: its part is on its way");
    const AddedPart copy = *part;
    slow.scene.Remove(copy);
    EXPECT_EQ(slow.scene.Streaming().of, 0u);
    for (int frame = 0; frame < 4; ++frame) slow.PrimaryHits(View());
    EXPECT_EQ(slow.scene.Statistics().instanceCount, 1u);
    EXPECT_FALSE(part->isComplete);
}

// Scratch memory is that of few, however many there are.
TEST_F(SceneParts, ManySmallMeshesTakeNoMoreThanTheyNeed) {
    constexpr uint32_t kCount = 3000;
    scene::SceneData data = SceneOf({QuadMesh(0.4f)}, {Lambert(ColorOf(1))}, {Translation(PartPlace(1))});
    data.meshes.resize(kCount, data.meshes[0]);
    data.instances.clear();
    for (uint32_t i = 0; i < kCount; ++i)
        data.instances.push_back({.mesh = i, .objectToWorld = Translation(PartPlace(1 + i % 60))});
    const LimitedMemory limit(Device(), 96u << 20);
    const AddedPart part = render.scene.Add(std::move(data));
    EXPECT_EQ(Seen()[2].color, ColorOf(1));
    EXPECT_EQ(render.scene.Statistics().instanceCount, kCount + 1);
}

TEST_F(SceneParts, LightsThatDoNotFitLeaveTheOthers) {
    const auto room = [&](uint32_t cuts) {
        scene::SceneData data = SceneOf({QuadMesh(4.0f), Lamp(8, 1), Lamp(cuts, 1)},
                                        {Lambert(glm::vec3(0.5f)), Lambert({}, glm::vec3(9.0f))},
                                        {Translation({4, 4, 0}), Translation({4, 4, 2})});
        data.instances.pop_back();
        return data;
    };
    passes::TraceSettings settings = View();
    settings.biases.maxDepth = 1;
    render.scene.SetScene(room(200));
    const RenderedImage before = render.Render(settings, 4);
    ASSERT_GT(before.mean.Mean().x, 0.005);
    const uint32_t lights = render.scene.Statistics().lightCount;
    {
        // Records of 80,000 triangles are several MB
        const LimitedMemory limit(Device(), 2u << 20);
        for (int i = 0; i < 2; ++i)
            EXPECT_NE(
                ErrorTextOf(
                    [&] {
                        (void)render.scene.AddInstance(2, scene::PlacedTransform{Translation({4, 4, 3})});
                    },
                    ErrorKind::OutOfMemory),
                "accepted");
        EXPECT_EQ(render.Render(settings, 4).mean.values, before.mean.values);
    }
    EXPECT_EQ(render.scene.Statistics().lightCount, lights);
    (void)render.scene.AddInstance(2, scene::PlacedTransform{Translation({40, 4, 3})});
    render.TraceOnce(settings);
    EXPECT_GT(render.scene.Statistics().lightCount, 10'000u);
}

// A node may be scaled to nothing, by its file.
TEST_F(SceneParts, LightsOfFlatNodesAreTaken) {
    scene::SceneData data;
    data.lights.resize(1);
    data.lights[0].lightToWorld[0] = glm::vec3(0.0f);
    EXPECT_EQ(render.scene.Add(std::move(data)).lights.size(), 1u);
}

// An empty scene has no place of its own.
TEST_F(SceneParts, OriginOfAnEmptySceneIsWhereTheFirstPartIs) {
    constexpr float kFar = 1.0e6f;
    render.scene.SetScene({});
    render.renderer.BeginFrame();
    EXPECT_EQ(render.scene.Declare(render.renderer).origin, glm::dvec3(0.0));
    render.renderer.DropFrame();
    (void)render.scene.Add(SceneOf({QuadMesh(0.4f)}, {Lambert(ColorOf(1))}, {Translation({kFar, 0, 0})}));
    render.renderer.BeginFrame();
    EXPECT_NEAR(render.scene.Declare(render.renderer).origin.x, kFar, 128.0);
    render.renderer.DropFrame();
}

// Two that come at once share what is left.
TEST_F(SceneParts, TexturesOfPartsOnTheirWayCountForTheBudget) {
    const auto textured = [](uint32_t number) {
        scene::SceneData data = SquareOf(number, number, true);
        data.images[0].width = data.images[0].height = 64;
        data.images[0].rgba.assign(size_t{4} * 64 * 64, 200);
        return PreparedScene(std::move(data));
    };
    constexpr uint64_t kBudget = (4u * 64 * 64 * 4 / 3) * 3 / 2;  // of one and a half
    SceneRender small(Device(), {.textureLevels = true, .textureBudget = kBudget});
    small.scene.SetScene(SquareOf(0, 0, false));
    const auto first = small.scene.Stream(textured(1)), second = small.scene.Stream(textured(2));
    for (int frame = 0; frame < 10'000 && !second->isComplete; ++frame) small.PrimaryHits(View());
    ASSERT_TRUE(second->isComplete);
    EXPECT_LE(small.scene.Statistics().textureBytes, kBudget);
    EXPECT_EQ(small.scene.Statistics().reducedTextures, 1u);
}

}  // namespace raygraph::testing::part_errors_test

#include <algorithm>
#include <map>
#include <random>

#include "renderer/gpu_scene/streaming/scene_upload.h"
#include "renderer/scene/animation/pose.h"
#include "shaders/shared/draw_records.h"
#include "tests/passes/cell_scenes.h"
#include "tests/support/error_of.h"

// Parts of a scene that come and go: what is there is seen as if it had been set at once, everything else
// stays as it is, and nothing is left of what has gone.
namespace raygraph::testing::scene_parts_test {

TEST_F(SceneParts, WhatIsAddedIsSeenAndTheRestStays) {
    std::vector<Cell> expected = Seen();
    ASSERT_EQ(expected[0], (Cell{0, ColorOf(0)}));
    for (uint32_t i = 1; i < 20; ++i) {
        const AddedPart part = render.scene.Add(SquareOf(i, i, i % 2 == 0));
        EXPECT_TRUE(part.isComplete);
        ASSERT_EQ(part.instances.size(), 1u);
        expected[i] = {part.instances[0], ColorOf(i)};
        if (i % 4 == 0) Drop();
        if (i % 3 == 0) {
            EXPECT_EQ(Seen(), expected) << i;
        }
    }
    EXPECT_EQ(Seen(), expected);
    EXPECT_EQ(render.scene.Statistics().instanceCount, 20u);
    EXPECT_EQ(render.scene.Statistics().trianglesUnique, 40u);
}

TEST_F(SceneParts, NothingIsLeftOfWhatIsRemoved) {
    const std::vector<Cell> before = Seen();
    Seen();
    const GpuSceneStatistics first = render.scene.Statistics();
    for (int round = 0; round < 3; ++round) {
        const AddedPart one = render.scene.Add(SquareOf(1, 1, true));
        const AddedPart two = render.scene.Add(SquareOf(2, 2, true));
        EXPECT_EQ(one.instances[0], 1u) << "indices are used again";
        EXPECT_EQ(two.materials[0], 2u);
        Seen();
        EXPECT_EQ(render.scene.Statistics().textureBytes, 8u);
        render.scene.Remove(one);
        std::vector<Cell> expected = before;
        expected[2] = {two.instances[0], ColorOf(2)};
        EXPECT_EQ(Seen(), expected);
        render.scene.Remove(two);
        EXPECT_EQ(Seen(), before);
        const GpuSceneStatistics last = render.scene.Statistics();
        EXPECT_EQ(last.instanceCount, first.instanceCount);
        EXPECT_EQ(last.blasCount, first.blasCount);
        EXPECT_EQ(last.geometryBytes, first.geometryBytes);
        EXPECT_EQ(last.textureBytes, first.textureBytes);
        EXPECT_EQ(last.trianglesUnique, first.trianglesUnique);
    }
}

// Against a model: which part, of which color, is in which cell.
TEST_F(SceneParts, AnySequenceOfEditsShowsWhatIsThere) {
    struct Thing {
        AddedPart part;
        uint32_t number = 0;
        std::map<uint32_t, uint32_t> cells;  // by instance
    };
    std::vector<Thing> things;
    std::mt19937 engine(3);
    std::vector<Cell> expected = Seen();
    const auto isFree = [&](uint32_t cell) { return expected[cell].instance == kMiss; };
    for (uint32_t step = 1; step < 300; ++step) {
        const auto cell = static_cast<uint32_t>(engine() % kCells);
        Thing* const thing = things.empty() ? nullptr : &things[engine() % things.size()];
        switch (engine() % 6) {
            case 0:
            case 1:
                if (!isFree(cell)) break;
                things.push_back({render.scene.Add(SquareOf(step, cell, step % 2 == 0)), step, {}});
                things.back().cells[things.back().part.instances[0]] = cell;
                expected[cell] = {things.back().part.instances[0], ColorOf(step)};
                break;
            case 2: {
                if (!thing || !isFree(cell)) break;
                const uint32_t instance = render.scene.AddInstance(
                    thing->part.meshes[0], scene::PlacedTransform{Translation(PartPlace(cell))});
                thing->cells[instance] = cell;
                expected[cell] = {instance, ColorOf(thing->number)};
                break;
            }
            case 3: {
                if (!thing || !isFree(cell)) break;
                auto& [instance, place] = *thing->cells.begin();
                render.scene.SetTransform(instance, Translation(PartPlace(cell)));
                expected[cell] = std::exchange(expected[std::exchange(place, cell)], {});
                break;
            }
            case 4:
                if (!thing || things.size() < 12) break;
                for (const auto& [instance, place] : thing->cells) {
                    if (instance != thing->part.instances[0]) render.scene.RemoveInstance(instance);
                    expected[place] = {};
                }
                render.scene.Remove(thing->part);
                things.erase(things.begin() + (thing - things.data()));
                break;
            case 5:
                Drop();
                break;
        }
        if (step % 7 == 0) {
            ASSERT_EQ(Seen(), expected) << step;
        }
    }
    EXPECT_EQ(Seen(), expected);
}

TEST_F(SceneParts, MeshesMaterialsAndTexturesAreShared) {
    const AddedPart textured = render.scene.Add(SquareOf(7, 1, true));
    scene::Material material = Lambert(glm::vec3(1.0f));
    material.baseColorTexture.texture = static_cast<int32_t>(textured.textures[0]);
    const uint32_t shared = render.scene.AddMaterial(material);
    const uint32_t plain = render.scene.AddMaterial(Lambert(ColorOf(8)));
    scene::Mesh mesh = QuadMesh(0.2f, plain);
    scene::Primitive right = QuadMesh(0.2f, shared).primitives[0];
    right.bounds = {};
    for (glm::vec3& position : right.positions) {
        position.x += 1.0f;
        right.bounds.Extend(position);
    }
    right.uv0.assign(4, glm::vec2(0.5f));
    mesh.primitives.push_back(right);
    const uint32_t number = render.scene.AddMesh(std::move(mesh));
    const uint32_t instance =
        render.scene.AddInstance(number, scene::PlacedTransform{Translation(PartPlace(10))});
    const uint32_t hidden =
        render.scene.AddInstance(number, scene::PlacedTransform{Translation(PartPlace(20))}, false);
    std::vector<Cell> seen = Seen();
    EXPECT_EQ(seen[10], (Cell{instance, ColorOf(8)}));
    EXPECT_EQ(seen[11], (Cell{instance, ColorOf(7)}));
    EXPECT_EQ(seen[20], Cell{});
    render.scene.SetVisible(hidden, true);
    render.scene.SetMaterial(plain, Lambert(ColorOf(9)));
    seen = Seen();
    EXPECT_EQ(seen[10], (Cell{instance, ColorOf(9)}));
    EXPECT_EQ(seen[20], (Cell{hidden, ColorOf(9)}));
    render.scene.Remove(textured);
    EXPECT_EQ(Seen()[11], (Cell{instance, ColorOf(7)})) << "a texture that is used stays";
}

TEST_F(SceneParts, WhatIsUsedOrIsNotThereIsRefused) {
    GpuScene& scene = render.scene;
    const AddedPart part = scene.Add(SquareOf(1, 1, true));
    EXPECT_EQ(ErrorTextOf([&] { scene.RemoveMesh(part.meshes[0]); }),
              "GpuScene: mesh 1 cannot be removed: 1 instances use it");
    EXPECT_EQ(ErrorTextOf([&] { scene.RemoveMaterial(part.materials[0]); }),
              "GpuScene: material 1 cannot be removed: 1 primitives use it");
    EXPECT_EQ(ErrorTextOf([&] { scene.RemoveTexture(part.textures[0]); }),
              "GpuScene: texture 0 cannot be removed: 1 materials use it");
    scene.RemoveInstance(part.instances[0]);
    EXPECT_EQ(ErrorTextOf([&] { scene.SetTransform(part.instances[0], glm::mat4x3(1.0f)); }),
              "GpuScene: instance 1 has been removed");
    EXPECT_EQ(ErrorTextOf([&] { scene.RemoveInstance(2); }),
              "GpuScene: instance 2 does not exist; the scene has 2");
    scene.RemoveMesh(part.meshes[0]);
    scene.RemoveMaterial(part.materials[0]);
    scene.RemoveTexture(part.textures[0]);
    EXPECT_EQ(ErrorTextOf([&] { scene.AddInstance(1, scene::PlacedTransform{}); }),
              "GpuScene: mesh 1 has been removed");
    EXPECT_EQ(ErrorTextOf([&] { scene.SetMaterial(1, Lambert(glm::vec3(0.5f))); }),
              "GpuScene: material 1 has been removed");
    EXPECT_EQ(ErrorTextOf([&] { scene.RemoveLight(0); }),
              "GpuScene: light 0 does not exist; the scene has 0");
    EXPECT_EQ(ErrorTextOf([&] { scene.AddMesh(QuadMesh(1.0f, 5)); }),
              "GpuScene: material 5 does not exist; the scene has 2");
    scene::Material material;
    material.normalTexture.texture = 3;
    EXPECT_EQ(ErrorTextOf([&] { scene.AddMaterial(material); }),
              "GpuScene: texture 3 does not exist; the scene has 1");
    EXPECT_EQ(ErrorTextOf([&] { scene.AddInstance(0, scene::PlacedTransform{glm::mat4x3(0.0f)}); }),
              "GpuScene: AddInstance: its transform is scaled to nothing or to a line");
    scene::SceneData wrong = SquareOf(1, 1, false);
    wrong.meshes[0].primitives[0].indices[0] = 9;
    EXPECT_TRUE(ErrorTextOf([&] { scene.Add(std::move(wrong)); }).starts_with("GpuScene: Add: meshes[0]"));
    EXPECT_EQ(Seen()[0], (Cell{0, ColorOf(0)}));
}

// Raster views draw by a table of their own, in which each group has a place.
TEST_F(SceneParts, DrawsAreThoseOfWhatIsThere) {
    const auto vertices = [&] {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback bytes = render.renderer.ReadBack(ids.draws);
        render.renderer.Execute();
        bytes.Wait();
        std::vector<uint32_t> counts;
        for (const DrawRange& range : ids.drawsOfKind)
            for (uint32_t i = range.first; i < range.first + range.count; ++i)
                counts.push_back(As<gpu::DrawRecord>(bytes.Bytes())[i].vertexCount);
        std::erase(counts, 0u);
        return counts;
    };
    EXPECT_EQ(vertices(), std::vector<uint32_t>{6});
    const auto sphereOfAnotherKind = [] {
        scene::SceneData data =
            SceneOf({SphereMesh(0.4f, 4)}, {Lambert(ColorOf(1))}, {Translation(PartPlace(1))});
        data.materials[0].isDoubleSided = !Lambert(ColorOf(1)).isDoubleSided;
        return data;
    };
    const AddedPart sphere = render.scene.Add(sphereOfAnotherKind());
    const AddedPart square = render.scene.Add(SquareOf(2, 2, false));
    std::vector<uint32_t> counts = vertices();
    std::ranges::sort(counts);
    ASSERT_EQ(counts.size(), 3u);
    EXPECT_EQ(counts[1], 6u);
    EXPECT_GT(counts[2], 30u);
    render.scene.Remove(sphere);
    EXPECT_EQ(vertices(), (std::vector<uint32_t>{6, 6}));
    render.scene.Remove(square);
    EXPECT_EQ(vertices(), std::vector<uint32_t>{6});
    // The first draw is the sphere's: what goes then must not pass for it
    std::ignore = render.scene.Add(sphereOfAnotherKind());
    render.scene.Remove(render.scene.Add(SquareOf(2, 2, false)));
    const std::vector<uint32_t> left = vertices();
    ASSERT_EQ(left.size(), 2u);
    EXPECT_EQ(left[0] + left[1], 6u + counts[2]);
}

// A floor under a point light: albedo / pi * intensity / height^2 straight below, and somewhere in that pixel at
// least (1 + 0.5 / height^2)^-1.5 of it, the same for all lights.
TEST_F(SceneParts, LightsComeAndGo) {
    render.scene.SetEnvironment({});
    render.scene.SetScene(SceneOf({QuadMesh(4.0f)}, {Lambert(glm::vec3(0.5f))}, {Translation({4, 4, 0})}));
    passes::TraceSettings settings = View();
    settings.biases.maxDepth = 1;
    const auto center = [&] {
        const FloatImage image = render.TraceOnce(settings);
        return image.At(4, 4);
    };
    EXPECT_EQ(center().x, 0.0f);
    scene::Light light;
    light.intensity = 20.0f;
    // Above the pixel's center
    light.lightToWorld = Translation({4.5f, 3.5f, 2.0f});
    const uint32_t number = render.scene.AddLight(light);
    constexpr float kBelow = 0.5f / 3.14159265f * 20.0f / 4.0f;
    const float lit = center().x;
    EXPECT_LE(lit, kBelow * 1.0001f);
    EXPECT_GE(lit, kBelow * 0.838f);
    light.intensity = 0.0f;
    const uint32_t other = render.scene.AddLight(light, false);
    EXPECT_NE(other, number);
    render.scene.RemoveLight(number);
    EXPECT_EQ(center().x, 0.0f);
    light.intensity = 10.0f;
    EXPECT_EQ(render.scene.AddLight(light), number) << "the index is used again";
    EXPECT_NEAR(center().x, 0.5f * lit, 1e-5f);
    render.scene.RemoveLight(number);
    render.scene.RemoveLight(other);
    EXPECT_EQ(center().x, 0.0f);
}

// A lamp that comes lights as one that was there from the start, and darkness is as before when it has gone.
TEST_F(SceneParts, EmittersComeAndGo) {
    render.scene.SetEnvironment({});
    const auto room = [](bool hasLamp) {
        scene::SceneData data = SceneOf({QuadMesh(4.0f), QuadMesh(0.5f, 1)},
                                        {Lambert(glm::vec3(0.5f)), Lambert(glm::vec3(0.0f), glm::vec3(9.0f))},
                                        {Translation({4, 4, 0}), Translation({20, 4, 1})});
        if (!hasLamp) data.instances.pop_back();
        return data;
    };
    passes::TraceSettings settings = View();
    settings.biases.maxDepth = 1;
    render.scene.SetScene(room(false));
    scene::SceneData lamp = room(true);
    lamp.instances.erase(lamp.instances.begin());
    lamp.instances[0].objectToWorld = Translation({4, 4, 8});
    scene::SceneData whole = room(true);
    whole.instances[1].objectToWorld = Translation({4, 4, 8});
    constexpr uint32_t kSamples = 64;
    const AddedPart part = render.scene.Add(std::move(lamp));
    const RenderedImage added = render.Render(settings, kSamples);
    render.scene.Remove(part);
    EXPECT_EQ(render.Render(settings, 1).mean.Mean(), glm::dvec3(0.0));
    render.scene.SetScene(std::move(whole));
    const RenderedImage set = render.Render(settings, kSamples);
    ASSERT_GT(set.mean.Mean().x, 0.005);
    EXPECT_NEAR(added.mean.Mean().x, set.mean.Mean().x,
                4.0 * (added.StandardErrorOfMean().x + set.StandardErrorOfMean().x));
}

// Groups of lights were made for what there was.
TEST_F(SceneParts, WhatComesLaterIsInTheRestOfTheLightGroups) {
    render.scene.SetLightGroups({.namedCount = 1,
                                 .instances = {gpu::kLightGroupNamed},
                                 .materials = {gpu::kLightGroupNamed},
                                 .lights = {}});
    for (uint32_t i = 1; i < 40; ++i)
        (void)render.scene.Add(SceneOf({QuadMesh(0.4f)}, {Lambert(glm::vec3(0.5f), glm::vec3(1.0f))},
                                       {Translation(PartPlace(i))}));
    (void)render.scene.AddLight({});
    const FloatImage image = render.TraceOnce(View());
    EXPECT_GT(image.Mean().x, 0.0);
    EXPECT_EQ(render.scene.Statistics().lightCount, 2u * 39u + 1u);
}

// Structures of at most 100 triangles, or capsules, with hits as of whole ones.
TEST_F(SceneParts, PiecesOfLargeMeshesAreSeenAsTheWholeOnes) {
    const auto data = [] {
        scene::Mesh mesh = SphereMesh(2.0f, 20);
        scene::Primitive box = BoxMesh(1.0f, 1).primitives[0];
        for (glm::vec3& position : box.positions) position += glm::vec3(0, 0, 1.5f);
        box.bounds = {};
        for (const glm::vec3& position : box.positions) box.bounds.Extend(position);
        mesh.primitives.push_back(box);
        std::vector<glm::vec3> ends;
        std::vector<uint32_t> indices;
        for (uint32_t i = 0; i < 150; ++i) {
            ends.push_back({-3.5f + 0.05f * float(i), 3.0f, 0.0f});
            indices.insert(indices.end(), {i, i});
        }
        return SceneOf({mesh, RoundMesh(ends, indices, std::vector<float>(150, 0.3f), 2)},
                       {Lambert(ColorOf(1)), Lambert(ColorOf(2)), Lambert(ColorOf(3))},
                       {Translation({4, 4, 0}), Translation({4, 4, 0})});
    };
    const auto hits = [&](uint32_t maxTriangles) {
        render.scene.SetScene(PreparedScene(data(), {.maxTriangles = maxTriangles}));
        passes::TraceSettings settings = View();
        settings.extent = {64, 64};
        SceneRender::Hits seen = render.PrimaryHits(settings);
        for (glm::uvec4& id : seen.ids) id.w = 0;  // geometries are those of pieces
        return seen;
    };
    const SceneRender::Hits whole = hits(1u << 20);
    const uint32_t few = render.scene.Statistics().blasCount;
    const SceneRender::Hits pieces = hits(100);
    EXPECT_GE(render.scene.Statistics().blasCount, few + 10);
    EXPECT_EQ(pieces.ids, whole.ids);
    EXPECT_EQ(pieces.albedo.values, whole.albedo.values);
    EXPECT_EQ(pieces.normal.values, whole.normal.values);
}

}  // namespace raygraph::testing::scene_parts_test

// Parts that do not fit, or are unusual: what is there stays, and frames go on.
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

// A lamp of as many lights as triangles.
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

// Indices that are used again: parts, poses and light groups mean what had them, not what has them now.
namespace raygraph::testing::part_indices_test {

TEST_F(SceneParts, PartsRemoveWhatIsStillTheirs) {
    const AddedPart part = render.scene.Add(SquareOf(1, 1, true));
    render.scene.RemoveInstance(part.instances[0]);
    EXPECT_EQ(render.scene.AddInstance(0, scene::PlacedTransform{Translation(PartPlace(2))}),
              part.instances[0]);
    render.scene.Remove(part);
    std::vector<Cell> expected(kCells);
    expected[0] = {0, ColorOf(0)};
    expected[2] = {part.instances[0], ColorOf(0)};
    EXPECT_EQ(Seen(), expected);
    // Its mesh, material and texture have gone, and another part has their indices
    const AddedPart other = render.scene.Add(SquareOf(3, 3, true));
    EXPECT_EQ(other.meshes, part.meshes);
    EXPECT_EQ(other.textures, part.textures);
    render.scene.Remove(part);
    expected[3] = {other.instances[0], ColorOf(3)};
    EXPECT_EQ(Seen(), expected);
    // A part of another scene
    render.scene.SetScene(
        SceneOf({QuadMesh(0.4f), QuadMesh(0.4f), QuadMesh(0.4f)}, {Lambert(ColorOf(4))},
                {Translation(PartPlace(4)), Translation(PartPlace(5)), Translation(PartPlace(6))}));
    render.scene.Remove(part);
    render.scene.Remove(other);
    render.scene.Remove(AddedPart{});
    const std::vector<Cell> seen = Seen();
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(seen[4 + i], (Cell{i, ColorOf(4)}));
}

TEST_F(SceneParts, PartsRemoveTheirOwnLights) {
    scene::SceneData data;
    data.lights.resize(2);
    const AddedPart part = render.scene.Add(std::move(data));
    EXPECT_EQ(render.scene.Statistics().instanceCount, 1u);
    render.scene.RemoveLight(part.lights[1]);
    scene::Light light;
    light.intensity = 7.0f;
    EXPECT_EQ(render.scene.AddLight(light), part.lights[1]);
    render.scene.Remove(part);
    EXPECT_EQ(render.scene.Light(part.lights[1]).intensity, 7.0f);
    EXPECT_EQ(ErrorTextOf([&] { (void)render.scene.Light(part.lights[0]); }),
              "GpuScene: light 0 has been removed");
}

TEST_F(SceneParts, PosesMoveWhatTheSceneBrought) {
    scene::SceneData data =
        SceneOf({QuadMesh(0.4f), QuadMesh(0.4f)}, {Lambert(ColorOf(1)), Lambert(ColorOf(2))},
                {Translation(PartPlace(1)), Translation(PartPlace(2))});
    data.nodes.resize(3);
    data.nodeOrder = {0, 1, 2};
    for (uint32_t i = 0; i < 2; ++i) {
        data.nodes[i].translation = PartPlace(1 + i);
        data.instances[i].node = i;
    }
    data.lights.resize(1);
    data.lights[0].node = 2;
    scene::SceneData posed = scene::PoseOutline(data);
    scene::PoseApplier applier(posed);
    render.scene.SetScene(std::move(data));
    render.scene.RemoveInstance(1);
    render.scene.RemoveMaterial(1);
    render.scene.RemoveLight(0);
    ASSERT_EQ(render.scene.AddMaterial(Lambert(ColorOf(7))), 1u);
    const uint32_t mesh = render.scene.AddMesh(QuadMesh(0.4f, 1));
    ASSERT_EQ(render.scene.AddInstance(mesh, scene::PlacedTransform{Translation(PartPlace(5))}), 1u);
    scene::Light light;
    light.intensity = 7.0f;
    ASSERT_EQ(render.scene.AddLight(light), 0u);
    posed.nodes[0].translation = PartPlace(3);
    posed.instances[0].objectToWorld = Translation(PartPlace(3));
    posed.instances[1].objectToWorld = Translation(PartPlace(4));
    posed.materials[0] = Lambert(ColorOf(8));
    posed.materials[1] = Lambert(ColorOf(9));
    posed.lights[0].intensity = 9.0f;
    render.scene.SetPose(posed, applier);
    std::vector<Cell> expected(kCells);
    expected[3] = {0, ColorOf(8)};
    expected[5] = {1, ColorOf(7)};
    EXPECT_EQ(Seen(), expected);
    EXPECT_EQ(render.scene.Light(0).intensity, 7.0f);
}

}  // namespace raygraph::testing::part_indices_test

// Parts that stream: each frame takes what its budget allows, and shows what is there.
namespace raygraph::testing::stream_parts_test {
namespace {

// Frames of 64 KiB.
class StreamedParts : public SceneParts {
  protected:
    StreamedParts() : SceneParts({.textureLevels = true, .streamBudget = 64u << 10}) {}
};

}  // namespace

TEST_F(StreamedParts, NodesAppearAsTheyAreReady) {
    // A small one, one of 1.5 MB, and one more that waits for it
    const scene::SceneData large = SceneOf({SphereMesh(0.4f, 160)}, {Lambert(ColorOf(2))});
    scene::SceneData data = SquareOf(1, 1, true);
    data.meshes.push_back(large.meshes[0]);
    data.meshes.back().primitives[0].material = 1;
    data.materials.push_back(large.materials[0]);
    data.instances.push_back({.mesh = 1, .objectToWorld = Translation(PartPlace(2))});
    data.instances.push_back({.mesh = 0, .objectToWorld = Translation(PartPlace(3))});
    PreparedScene prepared(std::move(data));
    ASSERT_GT(prepared.GeometryBytes(), 1u << 20);
    const std::shared_ptr<const AddedPart> part = render.scene.Stream(std::move(prepared));
    EXPECT_EQ(part->instances, std::vector<uint32_t>(3, scene::kNone));
    EXPECT_FALSE(render.scene.Streaming().IsDone());
    uint64_t bytes = 0;
    uint32_t frames = 0, sinceFirst = 0;
    while (!part->isComplete) {
        ASSERT_LT(++frames, 1000u);
        const std::vector<Cell> seen = Seen();
        EXPECT_EQ(seen[0], (Cell{0, ColorOf(0)}));
        for (uint32_t i = 0; i < 3; ++i) {
            EXPECT_EQ(seen[i + 1].instance, part->instances[i]) << frames;
            if (part->instances[i] != scene::kNone) {
                EXPECT_EQ(seen[i + 1].color, ColorOf(i == 1 ? 2 : 1));
            }
        }
        const StreamProgress progress = render.scene.Streaming();
        EXPECT_LE(progress.bytes, progress.of);
        if (!part->isComplete) {
            EXPECT_GE(progress.bytes, bytes);
            EXPECT_LE(progress.bytes, bytes + (64u << 10)) << "more than the budget in a frame";
            bytes = progress.bytes;
        }
        if (part->instances[0] != scene::kNone) ++sinceFirst;
        if (sinceFirst == 6) {
            EXPECT_EQ(part->instances[1], scene::kNone) << "in one frame after all";
        }
    }
    EXPECT_TRUE(render.scene.Streaming().IsDone());
    EXPECT_GE(frames, 20u);
    const std::vector<Cell> seen = Seen();
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(seen[i + 1].instance, part->instances[i]);
    render.scene.Remove(*part);
    EXPECT_EQ(Seen()[1], Cell{});
    EXPECT_EQ(render.scene.Statistics().instanceCount, 1u);
}

TEST_F(StreamedParts, WhatIsRemovedOnItsWayStops) {
    scene::SceneData data = SquareOf(1, 1, true);
    data.meshes.push_back(SphereMesh(0.4f, 160));
    data.instances.push_back({.mesh = 1, .objectToWorld = Translation(PartPlace(2))});
    const auto part = render.scene.Stream(PreparedScene(std::move(data)));
    const auto next = render.scene.Stream(PreparedScene(SquareOf(4, 4, true)));
    for (int frame = 0; frame < 1000 && part->instances[0] == scene::kNone; ++frame) Seen();
    EXPECT_NE(part->instances[0], scene::kNone);
    EXPECT_EQ(next->instances[0], scene::kNone);
    render.scene.Remove(*part);
    for (int frame = 0; frame < 10'000 && !next->isComplete; ++frame) Seen();
    EXPECT_TRUE(next->isComplete);
    std::vector<Cell> expected(kCells);
    expected[0] = {0, ColorOf(0)};
    expected[4] = {next->instances[0], ColorOf(4)};
    EXPECT_EQ(Seen(), expected);
    const auto last = render.scene.Stream(PreparedScene(SquareOf(5, 5, true)));
    render.scene.SetScene(SquareOf(6, 6, false));
    EXPECT_TRUE(render.scene.Streaming().IsDone()) << "of a scene that is replaced";
    Seen();
    EXPECT_FALSE(last->isComplete);
}

}  // namespace raygraph::testing::stream_parts_test

// Scenes that frames copy to the device beside the one that is shown.
namespace raygraph::testing::scene_upload_test {
namespace {

// Frames of 64 KiB.
class SceneUploads : public SceneParts {
  protected:
    SceneUploads() : SceneParts({.textureLevels = true, .streamBudget = 64u << 10}) {}

    // A square with a texture, and a sphere that takes many frames.
    static scene::SceneData Next() {
        scene::SceneData data = SquareOf(1, 1, true);
        const scene::SceneData large = SceneOf({SphereMesh(0.4f, 160)}, {Lambert(ColorOf(2))});
        data.meshes.push_back(large.meshes[0]);
        data.meshes.back().primitives[0].material = 1;
        data.materials.push_back(large.materials[0]);
        data.instances.push_back({.mesh = 1, .objectToWorld = Translation(PartPlace(2))});
        return data;
    }
};

}  // namespace

TEST_F(SceneUploads, OldSceneIsShownUntilTheNewOneIsSet) {
    const std::shared_ptr<SceneUpload> upload = render.scene.Upload(PreparedScene(Next()));
    std::vector<Cell> before(kCells);
    before[0] = {0, ColorOf(0)};
    float fraction = 0.0f;
    uint32_t frames = 0;
    for (; !upload->IsReady(); ++frames) {
        ASSERT_LT(frames, 1000u);
        EXPECT_EQ(Seen(), before);
        EXPECT_GE(upload->Fraction(), fraction);
        fraction = upload->Fraction();
        EXPECT_FALSE(render.scene.IsSettled() && !upload->IsReady());
    }
    EXPECT_GT(frames, 20u);
    EXPECT_EQ(upload->Fraction(), 1.0f);
    Seen();  // and builds the last of its structures
    const uint64_t builds = render.scene.Statistics().blasBuilds;
    render.scene.SetScene(*upload);
    std::vector<Cell> after(kCells);
    after[1] = {0, ColorOf(1)};
    after[2] = {1, ColorOf(2)};
    EXPECT_EQ(Seen(), after);
    EXPECT_EQ(render.scene.Statistics().blasBuilds, builds) << "they were built before";
    EXPECT_EQ(ErrorTextOf([&] { render.scene.SetScene(*upload); }),
              "GpuScene: SetScene: the scene has been set before");
    EXPECT_EQ(Seen(), after);
}

TEST_F(SceneUploads, WhatIsLeftIsCopiedAtOnce) {
    for (const int frames : {0, 3}) {
        const std::shared_ptr<SceneUpload> upload = render.scene.Upload(PreparedScene(Next()));
        for (int frame = 0; frame < frames; ++frame) Seen();
        EXPECT_FALSE(upload->IsReady());
        render.scene.SetScene(*upload);
        EXPECT_EQ(Seen()[2], (Cell{1, ColorOf(2)}));
    }
}

TEST_F(SceneUploads, WithoutAnOwnerItStops) {
    Seen();
    Device().WaitIdle();
    const uint64_t before = Device().Memory().usedBytes;
    std::shared_ptr<SceneUpload> upload = render.scene.Upload(PreparedScene(Next()));
    const std::shared_ptr<SceneUpload> other = render.scene.Upload(PreparedScene(SquareOf(4, 4, true)));
    for (int frame = 0; frame < 1000 && upload->Fraction() == 0.0f; ++frame) Seen();
    EXPECT_FALSE(upload->IsReady());
    EXPECT_FALSE(other->IsReady()) << "one after the other";
    upload.reset();
    for (int frame = 0; frame < 10'000 && !other->IsReady(); ++frame) Seen();
    EXPECT_TRUE(other->IsReady());
    render.scene.SetScene(*other);
    EXPECT_EQ(Seen()[4], (Cell{0, ColorOf(4)}));
    Device().WaitIdle();
    Device().CollectGarbage();
    // Staging memory stays
    EXPECT_LT(Device().Memory().usedBytes, before + (1u << 20));
}

TEST_F(SceneUploads, OneThatDoesNotFitIsRefusedWhenItIsSet) {
    const std::shared_ptr<SceneUpload> upload = render.scene.Upload(PreparedScene(Next()));
    Seen();
    Device().WaitIdle();
    Device().LimitMemory(Device().Memory().usedBytes + (1u << 20));
    for (int frame = 0; frame < 10'000 && !upload->IsReady(); ++frame) EXPECT_NO_THROW(Seen());
    EXPECT_TRUE(upload->IsReady());
    Device().LimitMemory(0);
    EXPECT_NE(ErrorTextOf([&] { render.scene.SetScene(*upload); }, ErrorKind::OutOfMemory), "accepted");
    EXPECT_EQ(Seen()[0], (Cell{0, ColorOf(0)}));
}

}  // namespace raygraph::testing::scene_upload_test

// Parts of a scene that come and go: what is there is seen as if it had been set at once, everything else
// stays as it is, and nothing is left of what has gone.
#include <algorithm>
#include <map>
#include <random>

#include "shaders/shared/draw_records.h"
#include "tests/passes/scene_parts.h"
#include "tests/support/error_of.h"

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

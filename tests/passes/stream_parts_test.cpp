// Parts that stream: each frame takes what its budget allows, and shows what is there.
#include "tests/passes/scene_parts.h"

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

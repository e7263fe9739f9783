// The tree that stands for a driver's: exact after any changes, and the rule by which a TLAS is rebuilt.
#include "renderer/gpu_scene/geometry/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "renderer/gpu_scene/geometry/spatial_order.h"
#include "renderer/gpu_scene/instances/tlas_quality.h"

namespace raygraph::testing::box_tree_test {
namespace {

using glm::vec3;

scene::Bounds BoxAt(const vec3& place) {
    return {place - vec3(0.25f), place + vec3(0.25f)};
}

// Places in a cubic grid of spacing 1, and the tree over boxes there in the order of a build.
struct World {
    explicit World(uint32_t side) {
        for (uint32_t i = 0; i < side * side * side; ++i)
            places.emplace_back(float(i % side), float(i / side % side), float(i / side / side));
        Build();
    }
    void Build() {
        order = SpatialOrder(places);
        std::vector<scene::Bounds> boxes;
        for (const uint32_t i : order) boxes.push_back(BoxAt(places[i]));
        tree.Assign(boxes);
        quality.OnBuild(tree.Cost(), places.size());
    }
    template <typename Move>
    void MoveAll(Move&& move) {
        for (size_t i = 0; i < places.size(); ++i) places[i] = move(places[i]);
        Follow();
    }
    // Exchanges the places of this many pairs, at random.
    void Scatter(uint32_t pairs, uint32_t seed) {
        std::mt19937 engine(seed);
        std::uniform_int_distribution<size_t> random(0, places.size() - 1);
        for (uint32_t i = 0; i < pairs; ++i) std::swap(places[random(engine)], places[random(engine)]);
        Follow();
    }
    void Follow() {
        for (size_t leaf = 0; leaf < order.size(); ++leaf) tree.Set(leaf, BoxAt(places[order[leaf]]));
        tree.Refresh();
    }
    bool IsRebuildDue() { return quality.UpdateDecay(tree.Cost(), places.size()); }
    // Frames until a rebuild is due, at most `limit`.
    uint32_t FramesToRebuild(uint32_t limit) {
        for (uint32_t frame = 0; frame < limit; ++frame)
            if (IsRebuildDue()) return frame;
        return limit;
    }

    std::vector<vec3> places;
    std::vector<uint32_t> order;
    BoxTree tree;
    TlasQuality quality;
};

void ExpectSameTree(const BoxTree& actual, const BoxTree& expected) {
    EXPECT_EQ(actual.Root().min, expected.Root().min);
    EXPECT_EQ(actual.Root().max, expected.Root().max);
    EXPECT_NEAR(actual.Cost(), expected.Cost(), 1e-9 * expected.Cost());
}

}  // namespace

TEST(Bounds, TransformedIsAroundTheCornersBitForBit) {
    std::mt19937 engine(9);
    std::uniform_real_distribution<float> random(-3.0f, 3.0f);
    const auto vector = [&] { return vec3(random(engine), random(engine), random(engine)); };
    EXPECT_TRUE(scene::Bounds().Transformed(glm::mat4x3(1.0f)).IsEmpty());
    for (int i = 0; i < 1000; ++i) {
        scene::Bounds box;
        box.Extend(vector());
        box.Extend(vector());
        const glm::mat4x3 matrix(vector(), vector(), vector(), 1000.0f * vector());
        scene::Bounds expected;
        for (int corner = 0; corner < 8; ++corner)
            expected.Extend(matrix * glm::vec4(corner & 1 ? box.max.x : box.min.x,
                                               corner & 2 ? box.max.y : box.min.y,
                                               corner & 4 ? box.max.z : box.min.z, 1.0f));
        EXPECT_EQ(box.Transformed(matrix).min, expected.min);
        EXPECT_EQ(box.Transformed(matrix).max, expected.max);
    }
}

TEST(BoxTree, CostIsThatOfTheBoxesBetweenLeavesAndRoot) {
    BoxTree tree;
    tree.Assign({});
    EXPECT_TRUE(tree.Root().IsEmpty());
    EXPECT_EQ(tree.Cost(), 0.0);
    std::vector<scene::Bounds> boxes;
    for (int i = 0; i < 8; ++i) boxes.push_back(BoxAt(vec3(float(i), 0, 0)));
    tree.Assign(boxes);
    EXPECT_EQ(tree.Root().max, vec3(7.25f, 0.25f, 0.25f));
    EXPECT_EQ(tree.Cost(), 0.0) << "no order of so few is better than another";
    boxes.push_back(BoxAt(vec3(10, 0, 0)));
    tree.Assign(boxes);
    EXPECT_EQ(tree.Root().max, vec3(10.25f, 0.25f, 0.25f));
    EXPECT_DOUBLE_EQ(tree.Cost(), 2.0 * (0.25 + 2 * 0.5 * 7.5) + 2.0 * (3 * 0.25));
}

TEST(BoxTree, ChangesGiveTheTreeThatIsMadeOfTheChangedLeaves) {
    std::mt19937 engine(5);
    std::uniform_real_distribution<float> random(-10.0f, 10.0f);
    for (const size_t count : {1u, 8u, 9u, 64u, 65u, 1000u}) {
        std::vector<scene::Bounds> boxes;
        for (size_t i = 0; i < count; ++i)
            boxes.push_back(BoxAt(vec3(random(engine), random(engine), random(engine))));
        BoxTree tree;
        tree.Assign(boxes);
        for (int round = 0; round < 20; ++round) {
            for (size_t i = 0; i < count / 7 + 1; ++i) {
                const size_t leaf = engine() % count;
                // Outward, inward, and gone
                boxes[leaf] = round % 5 == 4 ? scene::Bounds()
                                             : BoxAt(vec3(random(engine), random(engine), random(engine)) *
                                                     (round % 2 ? 4.0f : 0.5f));
                tree.Set(leaf, boxes[leaf]);
            }
            tree.Refresh();
            BoxTree expected;
            expected.Assign(boxes);
            ExpectSameTree(tree, expected);
        }
    }
}

TEST(BoxTree, LeavesAreAddedBehindTheOthers) {
    std::mt19937 engine(6);
    std::uniform_real_distribution<float> random(-10.0f, 10.0f);
    BoxTree tree;
    std::vector<scene::Bounds> boxes;
    for (const size_t count : {1u, 2u, 8u, 9u, 20u, 64u, 65u, 512u, 700u, 5000u}) {
        tree.Grow(count);
        EXPECT_EQ(tree.LeafCount(), count);
        for (const size_t first = boxes.size(); boxes.size() < count;) {
            boxes.push_back(boxes.size() % 5 == 4 && first > 0
                                ? scene::Bounds()
                                : BoxAt(vec3(random(engine), random(engine), random(engine))));
            tree.Set(boxes.size() - 1, boxes.back());
        }
        tree.Refresh();
        BoxTree expected;
        expected.Assign(boxes);
        ExpectSameTree(tree, expected);
        EXPECT_EQ(tree.BoxCount(),
                  std::ranges::count_if(boxes, [](const scene::Bounds& b) { return !b.IsEmpty(); }));
    }
}

// A sum that changes were added to would have lost the small boxes' areas in that of the large one.
TEST(BoxTree, CostForgetsWhatHasBeenThere) {
    World world(10);
    const double before = world.tree.Cost();
    const vec3 place = world.places[7];
    world.places[7] = vec3(1e15f);
    world.Follow();
    EXPECT_GT(world.tree.Cost(), 1e20 * before);
    world.places[7] = place;
    world.Follow();
    EXPECT_EQ(world.tree.Cost(), before);
}

TEST(TlasQuality, ABuildWithOneFarAwayIsForgottenWhenItComesBack) {
    World world(12);
    const vec3 place = world.places[5];
    world.places[5] = vec3(3e4f, 2e4f, 1e4f);
    world.Build();
    EXPECT_FALSE(world.IsRebuildDue());
    world.places[5] = place;
    world.Follow();
    EXPECT_EQ(world.FramesToRebuild(100), 100u);
    world.Scatter(1000, 4);
    EXPECT_TRUE(world.IsRebuildDue());
}

TEST(TlasQuality, WhatMovesAsAWholeOrStaysNeverDecays) {
    World world(12);
    EXPECT_EQ(world.FramesToRebuild(1000), 1000u);
    world.MoveAll([](const vec3& p) { return p + vec3(100, -50, 7); });
    EXPECT_EQ(world.FramesToRebuild(1000), 1000u);
    world.MoveAll([](const vec3& p) { return vec3(-p.y, p.x, p.z); });
    EXPECT_EQ(world.FramesToRebuild(1000), 1000u);
    world.MoveAll([](const vec3& p) { return p + 0.05f * vec3(std::sin(9.0f * p.y), 0, 0); });
    EXPECT_EQ(world.FramesToRebuild(1000), 1000u) << "sways";
}

TEST(TlasQuality, WhatIsScatteredDecaysUntilItIsBuiltAgain) {
    World world(12);
    world.Scatter(1000, 1);
    EXPECT_TRUE(world.IsRebuildDue());
    world.Build();
    EXPECT_EQ(world.FramesToRebuild(1000), 1000u);
    world.Scatter(1000, 2);
    EXPECT_TRUE(world.IsRebuildDue());
}

TEST(TlasQuality, WhatSpreadsIsBuiltAgainAsOftenAsItHasSpreadByAsMuch) {
    World world(12);
    uint32_t rebuilds = 0;
    for (int frame = 0; frame < 100; ++frame) {  // to 2.7 times the size, 7.2 times the surface
        world.MoveAll([](const vec3& p) { return 1.01f * p; });
        if (!world.IsRebuildDue()) continue;
        ++rebuilds;
        world.Build();
    }
    EXPECT_GE(rebuilds, 4u);
    EXPECT_LE(rebuilds, 9u) << "log(7.4) / log(1.25)";
}

// A rebuild has to be paid for by what the frames lose without it, which is less of a large scene.
TEST(TlasQuality, FewThatAreScatteredHaveALargeSceneRebuiltAfterManyFrames) {
    World small(12), large(40);
    for (World* world : {&small, &large})
        world->Scatter(static_cast<uint32_t>(world->places.size() / 200), 3);
    EXPECT_EQ(small.FramesToRebuild(1000), 0u);
    const uint32_t wait = large.FramesToRebuild(1000);
    EXPECT_GE(wait, 1u);
    EXPECT_LT(wait, 64u);
}

TEST(TlasQuality, WhatWasHiddenWhenTheTreeWasBuiltIsBuiltOnce) {
    TlasQuality quality;
    quality.OnBuild(0.0, 0);
    EXPECT_FALSE(quality.UpdateDecay(0.0, 10));
    EXPECT_TRUE(quality.UpdateDecay(5.0, 10));
    quality.OnBuild(5.0, 10);
    EXPECT_FALSE(quality.UpdateDecay(5.0, 10));
}

}  // namespace raygraph::testing::box_tree_test

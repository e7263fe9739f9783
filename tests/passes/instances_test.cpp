#include <gtest/gtest.h>
#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <random>

#include "renderer/gpu_scene/geometry/mesh_packing.h"
#include "renderer/gpu_scene/geometry/wide_set.h"
#include "renderer/gpu_scene/instances/tlas_quality.h"
#include "renderer/gpu_scene/record_table.h"
#include "tests/passes/cell_scenes.h"
#include "tests/support/error_of.h"
#include "tests/support/failing_memory.h"

// Instances that are moved, shown and hidden: the least work for the TLAS, by a rule, and nothing is lost.
namespace raygraph::testing::instance_changes_test {
namespace {

class UpdatesOnly : public InstanceChanges {
  protected:
    UpdatesOnly() : InstanceChanges(true) {}
};

}  // namespace

// One copy a record, a scattering pass, or a copy of all: what rays see, and what shading reads.
TEST_F(UpdatesOnly, FewManyAndAllChangesAreSeen) {
    for (const uint32_t pairs : {1u, 3u, 40u, 90u, 400u}) {
        SCOPED_TRACE(pairs);
        Scatter(pairs);
        // Not so many that rays meet a quarter more boxes for each one that is seen
        for (uint32_t i = 0; i < std::min(pairs, 90u); i += 3) Toggle(i);
        EXPECT_EQ(Seen(), Expected());
        EXPECT_EQ(LastWork(), TlasWork::Update);
        const std::vector<gpu::InstanceRecord> records = Records();
        ASSERT_EQ(records.size(), 3 * kCount / 2);
        for (uint32_t i = 0; i < records.size(); ++i) {
            const uint32_t instance = i / 3 * 2 + (i % 3 > 0);  // one group, two groups
            ASSERT_EQ(records[i].instance, instance);
            ASSERT_EQ(records[i].objectToWorld, Translation(Place(cellOf[instance]))) << i;
            ASSERT_EQ(records[i].draw == gpu::kNotDrawn, isHidden[instance]) << i;
        }
    }
}

TEST_F(UpdatesOnly, ManyAtOnceAreWhatTheyAreOneByOne) {
    std::vector<uint32_t> moved, hidden;
    std::vector<scene::PlacedTransform> transforms;
    for (uint32_t i = 0; i < kCount; i += 3) {
        const uint32_t other = i * 7 % kCount;
        std::swap(cellOf[i], cellOf[other]);
        for (const uint32_t k : {i, other}) {  // some are listed twice: the last one counts
            moved.push_back(k);
            transforms.push_back({Translation(Place(cellOf[k]))});
        }
    }
    for (uint32_t i = 0; i < kCount; i += 5) hidden.insert(hidden.end(), {i, i});
    const SceneRevisions before = render.scene.Revisions();
    render.scene.SetTransforms(moved, transforms);
    render.scene.SetVisible(hidden, false);
    for (const uint32_t i : hidden) isHidden[i] = true;
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::Update);
    EXPECT_NE(render.scene.Revisions(), before);
    const SceneRevisions after = render.scene.Revisions();
    render.scene.SetTransforms({}, {});
    render.scene.SetVisible(hidden, false);
    render.scene.SetTransforms(std::span(moved).last(2), std::span(transforms).last(2));
    EXPECT_EQ(render.scene.Revisions(), after) << "nothing has changed";
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::None);
}

TEST_F(UpdatesOnly, AnErrorInAListLeavesAllOfIt) {
    const scene::PlacedTransform moved{Translation({3, 3, 3})};
    const scene::PlacedTransform nothing{glm::mat4x3(0.0f)};
    const std::vector<uint32_t> two{4, 5}, beyond{4, kCount + 1};
    EXPECT_EQ(ErrorTextOf([&] { render.scene.SetTransforms(two, std::vector{moved}); }),
              "GpuScene: SetTransforms: 1 transform for 2 instances");
    EXPECT_EQ(ErrorTextOf([&] {
                  render.scene.SetTransforms(beyond, std::vector{moved, moved});
              }),
              "GpuScene: instance 401 does not exist; the scene has 401");
    EXPECT_EQ(ErrorTextOf([&] {
                  render.scene.SetTransforms(two, std::vector{moved, nothing});
              }),
              "GpuScene: SetTransform: instance 5: its transform is scaled to nothing or to a line");
    EXPECT_EQ(ErrorTextOf([&] { render.scene.SetVisible(beyond, false); }),
              "GpuScene: instance 401 does not exist; the scene has 401");
    std::vector<uint32_t> all(kCount);
    std::iota(all.begin(), all.end(), 0u);
    const std::vector<scene::PlacedTransform> transforms(kCount, moved);
    for (const size_t successes : {0u, 1u, 1u}) {
        const FailingMemory failing(1000, successes);
        EXPECT_THROW(render.scene.SetTransforms(all, transforms), Error);
    }
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::None);
}

TEST_F(InstanceChanges, TlasIsRebuiltWhereItHasDecayed) {
    Scatter(1);
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::Update);
    Scatter(300);
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::Rebuild);
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::None) << "once";
    for (uint32_t i = 0; i < kCount; ++i)
        render.scene.SetTransform(i, Translation(Place(cellOf[i]) + glm::vec3(0.01f * float(i % 3), 0, 0)));
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::Update) << "what stays together";
}

// The TLAS has it where it was hidden, until it is shown.
TEST_F(InstanceChanges, HiddenInstancesMoveInTheTlasWhenTheyAreShown) {
    Toggle(5);
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::Update);
    render.scene.SetTransform(5, Translation({0, 0, 900}));
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::None);
    render.scene.SetTransform(5, Translation(Place(6) + glm::vec3(0, 0, 1)));
    Toggle(5);
    std::vector<uint32_t> expected = Expected();
    expected[5] = kMiss;
    expected[6] = 5;  // above another
    EXPECT_EQ(Seen(), expected);
    EXPECT_EQ(LastWork(), TlasWork::Update);
}

TEST_F(InstanceChanges, ManyThatAreShownAfterASceneWasSetWithoutThemAreRebuiltAtMostOnce) {
    scene::SceneData scene = SceneOf({BoxMesh(0.3f)}, {Lambert(glm::vec3(0.5f))});
    scene.nodes.resize(1);
    scene.nodes[0].isVisible = false;
    scene.nodeOrder = {0};
    scene.instances.clear();
    for (uint32_t i = 0; i < kCount; ++i)
        scene.instances.push_back({.mesh = 0, .node = 0, .objectToWorld = Translation(Place(i))});
    render.scene.SetScene(std::move(scene));
    EXPECT_EQ(Seen(), std::vector<uint32_t>(kCount, kMiss));
    for (uint32_t i = 0; i < kCount; ++i) render.scene.SetVisible(i, true);
    EXPECT_EQ(Seen(), Expected());
    const uint64_t before = render.scene.Statistics().tlasRebuilds;
    for (int frame = 0; frame < 10; ++frame) EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(render.scene.Statistics().tlasRebuilds, before);
}

// An animation of one in a field that is lit from everywhere leaves all others alone.
TEST_F(InstanceChanges, HidingRecordsWhatOneInstanceTakes) {
    render.TraceOnce(View());  // uploads the lights
    Toggle(17);
    render.TraceOnce(View());
    const std::string plan = render.renderer.DescribePlan();
    EXPECT_NE(plan.find("UploadTlasInstances"), std::string::npos);
    EXPECT_NE(plan.find("RefreshTlas"), std::string::npos);
    EXPECT_EQ(plan.find("BuildBlas"), std::string::npos);
    EXPECT_EQ(plan.find("UploadLights"), std::string::npos);
}

}  // namespace raygraph::testing::instance_changes_test

// Instances that are added and removed: after any changes, what rays and shading find is what there is.
namespace raygraph::testing::instances_come_and_go_test {
namespace {

// A grid of which half of the cells are taken at first, and what should be in each.
class InstancesComeAndGo : public InstanceChanges {
  protected:
    struct Instance {
        uint32_t mesh = 0;
        uint32_t cell = 0;
        bool isHidden = false;
    };
    explicit InstancesComeAndGo(bool hasRoof = false) : InstanceChanges(hasRoof) {
        for (uint32_t i = 0; i < kCount; ++i) instances.push_back(Instance{i % 2, i});
        for (uint32_t i = 0; i < kCount; i += 1 + i % 3) Remove(i);
    }
    bool IsFree(uint32_t cell) const {
        return std::ranges::none_of(instances, [&](const auto& i) { return i && i->cell == cell; });
    }
    void Remove(uint32_t index) {
        render.scene.RemoveInstance(index);
        EXPECT_FALSE(render.scene.HasInstance(index));
        instances[index].reset();
    }
    uint32_t Add(uint32_t mesh, uint32_t cell, bool hides = false) {
        const uint32_t index = render.scene.AddInstance(mesh, {Translation(Place(cell))}, !hides);
        if (index >= instances.size()) instances.resize(index + 1);
        EXPECT_FALSE(instances[index]) << "an index that is in use";
        instances[index] = Instance{mesh, cell, hides};
        return index;
    }
    // One change, if what is drawn allows it.
    void ChangeSomething() {
        const auto index = static_cast<uint32_t>(engine() % instances.size());
        const auto cell = static_cast<uint32_t>(engine() % kCount);
        std::optional<Instance>& instance = instances[index];
        switch (engine() % 5) {
            case 0:
            case 1:
                if (IsFree(cell)) Add(engine() % 2, cell, engine() % 4 == 0);
                break;
            case 2:
                if (instance) Remove(index);
                break;
            case 3:
                if (!instance || !IsFree(cell)) break;
                instance->cell = cell;
                render.scene.SetTransform(index, Translation(Place(cell)));
                break;
            default:
                if (!instance) break;
                instance->isHidden = !instance->isHidden;
                render.scene.SetVisible(index, !instance->isHidden);
        }
    }
    std::vector<uint32_t> ExpectedNow() const {
        std::vector<uint32_t> expected(kCount, kMiss);
        for (uint32_t i = 0; i < instances.size(); ++i)
            if (instances[i] && !instances[i]->isHidden) expected[instances[i]->cell] = i;
        return expected;
    }
    void CheckRecords() {
        std::vector<uint32_t> found(instances.size());
        for (const gpu::InstanceRecord& record : Records()) {
            if (record.positions == 0) {
                EXPECT_EQ(record.draw, gpu::kNotDrawn) << "of an index that is free";
                continue;
            }
            ASSERT_LT(record.instance, instances.size());
            const std::optional<Instance>& instance = instances[record.instance];
            ASSERT_TRUE(instance) << record.instance << " has been removed";
            ++found[record.instance];
            EXPECT_EQ(record.objectToWorld, Translation(Place(instance->cell)));
            EXPECT_EQ(record.draw == gpu::kNotDrawn, instance->isHidden);
        }
        for (uint32_t i = 0; i < instances.size(); ++i)
            EXPECT_EQ(found[i], instances[i] ? 1 + instances[i]->mesh : 0u) << "groups of " << i;
    }
    void Check() {
        EXPECT_EQ(Seen(), ExpectedNow());
        CheckRecords();
        EXPECT_EQ(
            render.scene.Statistics().instanceCount,
            std::ranges::count_if(instances, [](const auto& i) { return i.has_value(); }) + (roof != kMiss));
    }
    // A frame of which nothing is shown, or one that is dropped.
    void LoseFrame(bool isDropped) {
        render.renderer.BeginFrame();
        (void)render.scene.Declare(render.renderer);
        if (isDropped)
            render.renderer.DropFrame();
        else
            (void)render.renderer.Execute();
    }

    std::vector<std::optional<Instance>> instances;
};

class InstancesComeAndGoUpdated : public InstancesComeAndGo {
  protected:
    InstancesComeAndGoUpdated() : InstancesComeAndGo(true) {}
};

}  // namespace

TEST_F(InstancesComeAndGo, AfterAnyChangesTheSceneIsWhatItShouldBe) {
    Check();
    for (int step = 0; step < 60 && !HasFatalFailure(); ++step) {
        SCOPED_TRACE(step);
        for (size_t i = step % 7 == 0 ? 150 : engine() % 12; i > 0; --i) ChangeSomething();
        if (step % 3 == 0) LoseFrame(step % 2 == 0);
        if (step % 5 == 0)
            for (int i = 0; i < 5; ++i) ChangeSomething();
        Check();
    }
}

// With few new orders: what was added stays behind the others until there is much of it.
TEST_F(InstancesComeAndGoUpdated, AfterAnyChangesTheSceneIsWhatItShouldBe) {
    for (int step = 0; step < 40 && !HasFatalFailure(); ++step) {
        SCOPED_TRACE(step);
        for (size_t i = engine() % 40; i > 0; --i) ChangeSomething();
        if (step % 4 == 0) LoseFrame(step % 8 == 0);
        Check();
    }
}

TEST_F(InstancesComeAndGo, TablesGrowAndWhatIsFreeIsTakenAgain) {
    Check();
    std::vector<uint32_t> added;
    for (uint32_t i = 0; i < 3 * kCount; ++i)  // in one cell, one behind the other
        added.push_back(render.scene.AddInstance(1, {Translation({0.5f, 0.5f, -1.0f - float(i)})}));
    EXPECT_GT(*std::ranges::max_element(added), kCount) << "beyond what there was";
    Seen();
    const std::vector<gpu::InstanceRecord> most = Records();
    for (int round = 0; round < 5; ++round) {
        for (const uint32_t i : added) render.scene.RemoveInstance(i);
        if (round % 2 == 0) Seen();
        for (uint32_t& i : added) {
            i = render.scene.AddInstance(1, {Translation({0.5f, 0.5f, -2.0f})});
            EXPECT_LT(i, 4 * kCount);
        }
        Seen();
        EXPECT_EQ(Records().size(), most.size());
    }
    for (const uint32_t i : added) render.scene.RemoveInstance(i);
    Seen();
    for (const gpu::InstanceRecord& record : Records())
        EXPECT_TRUE(record.positions == 0 || instances[record.instance]) << "of what has been removed";
    EXPECT_EQ(Seen(), ExpectedNow());
}

TEST_F(InstancesComeAndGo, TheLastOneGoesAndAnotherComes) {
    for (uint32_t i = 0; i < instances.size(); ++i)
        if (instances[i]) Remove(i);
    Check();
    Add(1, 17);
    Check();
}

// They have no box and no place in the TLAS, and take none from the others.
TEST_F(InstanceChanges, InstancesOfAMeshWithoutTrianglesLeaveTheOthersAlone) {
    scene::SceneData scene = SceneOf({BoxMesh(0.3f), scene::Mesh{}}, {Lambert(glm::vec3(0.5f))});
    scene.instances.clear();
    for (uint32_t i = 0; i < kCount; ++i) {
        scene.instances.push_back({.mesh = 1, .objectToWorld = Translation(Place(kCount - 1 - i))});
        scene.instances.push_back({.mesh = 0, .objectToWorld = Translation(Place(i))});
    }
    render.scene.SetScene(std::move(scene));
    std::vector<uint32_t> expected(kCount);
    for (uint32_t i = 0; i < kCount; ++i) expected[i] = 2 * i + 1;
    for (int frame = 0; frame < 8; ++frame) EXPECT_EQ(Seen(), expected);  // compaction, where there is any
    for (uint32_t i = 0; i < 2 * kCount; i += 20) {
        render.scene.SetTransform(i, Translation(Place(i % kCount)));
        render.scene.SetVisible(i + 4, false);
    }
    EXPECT_EQ(Seen(), expected);
    EXPECT_EQ(LastWork(), TlasWork::None);
    const uint32_t added = render.scene.AddInstance(1, {Translation(Place(3))});
    EXPECT_EQ(Seen(), expected);
    // One takes the index of another that has a box, or is about to have one
    render.scene.SetTransform(61, Translation(Place(31)));
    render.scene.RemoveInstance(61);
    EXPECT_EQ(render.scene.AddInstance(1, {Translation(Place(30))}), 61u);
    expected[30] = kMiss;
    EXPECT_EQ(Seen(), expected);
    const uint32_t shortLived = render.scene.AddInstance(0, {Translation(Place(30))});
    render.scene.RemoveInstance(shortLived);
    EXPECT_EQ(render.scene.AddInstance(1, {Translation(Place(30))}), shortLived);
    const uint32_t last = render.scene.AddInstance(0, {Translation(Place(30))});
    expected[30] = last;
    EXPECT_EQ(Seen(), expected);
    render.scene.RemoveInstance(shortLived);
    EXPECT_EQ(Seen(), expected);
    render.scene.RemoveInstance(40);
    render.scene.RemoveInstance(41);
    expected[20] = kMiss;
    EXPECT_EQ(Seen(), expected);
    render.scene.RemoveInstance(added);
    EXPECT_EQ(Seen(), expected);
}

TEST_F(InstancesComeAndGo, WhatWasRemovedIsRefused) {
    Check();
    uint32_t cell = 0;
    while (!IsFree(cell)) ++cell;
    const uint32_t index = Add(0, cell);
    Remove(index);
    const std::string removed = "GpuScene: instance " + std::to_string(index) + " has been removed";
    EXPECT_EQ(ErrorTextOf([&] { render.scene.RemoveInstance(index); }), removed);
    EXPECT_EQ(ErrorTextOf([&] { render.scene.SetTransform(index, Translation({})); }), removed);
    EXPECT_EQ(ErrorTextOf([&] { render.scene.SetVisible(index, true); }), removed);
    EXPECT_EQ(ErrorTextOf([&] { (void)render.scene.IsVisible(index); }), removed);
    EXPECT_EQ(ErrorTextOf([&] { render.scene.AddInstance(2, {}); }),
              "GpuScene: mesh 2 does not exist; the scene has 2");
    EXPECT_EQ(ErrorTextOf([&] { render.scene.AddInstance(0, {glm::mat4x3(0.0f)}); }),
              "GpuScene: AddInstance: its transform is scaled to nothing or to a line");
    Check();
}

TEST_F(InstancesComeAndGo, WithoutMemoryNothingIsAddedOrRemoved) {
    Check();
    uint32_t failures = 0;
    instances.reserve(4 * kCount);
    for (uint32_t cell = 0; cell < kCount; ++cell) {
        if (!IsFree(cell)) continue;
        for (size_t successes = 0; successes < 100; ++successes) {
            try {
                const FailingMemory failing(1000, successes);
                Add(1, cell);
                break;
            } catch (const Error& error) {
                EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
                ++failures;
            }
        }
    }
    EXPECT_GT(failures, 2u);
    Check();
}

}  // namespace raygraph::testing::instances_come_and_go_test

// Slots of a growing table: never taken twice, taken again when they are free, against a list of flags.
namespace raygraph::testing::slot_ranges_test {
namespace {

// A model by flags, and what has to hold after each call.
struct Model {
    void Allocate(uint32_t count) {
        const uint32_t endBefore = End();
        const bool hasRoom = HasRoom(count);
        const uint32_t first = ranges.Allocate(count);
        taken.resize(std::max<size_t>(taken.size(), first + count));
        for (uint32_t i = first; i < first + count; ++i) {
            ASSERT_FALSE(taken[i]) << "slot " << i << " is taken";
            taken[i] = 1;
        }
        allocated.emplace_back(first, count);
        if (hasRoom)
            ASSERT_LE(first + count, endBefore) << "grew, and there was room for " << count;
        else
            ASSERT_EQ(first, endBefore);
        Check();
    }
    void Free(uint32_t first, uint32_t count) {
        ranges.Free(first, count);
        for (uint32_t i = first; i < first + count; ++i) taken[i] = 0;
        Check();
    }
    uint32_t End() const {
        const auto last = std::find(taken.rbegin(), taken.rend(), 1);
        return static_cast<uint32_t>(taken.rend() - last);
    }
    bool HasRoom(uint32_t count) const {
        uint32_t free = 0;
        for (uint32_t i = 0; i < End(); ++i) {
            free = taken[i] ? 0 : free + 1;
            if (free == count) return true;
        }
        return false;
    }
    void Check() const {
        ASSERT_EQ(ranges.End(), End());
        ASSERT_EQ(ranges.TakenCount(), std::ranges::count(taken, 1));
    }

    SlotRanges ranges;
    std::vector<char> taken;
    std::vector<std::pair<uint32_t, uint32_t>> allocated;
};

}  // namespace

TEST(SlotRanges, AreTakenOnceAndAgainWhenTheyAreFree) {
    for (const uint32_t largest : {1u, 3u, 12u, 100u}) {
        SCOPED_TRACE(largest);
        std::mt19937 engine(largest);
        Model model;
        for (int step = 0; step < 2000 && !::testing::Test::HasFatalFailure(); ++step) {
            const bool grows = step / 200 % 2 == 0;
            if (model.allocated.empty() || engine() % 10 < (grows ? 6 : 3)) {
                model.Allocate(1 + static_cast<uint32_t>(engine()) % largest);
                continue;
            }
            std::swap(model.allocated[engine() % model.allocated.size()], model.allocated.back());
            auto& [first, count] = model.allocated.back();
            const uint32_t part = engine() % 4 ? count : 1;  // of those that were taken together, some
            model.Free(first, part);
            first += part;
            count -= part;
            if (count == 0) model.allocated.pop_back();
        }
        for (const auto& [first, count] : model.allocated) model.Free(first, count);
        EXPECT_EQ(model.ranges.End(), 0u);
    }
}

TEST(SlotRanges, NeighborsThatAreFreeBecomeOneRange) {
    SlotRanges ranges;
    EXPECT_EQ(ranges.Allocate(0), 0u);
    EXPECT_EQ(ranges.Allocate(10), 0u);
    ranges.Free(2, 2);
    ranges.Free(6, 2);
    ranges.Free(4, 2);
    EXPECT_EQ(ranges.End(), 10u);
    EXPECT_EQ(ranges.Allocate(7), 10u);
    EXPECT_EQ(ranges.Allocate(6), 2u);
    ranges.Free(0, 17);
    EXPECT_EQ(ranges.End(), 0u);
    EXPECT_EQ(ranges.Allocate(17), 0u) << "as if new";
}

TEST(SlotRanges, WithoutMemoryNothingIsTaken) {
    SlotRanges ranges;
    ranges.Allocate(100);
    ranges.Free(10, 5);
    {
        const FailingMemory failing(0);
        EXPECT_THROW(ranges.Allocate(1000), std::bad_alloc);
        EXPECT_EQ(ranges.Allocate(5), 10u) << "needs none";
        ranges.Free(40, 2);
    }
    EXPECT_THROW(ranges.Allocate(~0u), std::length_error);
    EXPECT_EQ(ranges.End(), 100u);
    EXPECT_EQ(ranges.TakenCount(), 98u);
    EXPECT_EQ(ranges.Allocate(1000), 100u);
}

}  // namespace raygraph::testing::slot_ranges_test

// The order in which builders get triangles and instances.
namespace raygraph::testing::spatial_order_test {
namespace {

using glm::vec3;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

void ExpectEachOnce(std::vector<uint32_t> order, size_t count) {
    std::ranges::sort(order);
    ASSERT_EQ(order.size(), count);
    for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(order[i], i);
}

std::vector<vec3> ShuffledGrid(uint32_t side) {
    std::vector<vec3> places;
    for (uint32_t i = 0; i < side * side * side; ++i)
        places.emplace_back(float(i % side), float(i / side % side), float(i / side / side));
    std::ranges::shuffle(places, std::mt19937(1));
    return places;
}

// This tells the curve from others: each cell is beside the one before, on every level of the grid.
TEST(SpatialOrder, GoesFromCellToNeighbor) {
    for (const uint32_t side : {2u, 8u, 32u}) {
        const std::vector<vec3> places = ShuffledGrid(side);
        const std::vector<uint32_t> order = SpatialOrder(places);
        ExpectEachOnce(order, places.size());
        for (size_t i = 1; i < order.size(); ++i)
            ASSERT_EQ(glm::distance(places[order[i]], places[order[i - 1]]), 1.0f) << side << ": " << i;
    }
}

// Steps of 2^-21 of the extent on all axes: cells that a coarser curve would take for one.
TEST(SpatialOrder, TellsTheFinestStepsApart) {
    constexpr float kFarAway = (1u << 21) - 1;
    std::vector<vec3> places = ShuffledGrid(8);
    places.emplace_back(kFarAway);
    const std::vector<uint32_t> order = SpatialOrder(places);
    ExpectEachOnce(order, places.size());
    EXPECT_EQ(order.back(), 512u);
    for (size_t i = 1; i + 1 < order.size(); ++i)
        ASSERT_EQ(glm::distance(places[order[i]], places[order[i - 1]]), 1.0f) << i;
}

TEST(SpatialOrder, OneThatIsFarAwayLeavesTheOrderOfTheOthers) {
    std::vector<vec3> places;
    for (uint32_t i = 0; i < 1000; ++i)
        places.emplace_back(float(i * 37 % 10), float(i * 37 / 10 % 10), float(i * 37 / 100 % 10));
    places.emplace_back(1e5f, -1e5f, 3e5f);
    const std::vector<uint32_t> order = SpatialOrder(places);
    ExpectEachOnce(order, places.size());
    double way = 0.0;
    for (size_t i = 1; i < order.size(); ++i)
        if (order[i] != 1000 && order[i - 1] != 1000)
            way += glm::distance(places[order[i]], places[order[i - 1]]);
    EXPECT_LT(way / 1000.0, 1.5) << "from each to the next";
}

TEST(SpatialOrder, DegenerateBoundsKeepWhatTheyTell) {
    EXPECT_TRUE(SpatialOrder({}).empty());
    EXPECT_EQ(SpatialOrder(std::vector<vec3>{{3, 4, 5}}), std::vector<uint32_t>{0});
    // All at one place, and at the ends of the range of floats: as they came
    for (const vec3 place : {vec3(0.0f), vec3(-7.0f, 1e-38f, 3e38f)})
        EXPECT_EQ(SpatialOrder(std::vector<vec3>(3, place)), (std::vector<uint32_t>{0, 1, 2}));
    // On a line, near which the curve passes in parts
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<vec3> line(128, vec3(-2.0f));
        for (uint32_t i = 0; i < line.size(); ++i) line[i][axis] = float(i * 37 % 128);
        const std::vector<uint32_t> order = SpatialOrder(line);
        ExpectEachOnce(order, line.size());
        float way = 0.0f;
        for (size_t i = 1; i < order.size(); ++i) way += glm::distance(line[order[i]], line[order[i - 1]]);
        EXPECT_LT(way, 4.0f * 128.0f) << axis;
    }
}

TEST(SpatialOrder, WhatIsNotFiniteIsAmongTheNearestAndBoundsNothing) {
    std::vector<vec3> places{{kNan, kNan, kNan}, {kInfinity, kInfinity, kInfinity}, {-kInfinity, kNan, 0}};
    const std::vector<vec3> grid = ShuffledGrid(4);
    places.insert(places.end(), grid.begin(), grid.end());
    std::vector<uint32_t> order = SpatialOrder(places);
    ExpectEachOnce(order, places.size());
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(order[i], i) << "beside the lowest, as they came";
    EXPECT_EQ(places[order[3]], vec3(0.0f));
    for (size_t i = 4; i < order.size(); ++i)
        ASSERT_EQ(glm::distance(places[order[i]], places[order[i - 1]]), 1.0f);
}

TEST(SpatialOrder, TrianglesFollowTheirCenters) {
    const std::vector<vec3> places = ShuffledGrid(4);
    std::vector<vec3> positions;
    std::vector<uint32_t> indices(3 * places.size());
    for (const vec3& place : places)
        for (const vec3& corner : {vec3(0), vec3(0.3f, 0, 0), vec3(0, 0.3f, 0)})
            positions.push_back(place + corner);
    std::iota(indices.begin(), indices.end(), 0u);
    const std::vector<uint32_t> originals = SortTriangles(positions, indices);
    ExpectEachOnce(originals, places.size());
    for (uint32_t i = 0; i < originals.size(); ++i) {
        for (uint32_t corner = 0; corner < 3; ++corner)
            ASSERT_EQ(indices[3 * i + corner], 3 * originals[i] + corner);
        if (i > 0) {
            ASSERT_EQ(glm::distance(places[originals[i]], places[originals[i - 1]]), 1.0f) << i;
        }
    }
    EXPECT_TRUE(SortTriangles(positions, indices).empty()) << "nothing to do";
}

}  // namespace
}  // namespace raygraph::testing::spatial_order_test

// The tree that stands for a driver's: exact after any changes, and the rule by which a TLAS is rebuilt.
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

TEST(BoxTree, AroundAllBut_LeavesOutTheGivenLeavesAlone) {
    std::mt19937 engine(7);
    std::uniform_real_distribution<float> random(-10.0f, 10.0f);
    for (const size_t count : {1u, 8u, 9u, 65u, 600u}) {
        std::vector<scene::Bounds> boxes;
        for (size_t i = 0; i < count; ++i)
            boxes.push_back(BoxAt(vec3(random(engine), random(engine), random(engine))));
        BoxTree tree;
        tree.Assign(boxes);
        for (size_t left = 0; left < 12; ++left) {
            std::vector<size_t> leaves;
            for (size_t i = 0; i < left; ++i) leaves.push_back(engine() % count);
            scene::Bounds expected;
            for (size_t i = 0; i < count; ++i)
                if (std::ranges::count(leaves, i) == 0) expected.Extend(boxes[i]);
            const scene::Bounds actual = tree.AroundAllBut(leaves);
            EXPECT_EQ(actual.min, expected.min) << count << " without " << left;
            EXPECT_EQ(actual.max, expected.max) << count << " without " << left;
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

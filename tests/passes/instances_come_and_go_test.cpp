// Instances that are added and removed: after any changes, what rays and shading find is what there is.
#include <optional>

#include "tests/passes/instance_grid.h"
#include "tests/support/error_of.h"
#include "tests/support/failing_memory.h"

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

// Instances that are moved, shown and hidden: the least work for the TLAS, by a rule, and nothing is lost.
#include <algorithm>
#include <numeric>
#include <random>

#include "tests/passes/instance_grid.h"
#include "tests/support/error_of.h"
#include "tests/support/failing_memory.h"

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

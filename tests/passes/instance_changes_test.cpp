// Instances that are moved, shown and hidden: the least work for the TLAS, by a rule, and nothing is lost.
#include <algorithm>
#include <numeric>
#include <random>

#include "renderer/graph/readback_values.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {
namespace {

constexpr uint32_t kSide = 20;
constexpr uint32_t kCount = kSide * kSide;
constexpr uint32_t kMiss = 0xFFFFFFFFu;

glm::vec3 Place(uint32_t cell) {
    return {float(cell % kSide) + 0.5f, float(cell / kSide) + 0.5f, 0.0f};
}

// A box, and beside it a leaf: of another group.
scene::Mesh BoxWithLeaf() {
    scene::Mesh mesh = BoxMesh(0.3f);
    scene::Primitive leaf = QuadMesh(0.05f, 1).primitives[0];
    leaf.bounds = {};
    for (glm::vec3& position : leaf.positions) {
        position += glm::vec3(0.4f, 0.4f, 0.0f);
        leaf.bounds.Extend(position);
    }
    leaf.colors.assign(4, glm::vec4(1.0f));
    leaf.colors[0].a = 0.0f;
    mesh.primitives.insert(mesh.primitives.begin(), leaf);
    return mesh;
}

// Boxes on a square grid, seen from above: a pixel a cell. Every other one has a leaf.
class InstanceChanges : public VulkanTest {
  protected:
    explicit InstanceChanges(TlasRule rule = TlasRule::Decay)
        : render(Device(), {.tlasRule = rule}), cellOf(kCount), isHidden(kCount) {
        std::iota(cellOf.begin(), cellOf.end(), 0u);
        scene::SceneData scene =
            SceneOf({BoxMesh(0.3f), BoxWithLeaf()}, {Lambert(glm::vec3(0.5f)), Lambert(glm::vec3(0.5f))});
        scene.materials[1].alphaMode = scene::AlphaMode::Mask;
        scene.instances.clear();
        for (uint32_t i = 0; i < kCount; ++i)
            scene.instances.push_back({.mesh = i % 2, .objectToWorld = Translation(Place(i))});
        render.scene.SetScene(std::move(scene));
        for (int frame = 0; frame < 8; ++frame) Seen();
        EXPECT_TRUE(render.scene.IsSettled());
    }
    static passes::TraceSettings View() {
        scene::CameraView view = scene::CameraView::LookAt({0.5f * kSide, 0.5f * kSide, 5},
                                                           {0.5f * kSide, 0.5f * kSide, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = float(kSide);
        passes::TraceSettings settings;
        settings.extent = {kSide, kSide};
        settings.camera = ToRecord(view);
        return settings;
    }
    // By cell.
    std::vector<uint32_t> Seen() {
        const SceneRender::Hits hits = render.PrimaryHits(View());
        std::vector<uint32_t> seen(kCount);
        for (uint32_t i = 0; i < kCount; ++i)
            seen[i] = hits.ids[(kSide - 1 - i / kSide) * kSide + i % kSide].x;
        return seen;
    }
    std::vector<uint32_t> Expected() const {
        std::vector<uint32_t> expected(kCount, kMiss);
        for (uint32_t i = 0; i < kCount; ++i)
            if (!isHidden[i]) expected[cellOf[i]] = i;
        return expected;
    }
    // Exchanges the places of two instances, so many times.
    void Scatter(uint32_t pairs) {
        for (uint32_t i = 0; i < pairs; ++i) {
            const auto a = static_cast<uint32_t>(engine() % kCount),
                       b = static_cast<uint32_t>(engine() % kCount);
            std::swap(cellOf[a], cellOf[b]);
            for (const uint32_t moved : {a, b})
                render.scene.SetTransform(moved, Translation(Place(cellOf[moved])));
        }
    }
    void Toggle(uint32_t instance) {
        isHidden[instance] = !isHidden[instance];
        render.scene.SetVisible(instance, !isHidden[instance]);
    }
    std::vector<gpu::InstanceRecord> Records() {
        render.renderer.BeginFrame();
        const Readback records = render.renderer.ReadBack(render.scene.Declare(render.renderer).instances);
        render.renderer.Execute();
        return WaitForValues<gpu::InstanceRecord>(records);
    }
    TlasWork LastWork() { return render.scene.Statistics().lastTlasWork; }

    SceneRender render;
    std::vector<uint32_t> cellOf;
    std::vector<bool> isHidden;
    std::mt19937 engine{7};
};

class UpdatesOnly : public InstanceChanges {
  protected:
    UpdatesOnly() : InstanceChanges(TlasRule::Never) {}
};

class RebuildsOnly : public InstanceChanges {
  protected:
    RebuildsOnly() : InstanceChanges(TlasRule::Always) {}
};

}  // namespace

// One copy a record, a scattering pass, or a copy of all: what rays see, and what shading reads.
TEST_F(UpdatesOnly, FewManyAndAllChangesAreSeen) {
    for (const uint32_t pairs : {1u, 3u, 40u, 90u, 400u}) {
        SCOPED_TRACE(pairs);
        Scatter(pairs);
        for (uint32_t i = 0; i < pairs; i += 3) Toggle(i);
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

TEST_F(RebuildsOnly, NothingButChangesIsRebuilt) {
    Scatter(1);
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::Rebuild);
    EXPECT_EQ(Seen(), Expected());
    EXPECT_EQ(LastWork(), TlasWork::None);
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

}  // namespace raygraph::testing

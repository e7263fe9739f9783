// A frame that fails while it is recorded leaves nothing behind: the next one shows, and counts, what it
// would have without it.
#include <stdexcept>

#include "renderer/graph/pass_harness.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::dropped_frame_test {

using passes::Accumulation;
using passes::ResetCause;

namespace {

// A pass after all others that cannot be recorded.
void AddFailingPass(Renderer& renderer) {
    renderer.AddPass(
        "Fails", PassKind::Transfer, [](PassBuilder& pass) { pass.KeepAlive(); },
        [](CommandList&) { throw std::runtime_error("the pass fails"); });
}

// Orthographic, looking down on x = -1, 0, 1.
passes::TraceSettings ThreePixels() {
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 1.0f;
    view.aspect = 3.0f;
    passes::TraceSettings settings;
    settings.extent = {3, 1};
    settings.camera = ToRecord(view);
    return settings;
}

constexpr uint32_t kMiss = 0xFFFFFFFFu;
using Seen3 = std::array<uint32_t, 3>;

Seen3 Seen(SceneRender& render) {
    const SceneRender::Hits hits = render.PrimaryHits(ThreePixels());
    return {hits.ids[0].x, hits.ids[1].x, hits.ids[2].x};
}

// The same edits twice, the second time with a failing frame before each good one.
class DroppedSceneFrameTest : public VulkanTest {
  protected:
    static void Fail(SceneRender& render) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback radiance =
            render.renderer.ReadBack(passes::Trace(render.renderer, ids, ThreePixels()).radiance);
        AddFailingPass(render.renderer);
        EXPECT_THROW(render.renderer.Execute(), std::runtime_error);
    }
    // A good frame of each; returns what both have seen.
    Seen3 Frame() {
        const Seen3 expected = Seen(undisturbed);
        Fail(disturbed);
        EXPECT_EQ(Seen(disturbed), expected);
        ExpectSameStatistics();
        return expected;
    }
    void Settle() {
        for (int frame = 0; frame < 8; ++frame) {
            Seen(undisturbed);
            Seen(disturbed);
        }
        ASSERT_TRUE(undisturbed.scene.IsSettled());
        ASSERT_TRUE(disturbed.scene.IsSettled());
    }
    template <typename Edit>
    void Both(Edit&& edit) {
        edit(undisturbed.scene);
        edit(disturbed.scene);
    }
    void ExpectSameStatistics() {
        const GpuSceneStatistics& expected = undisturbed.scene.Statistics();
        const GpuSceneStatistics& actual = disturbed.scene.Statistics();
        EXPECT_EQ(actual.blasBuilds, expected.blasBuilds);
        EXPECT_EQ(actual.blasCount, expected.blasCount);
        EXPECT_EQ(actual.blasBytesBuilt, expected.blasBytesBuilt);
        EXPECT_EQ(actual.tlasRebuilds, expected.tlasRebuilds);
        EXPECT_EQ(actual.tlasUpdates, expected.tlasUpdates);
        EXPECT_EQ(actual.lastTlasWork, expected.lastTlasWork) << Name(actual.lastTlasWork);
    }
    static scene::SceneData TwoBoxes() {
        return SceneOf({BoxMesh(0.3f), BoxMesh(0.3f)}, {Lambert(glm::vec3(0.5f), glm::vec3(1.0f))},
                       {Translation({-1, 0, 0}), Translation({1, 0, 0})});
    }

    SceneRender undisturbed{Device()};
    SceneRender disturbed{Device()};
};

class DroppedAccumulationTest : public VulkanTest {
  protected:
    static constexpr Extent2D kExtent{2, 1};

    Texels Add(float value, bool withVariance = false, Extent2D extent = kExtent, bool fails = false) {
        return harness.Run([&](PassHarness& h) {
            const TextureId sample = h.Texture("sample", extent, Format::Rgba32Float, {value, 0, 0, 1});
            const passes::AccumulatedIds ids =
                passes::Accumulate(h.Graph(), sample, accumulation, withVariance);
            if (fails) AddFailingPass(h.Graph());
            return ids.mean;
        });
    }
    void FailToAdd(float value, bool withVariance = false, Extent2D extent = kExtent) {
        EXPECT_THROW(Add(value, withVariance, extent, true), std::runtime_error);
    }

    PassHarness harness{Device()};
    Accumulation accumulation{"image"};
};

}  // namespace

TEST_F(DroppedSceneFrameTest, BuildsAreRecordedAgain) {
    Both([](GpuScene& scene) { scene.SetScene(TwoBoxes()); });
    EXPECT_EQ(Frame(), (Seen3{0, kMiss, 1}));
    Settle();
    ExpectSameStatistics();
}

TEST_F(DroppedSceneFrameTest, MovedInstancesStayMoved) {
    Both([](GpuScene& scene) { scene.SetScene(TwoBoxes()); });
    Settle();
    Both([](GpuScene& scene) { scene.SetTransform(1, Translation({0, 0, 0})); });
    EXPECT_EQ(Frame(), (Seen3{0, 1, kMiss}));
    EXPECT_EQ(disturbed.scene.Statistics().lastTlasWork, TlasWork::Update);
}

TEST_F(DroppedSceneFrameTest, HiddenInstancesStayHidden) {
    Both([](GpuScene& scene) { scene.SetScene(TwoBoxes()); });
    Settle();
    Both([](GpuScene& scene) { scene.SetVisible(0, false); });
    EXPECT_EQ(Frame(), (Seen3{kMiss, kMiss, 1}));
}

TEST_F(DroppedSceneFrameTest, LastTlasWorkIsThatOfTheLastSubmittedFrame) {
    Both([](GpuScene& scene) { scene.SetScene(TwoBoxes()); });
    Settle();
    Both([](GpuScene& scene) { scene.SetTransform(1, Translation({0, 0, 0})); });
    EXPECT_EQ(Frame(), (Seen3{0, 1, kMiss}));
    Fail(disturbed);  // would have had nothing to do
    EXPECT_EQ(disturbed.scene.Statistics().lastTlasWork, TlasWork::Update);
}

TEST_F(DroppedSceneFrameTest, ChangedMaterialsStayChanged) {
    Both([](GpuScene& scene) {
        scene.SetScene(SceneOf({QuadMesh(5.0f)}, {Lambert(glm::vec3(0.0f), glm::vec3(1.0f))}));
    });
    Settle();
    Both([](GpuScene& scene) { scene.SetMaterial(0, Lambert(glm::vec3(0.0f), glm::vec3(4.0f))); });
    Fail(disturbed);
    EXPECT_EQ(glm::vec3(disturbed.TraceOnce(ThreePixels()).At(0, 0)), glm::vec3(4.0f));
    EXPECT_EQ(glm::vec3(undisturbed.TraceOnce(ThreePixels()).At(0, 0)), glm::vec3(4.0f));
}

TEST_F(DroppedAccumulationTest, SampleIsNotCounted) {
    Add(2.0f);
    FailToAdd(100.0f);
    EXPECT_EQ(accumulation.SampleCount(), 1u);
    EXPECT_EQ(Add(4.0f).At(0, 0)[0], 3.0f);
    EXPECT_EQ(accumulation.SampleCount(), 2u);
}

TEST_F(DroppedAccumulationTest, FirstVarianceOfADroppedFrameKeepsTheSamples) {
    Add(2.0f);
    FailToAdd(100.0f, true);
    EXPECT_EQ(accumulation.ResetCount(ResetCause::Settings), 0u);
    EXPECT_EQ(Add(4.0f).At(0, 0)[0], 3.0f);
    EXPECT_EQ(accumulation.SampleCount(), 2u);
}

TEST_F(DroppedAccumulationTest, ResizeOfADroppedFrameKeepsTheSamples) {
    Add(2.0f);
    FailToAdd(100.0f, false, {5, 5});
    EXPECT_EQ(accumulation.ResetCount(ResetCause::Resize), 0u);
    EXPECT_EQ(Add(4.0f).At(0, 0)[0], 3.0f);
    EXPECT_EQ(accumulation.SampleCount(), 2u);
}

TEST_F(DroppedAccumulationTest, RestoreOfADroppedFrameRestoresNothing) {
    passes::ExactSums stored = passes::MakeExactSums(2, false);
    for (int n = 0; n < 5; ++n) passes::AddSample(stored, std::vector<float>(8, 9.0f));
    const auto restore = [&](bool fails) {
        harness.Run([&](PassHarness& h) {
            passes::Restore(h.Graph(), accumulation, kExtent, 5, stored);
            if (fails) AddFailingPass(h.Graph());
            return h.Texture("nothing", {1, 1}, Format::R32Float, {0.0f});
        });
    };
    Add(2.0f);
    EXPECT_THROW(restore(true), std::runtime_error);
    EXPECT_EQ(accumulation.SampleCount(), 1u);
    EXPECT_EQ(Add(4.0f).At(0, 0)[0], 3.0f);
    restore(false);
    EXPECT_EQ(accumulation.SampleCount(), 5u);
    EXPECT_EQ(Add(3.0f).At(0, 0)[0], 8.0f);
}

TEST_F(DroppedAccumulationTest, ResetAfterTheDeclarationIsKept) {
    Add(2.0f);
    harness.Run([&](PassHarness& h) {
        const TextureId sample = h.Texture("sample", kExtent, Format::Rgba32Float, {4, 0, 0, 1});
        const passes::AccumulatedIds ids = passes::Accumulate(h.Graph(), sample, accumulation);
        accumulation.Reset(ResetCause::Camera);
        return ids.mean;
    });
    EXPECT_EQ(accumulation.SampleCount(), 0u) << "the frame's sample joined what was given up";
    EXPECT_EQ(Add(7.0f).At(0, 0)[0], 7.0f);
    EXPECT_EQ(accumulation.SampleCount(), 1u);
}

}  // namespace raygraph::testing::dropped_frame_test

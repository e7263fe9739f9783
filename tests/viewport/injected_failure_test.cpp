// A few failing Vulkan calls over the lifetime of renderer, scene and viewport; the kind `long` has
// each.
#include "passes/trace.h"
#include "tests/support/error_of.h"
#include "tests/support/failure_sweep.h"

namespace raygraph::testing::injected_failure_test {
namespace {

// Primes: neighboring steps differ in what they meet.
TEST(InjectedFailure, RendererWithoutMemory_DropsTheFrameAndGoesOn) {
    EXPECT_GT(SweepOutOfMemory(RendererScenario(), {}, false, 47), 10u);
}

TEST(InjectedFailure, ViewportWithoutMemory_DropsTheFrameAndGoesOn) {
    EXPECT_GT(SweepOutOfMemory(ViewportScenario(), FailingCall::Allocation, true, 29), 10u);
}

TEST(InjectedFailure, LostDevice_IsToldByEveryCall) {
    EXPECT_GT(SweepDeviceLoss(RendererScenario(), {}, 197), 1u);
}

// Ahead of its need: frames of others go on, and the one that needs it says what there was not.
TEST(InjectedFailure, PipelineThatCannotBeMade_IsNotThereAndFailsWhereItIsNeeded) {
    const static std::shared_ptr<rhi::VulkanLoader> system = rhi::VulkanLoader::Open();
    MessageLog log;
    InjectFailure({});
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.name = "failing",
                             .validation = true,
                             .log = log.Listener(),
                             .savePipelineCache = false,
                             .getInstanceProcAddr = FailingLoader(system->GetInstanceProcAddr())});
    {
        Renderer renderer(*device);
        GpuScene scene(renderer);
        scene.SetScene({});
        const auto declare = [&] {
            renderer.BeginFrame();
            const SceneIds ids = scene.Declare(renderer);
            const PassId first = renderer.NextPass();
            passes::TraceSettings settings;
            settings.extent = {8, 8};
            settings.form = passes::IntegratorForm::Wavefront;  // which has several pipelines
            renderer.Present(passes::Trace(renderer, ids, settings).radiance);
            return first;
        };
        const PassId first = declare();
        InjectFailure(InjectedFailure{.call = FailingCall::Creation, .lasts = true});
        while (!renderer.PreparePipelines(first, renderer.NextPass())) {
        }
        ClearInjectedFailure();
        EXPECT_TRUE(HasFailed());
        EXPECT_FALSE(renderer.HasPipelines(first, renderer.NextPass()));
        EXPECT_TRUE(renderer.PreparePipelines(first, renderer.NextPass())) << "nothing is left to wait for";
        EXPECT_EQ(ErrorOf([&] { renderer.Execute(); }).Kind(), ErrorKind::OutOfMemory);
        declare();
        EXPECT_NO_THROW(renderer.Execute()) << "all are made again";
    }
    EXPECT_EQ(log.Text(), "");
}

}  // namespace
}  // namespace raygraph::testing::injected_failure_test

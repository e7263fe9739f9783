// A few failing Vulkan calls over the lifetime of renderer, scene and viewport; the kind `long` has
// each.
#include "tests/support/failure_sweep.h"

namespace raygraph::testing {
namespace {

// Primes: neighboring steps differ in what they meet.
TEST(InjectedFailure, RendererWithoutMemory_DropsTheFrameAndGoesOn) {
    EXPECT_GT(SweepOutOfMemory(RendererScenario(), {}, false, 23), 20u);
}

TEST(InjectedFailure, ViewportWithoutMemory_DropsTheFrameAndGoesOn) {
    EXPECT_GT(SweepOutOfMemory(ViewportScenario(), FailingCall::Allocation, true, 13), 20u);
}

TEST(InjectedFailure, LostDevice_IsToldByEveryCall) {
    EXPECT_GT(SweepDeviceLoss(RendererScenario(), {}, 97), 4u);
}

}  // namespace
}  // namespace raygraph::testing

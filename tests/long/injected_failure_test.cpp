// Tests each Vulkan call that can fail over the lifetime of renderer, scene and viewport; `viewport` has
// some.
#include "tests/support/failure_sweep.h"

namespace raygraph::testing::injected_failure_test {
namespace {

using Make = SweepScenario (*)();

class EachFailure : public ::testing::TestWithParam<std::tuple<Make, FailingCall>> {
  protected:
    SweepScenario Scenario() const { return std::get<0>(GetParam())(); }
    FailingCall Call() const { return std::get<1>(GetParam()); }
};

std::string NameOf(const ::testing::TestParamInfo<EachFailure::ParamType>& info) {
    const bool isRenderer = std::get<0>(info.param) == Make(RendererScenario);
    return std::string(isRenderer ? "renderer_" : "viewport_") + Name(std::get<1>(info.param));
}

TEST_P(EachFailure, OutOfMemory_DropsTheFrameAndGoesOn) {
    EXPECT_GT(SweepOutOfMemory(Scenario(), Call(), false, 1), 4u);
}

TEST_P(EachFailure, MemoryThatStaysSpent_DropsTheFrameAndGoesOn) {
    EXPECT_GT(SweepOutOfMemory(Scenario(), Call(), true, 1), 4u);
}

TEST_P(EachFailure, LostDevice_IsToldByEveryCall) {
    EXPECT_GT(SweepDeviceLoss(Scenario(), Call(), 1), 4u);
}

INSTANTIATE_TEST_SUITE_P(In, EachFailure,
                         ::testing::Combine(::testing::Values(RendererScenario, ViewportScenario),
                                            ::testing::ValuesIn(kFailingCalls)),
                         NameOf);

}  // namespace
}  // namespace raygraph::testing::injected_failure_test

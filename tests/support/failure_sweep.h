// A life of renderer, scene and viewport in which one call of Vulkan fails: what has to hold wherever it
// does.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "editor/viewport/viewport.h"
#include "passes/accumulate.h"
#include "tests/support/failing_vulkan.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

// Holds all that a scenario makes; it is destroyed in reverse order.
struct SweepFixture {
    using Picture = std::vector<std::byte>;

    MessageLog log;
    std::unique_ptr<rhi::Device> device;
    passes::Accumulation accumulation{"swept"};
    std::optional<Renderer> renderer;
    std::optional<GpuScene> scene;
    std::optional<viewport::Viewport> viewport;
    scene::CameraView camera;
    AddedPart part;
    Readback readback;              // of the last executed frame
    std::vector<Picture> pictures;  // in the order in which they were read
};

// A step can be taken again after an Error{OutOfMemory}, as if it had not been tried.
struct SweepStep {
    std::string name;
    std::function<void(SweepFixture&)> run;
    // The scene of before stays open if the step fails, and a frame shows it.
    bool keepsScene = false;
};

using SweepScenario = std::vector<SweepStep>;
SweepScenario RendererScenario();  // path tracing by passes, edits, a part that comes and goes, another scene
SweepScenario ViewportScenario();  // both views, and both in one picture, picked from and captured

// Out of memory in every stride-th call of each step, or of one kind: the failure is injected, the step
// tried, and taken again with the next call failing, until none does. It has to fail by Error{OutOfMemory},
// or do without the call. What was open stays open, and in the end the pictures are those of a run without
// failures. `lasts`: all calls after the one fail, too. Returns the number of failures.
uint32_t SweepOutOfMemory(const SweepScenario& scenario, std::optional<FailingCall> call, bool lasts,
                          uint64_t stride);

// The device is lost in every stride-th call, one life for each: that step or a later one fails by
// Error{DeviceLost}, and so does everything that needs the device from then on. Returns the number of losses.
uint32_t SweepDeviceLoss(const SweepScenario& scenario, std::optional<FailingCall> call, uint64_t stride);

}  // namespace raygraph::testing

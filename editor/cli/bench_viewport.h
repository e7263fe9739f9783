// Compares a host's viewport with the frames of a render, by the cost of their samples.
#pragma once

#include <vector>

#include "editor/cli/bench_run.h"
#include "editor/session/settings/scene_input.h"

namespace raygraph::cli {

// The cost of one sample of every pixel, with everything else in its frames, as means over all rounds.
struct SampleCost {
    double cpuSeconds = 0.0;  // processor time of the process
    double gpuMs = 0.0;       // sum of all passes; 0 without timestamps
    double wallMs = 0.0;
    double samplesPerFrame = 0.0;
    double relative = 0.0;  // to a sample of a render: median of the rounds
    RelativeCost cost;      // the render's cost (BenchResult) times `relative`
};

struct ViewportCosts {
    double budgetMs = 0.0;
    SampleCost render;             // reference of `relative`
    SampleCost oneSamplePerFrame;  // a viewport that shows every sample, without a budget
    SampleCost withinBudget;       // a viewport with a budget of budgetMs, while nothing changes
};

// Runs frames of a render, of a viewport and of a viewport with a budget in turns, in which each takes at
// least plan.frames samples. The viewports show `data` by a GpuScene, with a host's default settings. `cost`
// is the render's, from BenchResult.
ViewportCosts BenchViewport(session::DeviceScene& render, scene::SceneData&& data,
                            const session::PictureSettings& settings, const BenchPlan& plan,
                            const RelativeCost& cost, double budgetMs, Progress& progress);

}  // namespace raygraph::cli

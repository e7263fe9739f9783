// Times what a host's viewport gets of the path tracer, against the frames of a render.
#pragma once

#include <vector>

#include "editor/cli/bench_run.h"
#include "editor/session/scene_input.h"

namespace raygraph::cli {

// What one sample of every pixel costs, with all that frames do beside it: means over all rounds.
struct SampleCost {
    double cpuSeconds = 0.0;  // of the process
    double gpuMs = 0.0;       // of all passes; 0 on a device without timestamps
    double wallMs = 0.0;
    double samplesPerFrame = 0.0;
    double relative = 0.0;  // to a sample of a render: the median of the rounds
    RelativeCost cost;      // that of the render's frames, as BenchResult has it, times that
};

struct ViewportCosts {
    double budgetMs = 0.0;
    SampleCost render;        // relative to itself
    SampleCost oneAFrame;     // a viewport that shows every sample, without a budget
    SampleCost withinBudget;  // one with a budget of that many milliseconds, while nothing changes
};

// `cost`: of the render, as BenchResult has it. Frames of a render, of a viewport and of a viewport with a
// budget in turns, in which each takes at least plan.frames samples. The viewports show `data` by a GpuScene
// and settings as a host has them that sets nothing else.
ViewportCosts BenchViewport(session::DeviceScene& render, scene::SceneData&& data,
                            const session::PictureSettings& settings, const BenchPlan& plan,
                            const RelativeCost& cost, double budgetMs, Progress& progress);

}  // namespace raygraph::cli

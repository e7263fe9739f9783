// Measurements of `bench`: the passes of a path-traced frame against the cost of tracing alone on this
// device, and a host's viewport against the frames of a render.
#pragma once

#include <optional>
#include <vector>

#include "editor/cli/bench_compare.h"
#include "editor/cli/progress.h"
#include "editor/session/frames/device_scene.h"
#include "editor/session/frames/pass_times.h"
#include "editor/session/settings/scene_input.h"

namespace raygraph::cli {

struct BenchPlan {
    uint32_t frames = 1;  // timed frames of each kind per round
    uint32_t rounds = 1;
    uint32_t batchSize = 0;  // per pixel in a path-traced frame; 0: as a render does
};

struct TracingSpeed {
    double gpuMsMedian = 0.0;    // GPU time of the pass
    double raysPerSample = 0.0;  // mean over the pixels, for one sample
    double raysPerSecond = 0.0;
};

// Compares the same paths by a loop in ray generation and by recursion from closest hit (passes/limit.h).
struct RecursionSpeed {
    double loopMs = 0.0;  // medians of GPU times
    // Is none if the device cannot trace so deep.
    std::optional<double> recursiveMs;
    std::optional<double> loopSpeedup;  // recursiveMs / loopMs
};

struct BenchResult {
    uint32_t frames = 0;                    // timed for each median
    uint32_t batchSize = 0;                 // per path-traced frame
    std::vector<session::PassTime> passes;  // passes of whole frames
    TracingSpeed trace;                     // one sample
    TracingSpeed limit;                     // camera rays alone
    TracingSpeed limitPath;                 // four more cosine bounces, without shading
    double traceEfficiency = 0.0;           // rays per second of trace, relative to limitPath
    // Uses software traversal; none: the scene has no trees for it, or the driver was chosen.
    std::optional<TracingSpeed> limitPathOwn;
    std::optional<double> traceEfficiencyOwn;
    RelativeCost cost;  // cost of whole path-traced frames relative to frames of limitPath
    RecursionSpeed recursion;
    double secondsPerSample = 0.0;  // mean wall-clock time of whole path-traced frames
    double samplesPerSecond = 0.0;
    // Is relative to the processor time of the whole process: the rate of a CPU driver per core.
    double samplesPerCpuSecond = 0.0;
};

// Runs rounds of frames of each kind in turn, so that other load on the machine affects all kinds alike; the
// first frames of each kind warm up and are not counted. GPU times need a device with timestamps: throws
// Error{Vulkan} without them.
BenchResult RunBench(session::DeviceScene& scene, const BenchPlan& plan, Progress& progress);

// --- A host's viewport against the frames of a render, by the cost of their samples ---

// Holds the cost of one sample of every pixel, with everything else in its frames, as means over all rounds.
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

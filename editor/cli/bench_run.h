// Times the passes of a path-traced frame against the cost of tracing alone on this device.
#pragma once

#include <optional>
#include <vector>

#include "editor/cli/bench_compare.h"
#include "editor/cli/progress.h"
#include "editor/session/device_scene.h"
#include "editor/session/pass_times.h"

namespace raygraph::cli {

struct BenchPlan {
    uint32_t frames = 1;  // timed ones of each kind in a round
    uint32_t rounds = 1;
    uint32_t samplesAtOnce = 0;  // of every pixel in a path-traced frame; 0: as a render does
};

struct TracingSpeed {
    double gpuMsMedian = 0.0;    // of its pass
    double raysPerSample = 0.0;  // mean over pixels of one sample
    double raysPerSecond = 0.0;
};

// The same paths by a loop in ray generation and by recursion from the closest hit (passes/recursion.h).
struct RecursionSpeed {
    double loopMs = 0.0;  // GPU times, medians
    // None: the device does not trace as deep.
    std::optional<double> recursiveMs;
    std::optional<double> loopSpeedup;  // recursiveMs over loopMs
};

struct BenchResult {
    uint32_t frames = 0;                    // behind each median
    uint32_t samplesAtOnce = 0;             // in each path-traced one
    std::vector<session::PassTime> passes;  // of whole frames
    TracingSpeed trace;                     // of one sample
    TracingSpeed limit;                     // camera rays alone
    TracingSpeed limitPath;                 // four cosine bounces more, no shading
    double traceEfficiency = 0.0;           // rays per second of trace over those of limitPath
    // By own traversal; none: the scene has no trees for it, or the driver's was asked for.
    std::optional<TracingSpeed> limitPathOwn;
    std::optional<double> traceEfficiencyOwn;
    RelativeCost cost;  // of whole path-traced frames, in frames of limitPath
    RecursionSpeed recursion;
    double secondsPerSample = 0.0;  // of whole path-traced frames, wall clock, mean
    double samplesPerSecond = 0.0;
    // Over the processor time of the whole process: what a CPU driver achieves per core.
    double samplesPerCpuSecond = 0.0;
};

// Rounds of frames of each kind in turn, so that other load on the machine affects all kinds alike; the first
// frames of each kind warm up and are not counted. GPU times need a device with timestamps: Error{Vulkan}
// without them.
BenchResult RunBench(session::DeviceScene& scene, const BenchPlan& plan, Progress& progress);

}  // namespace raygraph::cli

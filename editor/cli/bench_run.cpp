#include "editor/cli/bench_run.h"

#include <functional>
#include <numeric>

#include "base/os.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/session/settings/tracing_choice.h"
#include "passes/accumulate.h"
#include "passes/limit.h"
#include "passes/recursion.h"
#include "passes/tonemap.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::cli {

using namespace session;  // NOLINT

namespace {

constexpr uint32_t kWarmUpFrames = 3;

// Declares the passes of one frame and presents their result.
using DeclareFrame = std::function<void(const SceneIds& ids, const passes::TraceSettings& settings)>;

// Returns the mean of a readback of floats.
double MeanOf(const Readback& readback) {
    const std::vector<float> values = WaitForValues<float>(readback);
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

class Bench {
  public:
    explicit Bench(DeviceScene& scene) : m_scene(scene), m_renderer(scene.GraphRenderer()) {}

    // Runs `count` frames of this kind with `samples` each; returns when the device is idle.
    void RunFrames(const DeclareFrame& declare, uint32_t count, uint32_t samples = 1) {
        uint64_t last = 0;
        for (uint32_t i = 0; i < count; ++i) {
            m_renderer.BeginFrame();
            const SceneIds ids = m_scene.Declare(m_sampleIndex);
            passes::TraceSettings settings = m_scene.SettingsFor(m_sampleIndex);
            settings.sampleCount = samples;
            declare(ids, settings);
            m_sampleIndex += samples;
            last = m_renderer.Execute();
        }
        m_renderer.Device().WaitFor(last);
    }

    // Runs frames until shaders are compiled, the scene is built, and caches are warm; discards the times.
    void WarmUp(const DeclareFrame& declare, uint32_t samples = 1) {
        RunFrames(declare, kWarmUpFrames, samples);
        for (uint32_t i = 0; i < kMaxFramesToSettle && !m_scene.Scene().IsSettled(); ++i)
            RunFrames(declare, 1, samples);
        std::ignore = m_renderer.TakeTimings();
    }

    // Counts the rays of sample 0, so that programs that trace the same paths have equal counts, whatever was
    // rendered before. `countRays` adds the counting pass and sets the texture of its counts.
    double RaysPerSample(
        const std::function<void(const SceneIds&, const passes::TraceSettings&, TextureId&)>& countRays) {
        m_renderer.BeginFrame();
        const SceneIds ids = m_scene.Declare(0);
        TextureId counts;
        countRays(ids, m_scene.SettingsFor(0), counts);
        const Readback readback = m_renderer.ReadBack(counts);
        m_renderer.Execute();
        const double mean = MeanOf(readback);
        std::ignore = m_renderer.TakeTimings();
        return mean;
    }

    bool HasWideBvhs() {
        m_renderer.BeginFrame();
        const bool hasTrees = m_scene.Declare(m_sampleIndex).wideNodes.IsValid();
        m_renderer.Execute();
        return hasTrees;
    }
    Renderer& GraphRenderer() { return m_renderer; }

  private:
    static constexpr uint32_t kMaxFramesToSettle = 64;

    DeviceScene& m_scene;
    Renderer& m_renderer;
    uint32_t m_sampleIndex = 0;
};

RecursionSpeed RecursionOf(const PassTimes& times) {
    RecursionSpeed speed{.loopMs = times.MedianMs("LambertLoop"), .recursiveMs = {}, .loopSpeedup = {}};
    const double recursiveMs = times.MedianMs("LambertRecursive");
    if (recursiveMs > 0.0 && speed.loopMs > 0.0) {
        speed.recursiveMs = recursiveMs;
        speed.loopSpeedup = recursiveMs / speed.loopMs;
    }
    return speed;
}

// Returns the GPU time of everything in a frame, by the median of each pass.
double FrameMs(const PassTimes& times) {
    double sum = 0.0;
    for (const PassTime& pass : times.Summary()) sum += pass.gpuMsMedian;
    return sum;
}

TracingSpeed SpeedOf(double gpuMs, double raysPerSample, double pixels) {
    return {gpuMs, raysPerSample, gpuMs > 0.0 ? raysPerSample * pixels / (gpuMs * 1e-3) : 0.0};
}

}  // namespace

BenchResult RunBench(DeviceScene& scene, const BenchPlan& plan, Progress& progress) {
    Bench bench(scene);
    Renderer& renderer = bench.GraphRenderer();
    passes::Accumulation accumulation("radiance");
    const DeclareFrame picture = [&](const SceneIds& ids, const passes::TraceSettings& settings) {
        const TextureId sample = passes::Trace(renderer, ids, settings).radiance;
        const passes::AccumulatedIds sums =
            passes::Accumulate(renderer, sample, {.count = settings.sampleCount}, accumulation);
        renderer.Present(passes::Tonemap(renderer, sums.mean));
    };
    const auto limitOf = [&](passes::LimitKind kind) -> DeclareFrame {
        return [&renderer, kind](const SceneIds& ids, const passes::TraceSettings& settings) {
            renderer.Present(passes::Limit(renderer, ids, settings, kind));
        };
    };
    const auto lambertOf = [&](passes::PathForm form) -> DeclareFrame {
        return [&renderer, form](const SceneIds& ids, const passes::TraceSettings& settings) {
            renderer.Present(passes::LambertPath(renderer, ids, settings, form));
        };
    };
    constexpr size_t kLimitPath = 1;
    std::vector<DeclareFrame> yardsticks{limitOf(passes::LimitKind::CameraRays),
                                         limitOf(passes::LimitKind::Path), lambertOf(passes::PathForm::Loop)};
    if (bench.HasWideBvhs()) yardsticks.push_back(limitOf(passes::LimitKind::SoftwarePath));
    if (passes::CanRecurse(renderer.Device())) yardsticks.push_back(lambertOf(passes::PathForm::Recursive));

    const passes::TraceSettings traced = scene.SettingsFor(0);
    const uint32_t samples =
        plan.batchSize > 0 ? plan.batchSize : passes::PreferredBatchSize(renderer.Device(), traced);
    progress.ShowStep("warming up");
    bench.WarmUp(picture, samples);
    for (const DeclareFrame& yardstick : yardsticks) bench.WarmUp(yardstick);

    // On a CPU device, the process's processor time is the device's, without other load on the machine; a GPU
    // has timestamps.
    const bool isCpu = renderer.Device().Info().type == rhi::DeviceType::Cpu;
    std::vector<double> costs;
    PassTimes times, yardstickTimes;
    double seconds = 0.0, cpuSeconds = 0.0;
    for (uint32_t round = 0; round < plan.rounds; ++round) {
        progress.ShowStep(Text("round {}/{}", round + 1, plan.rounds));
        const Stopwatch watch;
        const double cpuBefore = os::ProcessCpuSeconds();
        bench.RunFrames(picture, plan.frames, samples);
        seconds += watch.Seconds();
        const double cpuOfPicture = os::ProcessCpuSeconds() - cpuBefore;
        cpuSeconds += cpuOfPicture;
        PassTimes ofPicture, ofLimitPath;
        const std::vector<FrameTiming> pictureFrames = renderer.TakeTimings();
        ofPicture.Add(pictureFrames);
        times.Add(pictureFrames);
        for (size_t i = 0; i < yardsticks.size(); ++i) {
            const double before = os::ProcessCpuSeconds();
            bench.RunFrames(yardsticks[i], plan.frames);
            const double cpu = os::ProcessCpuSeconds() - before;
            const std::vector<FrameTiming> frames = renderer.TakeTimings();
            yardstickTimes.Add(frames);
            if (i != kLimitPath) continue;
            ofLimitPath.Add(frames);
            costs.push_back((isCpu ? cpuOfPicture / cpu : FrameMs(ofPicture) / FrameMs(ofLimitPath)) /
                            samples);
        }
    }
    if (MsOfTrace(times) <= 0.0)
        throw MakeError(ErrorKind::Vulkan, "bench: the device {} gives no GPU times (it has no timestamps)",
                        renderer.Device().Info().name);

    progress.ShowStep("counting rays");
    const double traceRays = bench.RaysPerSample([&](auto& ids, auto& settings, TextureId& counts) {
        counts = passes::Trace(renderer, ids, settings, {.rayCounts = true}).rayCounts;
    });
    const auto limitRays = [&](passes::LimitKind kind) {
        return bench.RaysPerSample([&](auto& ids, auto& settings, TextureId& counts) {
            std::ignore = passes::Limit(renderer, ids, settings, kind, &counts);
        });
    };
    const double pixels = static_cast<double>(traced.extent.width) * traced.extent.height;
    BenchResult result;
    result.frames = plan.frames * plan.rounds;
    result.passes = times.Summary();
    for (const PassTime& pass : yardstickTimes.Summary())
        if (pass.name.starts_with("Limit") || pass.name.starts_with("Lambert")) result.passes.push_back(pass);
    result.batchSize = samples;
    result.trace = SpeedOf(MsOfTrace(times) / samples, traceRays, pixels);
    result.limit =
        SpeedOf(yardstickTimes.MedianMs("Limit"), limitRays(passes::LimitKind::CameraRays), pixels);
    result.limitPath =
        SpeedOf(yardstickTimes.MedianMs("LimitPath"), limitRays(passes::LimitKind::Path), pixels);
    if (result.limitPath.raysPerSecond > 0.0)
        result.traceEfficiency = result.trace.raysPerSecond / result.limitPath.raysPerSecond;
    if (const double ms = yardstickTimes.MedianMs("LimitPathOwn"); ms > 0.0) {
        result.limitPathOwn = SpeedOf(ms, limitRays(passes::LimitKind::SoftwarePath), pixels);
        result.traceEfficiencyOwn = result.trace.raysPerSecond / result.limitPathOwn->raysPerSecond;
    }
    result.cost = RelativeCostOf(isCpu ? "cpu seconds" : "gpu timestamps", costs);
    result.recursion = RecursionOf(yardstickTimes);
    const double total = static_cast<double>(samples) * result.frames;
    result.secondsPerSample = seconds / total;
    result.samplesPerSecond = pixels * total / seconds;
    result.samplesPerCpuSecond = cpuSeconds > 0.0 ? pixels * total / cpuSeconds : 0.0;
    return result;
}

}  // namespace raygraph::cli

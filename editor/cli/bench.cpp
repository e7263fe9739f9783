// Implements `raygraph bench`.

#include "editor/cli/bench.h"

#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>
#include <tuple>

#include "base/files.h"
#include "base/median.h"
#include "base/os.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/cli/bench_compare.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/outputs.h"
#include "editor/cli/report.h"
#include "editor/cli/version.h"
#include "editor/session/settings/as_input.h"
#include "editor/session/settings/tracing_choice.h"
#include "editor/viewport/viewport.h"
#include "passes/accumulate.h"
#include "passes/limit.h"
#include "passes/tonemap.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;

Json ResultJson(const BenchResult& result, const PictureSettings& settings, const TracingChoice& used,
                const SceneInput& input, const rhi::DeviceInfo& device) {
    Json passes;
    for (const PassTime& pass : result.passes) passes[pass.name] = pass.gpuMsMedian;
    const auto tracing = [](const TracingSpeed& speed) {
        return Json{{"gpu_ms_median", speed.gpuMsMedian},
                    {"rays_per_sample", speed.raysPerSample},
                    {"mrays_per_s", speed.raysPerSecond * 1e-6}};
    };
    const auto orNull = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
    return {{"schema", 1},
            {"version", kVersion},
            {"scene", input.file},
            {"device", device.name},
            {"driver", device.driver},
            {"settings", Texts(settings)},
            {"traversal", Name(used.traversal)},
            {"integrator_form", Name(used.form)},
            {"frames", result.frames},
            {"samples_at_once", result.batchSize},
            {"gpu_ms_median", passes},
            {"trace", tracing(result.trace)},
            {"limit", tracing(result.limit)},
            {"limit_path", tracing(result.limitPath)},
            {"trace_efficiency", result.traceEfficiency},
            {"limit_path_own", result.limitPathOwn ? tracing(*result.limitPathOwn) : Json()},
            {"trace_efficiency_own", orNull(result.traceEfficiencyOwn)},
            {"cost", ToJson(result.cost)},
            {"recursion",
             {{"loop_ms", result.recursion.loopMs},
              {"recursive_ms", orNull(result.recursion.recursiveMs)},
              {"loop_speedup", orNull(result.recursion.loopSpeedup)}}},
            {"ms_per_sample", result.secondsPerSample * 1e3},
            {"msamples_per_s", result.samplesPerSecond * 1e-6},
            {"msamples_per_cpu_s", result.samplesPerCpuSecond * 1e-6}};
}

Json ToJson(const ViewportCosts& costs) {
    const auto cost = [](const SampleCost& of) {
        return Json{{"cpu_s_per_sample", of.cpuSeconds}, {"gpu_ms_per_sample", of.gpuMs},
                    {"ms_per_sample", of.wallMs},        {"samples_per_frame", of.samplesPerFrame},
                    {"relative", of.relative},           {"cost", ToJson(of.cost)}};
    };
    return {{"budget_ms", costs.budgetMs},
            {"render", cost(costs.render)},
            {"one_a_frame", cost(costs.oneSamplePerFrame)},
            {"within_budget", cost(costs.withinBudget)}};
}

void PrintText(const ViewportCosts& costs) {
    const auto print = [](const char* name, const SampleCost& of) {
        std::fprintf(
            stderr,
            "  %-16s %9.3f of a render's sample: %.3f ms, %.3f CPU s, %.3f ms of the GPU; %.2f samples "
            "a frame\n",
            name, of.relative, of.wallMs, of.cpuSeconds, of.gpuMs, of.samplesPerFrame);
    };
    print("viewport", costs.oneSamplePerFrame);
    print(Text("  within {:.0f} ms", costs.budgetMs).c_str(), costs.withinBudget);
}

Json PipelinesJson(const std::vector<PipelineReport>& pipelines) {
    Json all = Json::array();
    for (const PipelineReport& pipeline : pipelines) {
        Json programs = Json::array();
        for (const rhi::ProgramStatistics& program : pipeline.programs) {
            Json statistics = Json::object();
            for (const rhi::ProgramStatistic& statistic : program.statistics)
                statistics[statistic.name] = statistic.value;
            programs.push_back({{"name", program.name},
                                {"subgroup_size", program.subgroupSize},
                                {"statistics", statistics}});
        }
        all.push_back(
            {{"name", pipeline.name}, {"creation_ms", pipeline.creationMs}, {"programs", programs}});
    }
    return all;
}

void PrintPipelines(const std::vector<PipelineReport>& pipelines) {
    for (const PipelineReport& pipeline : pipelines) {
        std::fprintf(stderr, "  %-40s made in %9.1f ms\n", pipeline.name.c_str(), pipeline.creationMs);
        for (const rhi::ProgramStatistics& program : pipeline.programs) {
            std::fprintf(stderr, "    %s", program.name.c_str());
            const char* separator = ": ";
            for (const rhi::ProgramStatistic& statistic : program.statistics) {
                std::fprintf(stderr, "%s%s %.10g", separator, statistic.name.c_str(), statistic.value);
                separator = ", ";
            }
            std::fprintf(stderr, "\n");
        }
    }
}

void PrintRecursion(const RecursionSpeed& speed, const rhi::DeviceInfo& device) {
    std::fprintf(stderr, "  recursion: loop %.3f ms, ", speed.loopMs);
    if (speed.recursiveMs)
        std::fprintf(stderr, "recursive %.3f ms, loop is %.2f times faster\n", *speed.recursiveMs,
                     *speed.loopSpeedup);
    else
        std::fprintf(stderr, "recursive not measured: it needs a depth of %u, the device allows %u\n",
                     kLambertRecursion, device.maxRayRecursionDepth);
}

void PrintText(const BenchResult& result, const rhi::DeviceInfo& device) {
    std::fprintf(stderr, "%s, medians over %u frames\n", device.name.c_str(), result.frames);
    for (const PassTime& pass : result.passes)
        std::fprintf(stderr, "  %-16s %9.3f ms\n", pass.name.c_str(), pass.gpuMsMedian);
    const auto tracing = [](const char* name, const TracingSpeed& speed) {
        std::fprintf(stderr, "  %-16s %9.2f Mrays/s  (%.2f rays a sample)\n", name,
                     speed.raysPerSecond * 1e-6, speed.raysPerSample);
    };
    tracing("Trace", result.trace);
    tracing("limit", result.limit);
    tracing("limit_path", result.limitPath);
    std::fprintf(stderr, "  %-16s %9.3f\n", "efficiency", result.traceEfficiency);
    if (result.limitPathOwn) {
        tracing("limit_path_own", *result.limitPathOwn);
        std::fprintf(stderr, "  %-16s %9.3f\n", "efficiency_own", *result.traceEfficiencyOwn);
    }
    std::fprintf(stderr, "  %-16s %9.3f of limit_path, by %s\n", "cost", result.cost.median,
                 result.cost.measure.c_str());
    PrintRecursion(result.recursion, device);
    std::fprintf(stderr, "  %-16s %9.3f Msamples/s, %.3f a CPU second\n", "throughput",
                 result.samplesPerSecond * 1e-6, result.samplesPerCpuSecond * 1e-6);
}

// Prints the line, and stores it if a file is given.
ExitCode WriteResult(const BenchArguments& arguments, const Json& json, ProgramLog& log) {
    const std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    PrintLine(line);
    OutputWriter outputs([&](const auto&, std::string_view why) { log.Fail(why); });
    if (!arguments.json.empty())
        outputs.Add(arguments.json, [&] { WriteTextFile(arguments.json, line + "\n"); });
    outputs.WriteAll();
    return outputs.Result();
}

}  // namespace

ExitCode BenchCommand(const BenchArguments& arguments, Console& console) {
    std::string stored;
    if (!arguments.compare.empty()) {
        const std::vector<std::byte> bytes = AsInput([&] { return ReadFile(arguments.compare); });
        stored.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
    CheckWritable(FilesOf(arguments), console.log.ForLibraries());
    PictureSettings settings = SettingsFrom(arguments.given, BenchDefaults());

    const Log log = console.log.ForLibraries();
    InputOptions options = InputOptionsFor(settings);
    options.root = arguments.root;
    options.environment = arguments.environment;
    options.log = log;
    SceneInput input = LoadInput(arguments.scene, options);
    RequireMapFor(arguments.given, input, settings.light, "--env");
    const std::unique_ptr<rhi::Device> device =
        OpenDevice({.select = arguments.device, .capturesStatistics = arguments.isListingPipelines}, log);
    const TracingChoice tracing = ChooseTracing(*device, arguments.tracing);
    scene::SceneData shown;
    if (arguments.hasViewport) shown = input.data;
    DeviceScene scene(*device, input, settings, tracing);
    if (arguments.tracing.traversal == Traversal::Software && !scene.NoSoftwareTraversalReason().empty())
        WarnDriverTraversal(log, scene.NoSoftwareTraversalReason());
    const BenchResult result =
        RunBench(scene, {arguments.frames, arguments.rounds, arguments.batchSize}, console.progress);
    console.progress.Clear();

    TracingChoice used = tracing;
    if (!scene.NoSoftwareTraversalReason().empty()) used.traversal = Traversal::Driver;
    Json json = ResultJson(result, settings, used, input, device->Info());
    if (!arguments.isQuiet) PrintText(result, device->Info());
    if (arguments.hasViewport) {
        constexpr double kBudgetMs = 120.0;  // the editor's budget while its user is idle
        const ViewportCosts costs = BenchViewport(scene, std::move(shown), settings,
                                                  {arguments.frames, arguments.rounds, arguments.batchSize},
                                                  result.cost, kBudgetMs, console.progress);
        console.progress.Clear();
        json["viewport"] = ToJson(costs);
        if (!arguments.isQuiet) PrintText(costs);
    }
    if (arguments.isListingPipelines) {
        const std::vector<PipelineReport> pipelines = scene.GraphRenderer().PipelineReports();
        json["pipelines"] = PipelinesJson(pipelines);
        if (!arguments.isQuiet) PrintPipelines(pipelines);
        if (!device->Info().optional.pipelineStatistics)
            WriteLog(log, LogLevel::Warning, log_category::kShaders,
                     "{} says nothing of its programs: it lacks VK_KHR_pipeline_executable_properties",
                     device->Info().name);
    }
    const ExitCode delivered = WriteResult(arguments, json, console.log);
    if (arguments.compare.empty()) return delivered;
    bool isWorse = false;
    for (const BenchChange& change :
         CompareBench(arguments.compare, stored, json,
                      arguments.tolerance.value_or(BenchArguments::kDefaultTolerance))) {
        std::fprintf(stderr, "%s\n", ToText(change, json).c_str());
        isWorse |= change.IsWorse();
    }
    return delivered == ExitCode::Done && isWorse ? ExitCode::Slower : delivered;
}

using namespace session;  // NOLINT

// --- Measuring a path-traced frame against the cost of tracing alone ---

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
        rhi::Submission last;
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
    if (const double ms = yardstickTimes.MedianMs("LimitPathSoftware"); ms > 0.0) {
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

using namespace session;  // NOLINT

// --- Measuring a host's viewport against the frames of a render ---

namespace {

// Runs frames that trace samples; each call returns how many it has traced, when the device is idle.
class SampleSource {
  public:
    virtual ~SampleSource() = default;
    virtual Renderer& GraphRenderer() = 0;
    virtual double RunFrame() = 0;
};

class RenderSource : public SampleSource {
  public:
    RenderSource(DeviceScene& scene, uint32_t samples) : m_scene(scene), m_samples(samples) {}
    Renderer& GraphRenderer() override { return m_scene.GraphRenderer(); }
    double RunFrame() override {
        Renderer& renderer = m_scene.GraphRenderer();
        renderer.BeginFrame();
        const SceneIds ids = m_scene.Declare(m_next);
        passes::TraceSettings settings = m_scene.SettingsFor(m_next);
        settings.sampleCount = m_samples;
        const TextureId traced = passes::Trace(renderer, ids, settings).radiance;
        // Like all frames of a render but the last one, this computes neither mean nor variance
        renderer.Present(
            passes::Accumulate(renderer, traced, {.count = m_samples}, m_accumulation, true).sums[0]);
        renderer.Device().WaitFor(renderer.Execute());
        m_next += m_samples;
        return m_samples;
    }

  private:
    DeviceScene& m_scene;
    uint32_t m_samples, m_next = 0;
    passes::Accumulation m_accumulation{"bench render"};
};

class ViewportSource : public SampleSource {
  public:
    ViewportSource(Renderer& renderer, GpuScene& scene, const PictureSettings& settings,
                   const scene::CameraView& camera, const char* name, double budgetMs)
        : m_renderer(renderer), m_viewport(renderer, scene, {.name = name, .size = settings.size}) {
        m_viewport.SetPaths(settings.paths);
        m_viewport.SetCamera(camera);
        m_viewport.SetBudget({.frameMs = budgetMs});
    }
    Renderer& GraphRenderer() override { return m_renderer; }
    double RunFrame() override {
        const double before = Samples();
        m_renderer.Device().WaitFor(m_viewport.RenderFrame());
        return Samples() - before;
    }

  private:
    double Samples() const {
        const viewport::ViewportProgress progress = m_viewport.Progress();
        return progress.pathTracedSamples + progress.pathTracedFraction;
    }
    Renderer& m_renderer;
    viewport::Viewport m_viewport;
};

struct Total {
    double samples = 0.0, frames = 0.0, cpuSeconds = 0.0, gpuMs = 0.0, wallMs = 0.0;
};

// Runs until at least so many more samples are traced.
Total Run(SampleSource& source, uint32_t samples) {
    std::ignore = source.GraphRenderer().TakeTimings();
    Total total;
    const Stopwatch watch;
    const double before = os::ProcessCpuSeconds();
    while (total.samples < samples) {
        total.samples += source.RunFrame();
        ++total.frames;
    }
    total.cpuSeconds = os::ProcessCpuSeconds() - before;
    total.wallMs = watch.Milliseconds();
    for (const FrameTiming& frame : source.GraphRenderer().TakeTimings())
        for (const PassTiming& pass : frame.passes) total.gpuMs += pass.gpuMs;
    return total;
}

}  // namespace

ViewportCosts BenchViewport(DeviceScene& render, scene::SceneData&& data, const PictureSettings& settings,
                            const BenchPlan& plan, const RelativeCost& cost, double budgetMs,
                            Progress& progress) {
    rhi::Device& device = render.GraphRenderer().Device();
    const float aspect = static_cast<float>(settings.size.width) / static_cast<float>(settings.size.height);
    const scene::CameraView camera = scene::ChooseView(data, settings.camera, aspect);
    Renderer renderer(device);
    GpuScene scene(renderer);
    scene.SetScene(std::move(data));
    const uint32_t atOnce =
        plan.batchSize > 0 ? plan.batchSize : passes::PreferredBatchSize(device, render.SettingsFor(0));
    RenderSource ofRender(render, atOnce);
    ViewportSource oneSamplePerFrame(renderer, scene, settings, camera, "one a frame", 0.0);
    ViewportSource withinBudget(renderer, scene, settings, camera, "within budget", budgetMs);
    const std::array<SampleSource*, 3> sources{&ofRender, &oneSamplePerFrame, &withinBudget};
    progress.ShowStep("warming up");
    constexpr uint32_t kWarmUpSamples = 3;
    for (SampleSource* source : sources) std::ignore = Run(*source, kWarmUpSamples);

    const bool isCpu = device.Info().type == rhi::DeviceType::Cpu;
    std::array<Total, 3> totals;
    std::array<std::vector<double>, 3> ratios;
    for (uint32_t round = 0; round < plan.rounds; ++round) {
        progress.ShowStep(Text("round {}/{}", round + 1, plan.rounds));
        double ofOne = 0.0;
        for (size_t i = 0; i < sources.size(); ++i) {
            const Total total = Run(*sources[i], plan.frames);
            const double perSample = (isCpu ? total.cpuSeconds : total.gpuMs) / total.samples;
            if (i == 0) ofOne = perSample;
            ratios[i].push_back(ofOne > 0.0 ? perSample / ofOne : 0.0);
            totals[i].samples += total.samples;
            totals[i].frames += total.frames;
            totals[i].cpuSeconds += total.cpuSeconds;
            totals[i].gpuMs += total.gpuMs;
            totals[i].wallMs += total.wallMs;
        }
    }
    const auto costOf = [&](size_t i) {
        const Total& total = totals[i];
        std::vector<double> costs = ratios[i];
        for (double& ratio : costs) ratio *= cost.median;
        return SampleCost{.cpuSeconds = total.cpuSeconds / total.samples,
                          .gpuMs = total.gpuMs / total.samples,
                          .wallMs = total.wallMs / total.samples,
                          .samplesPerFrame = total.samples / total.frames,
                          .relative = Median(ratios[i]),
                          .cost = RelativeCostOf(cost.measure, costs)};
    };
    return {
        .budgetMs = budgetMs, .render = costOf(0), .oneSamplePerFrame = costOf(1), .withinBudget = costOf(2)};
}

}  // namespace raygraph::cli

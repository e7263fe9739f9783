// Implements `raygraph bench`.
#include <nlohmann/json.hpp>

#include "base/read_file.h"
#include "base/text.h"
#include "editor/cli/bench_compare.h"
#include "editor/cli/bench_run.h"
#include "editor/cli/bench_viewport.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/output_writer.h"
#include "editor/cli/report.h"
#include "editor/cli/version.h"
#include "editor/session/settings/as_input.h"
#include "editor/session/settings/tracing_choice.h"
#include "passes/recursion.h"

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
        std::fprintf(stderr, "  %-16s %9.3f\n", "efficiency", *result.traceEfficiencyOwn);
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
    SceneInput input = LoadInput(arguments.scene, {.scene = settings.scene,
                                                   .variant = settings.variant,
                                                   .isAnimated = settings.at.has_value(),
                                                   .clips = settings.clips,
                                                   .pointsAndLines = settings.pointsAndLines,
                                                   .root = arguments.root,
                                                   .environment = arguments.environment,
                                                   .log = log});
    RequireMapFor(arguments.given, input, settings.light, "--env");
    const std::unique_ptr<rhi::Device> device =
        OpenDevice({.select = arguments.device, .capturesStatistics = arguments.isListingPipelines}, log);
    const TracingChoice tracing = ChooseTracing(*device, arguments.tracing);
    scene::SceneData shown;
    if (arguments.hasViewport) shown = input.data;
    DeviceScene scene(*device, input, settings, tracing);
    if (arguments.tracing.traversal == Traversal::Own && !scene.NoOwnTraversalReason().empty())
        WarnDriverTraversal(log, scene.NoOwnTraversalReason());
    const BenchResult result =
        RunBench(scene, {arguments.frames, arguments.rounds, arguments.batchSize}, console.progress);
    console.progress.Clear();

    TracingChoice used = tracing;
    if (!scene.NoOwnTraversalReason().empty()) used.traversal = Traversal::Driver;
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
            Say(log, LogLevel::Warning, log_category::kShaders,
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

}  // namespace raygraph::cli

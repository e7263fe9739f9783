#include "editor/cli/render_report.h"

#include <algorithm>

#include "base/os.h"

namespace raygraph::cli {

namespace {

void DescribeScene(Report& report, const SceneInput& input) {
    const scene::SceneStatistics& statistics = input.statistics;
    report.scene = {.file = input.file,
                    .trianglesUnique = statistics.uniqueTriangles,
                    .trianglesPlaced = statistics.placedTriangles,
                    .pointsPlaced = statistics.placedSpheres,
                    .segmentsPlaced = statistics.placedCapsules,
                    .instances = statistics.instanceCount,
                    .materials = statistics.materialCount,
                    .textures = statistics.textureCount,
                    .lights = statistics.lightCount};
}

void DescribeAcceleration(Report& report, const GpuSceneStatistics& statistics) {
    report.acceleration = {.blasCount = statistics.blasCount,
                           .bytesBuilt = statistics.blasBytesBuilt,
                           .bytesCompacted = statistics.blasBytesCompacted,
                           .tlasBytes = statistics.tlasBytes,
                           .compactionDisabledReason = statistics.isCompactionOff
                                                           ? statistics.compactionDisabledReason
                                                           : std::string()};
}

}  // namespace

Report DescribeRun(std::span<rhi::Device* const> devices, Session& session, const SessionResult& result,
                   const RunSummary& run) {
    Report report;
    DescribeScene(report, session.Input());
    const rhi::Device& device = *devices.front();
    const rhi::DeviceInfo& info = device.Info();
    for (const rhi::Device* each : devices) report.devices.push_back(each->Info().name);
    report.device = {info.name, info.driver, Name(info.type)};

    const SessionStatistics statistics = session.Statistics();
    const auto totalMs = [&](std::string_view pass) {
        const auto time = std::ranges::find(statistics.passes, pass, &PassTime::name);
        return time == statistics.passes.end() ? 0.0 : time->gpuMsTotal;
    };
    report.passes = statistics.passes;
    report.samples = SampleCount(result.render.samples);
    if (const auto& adaptive = result.render.adaptive) {
        const auto [least, most] = std::ranges::minmax(adaptive->counts);
        report.samplesOfPixels = Report::SamplesOfPixels{least, most};
    }
    report.wasStopped = run.wasStopped;
    report.timingsMs = {.load = session.Input().loadMs,
                        .upload = statistics.scene.uploadMs,
                        .blasBuild = totalMs("BuildBlas"),
                        .compaction = totalMs("CompactBlas"),
                        .pipelines = statistics.pipelinesMs,
                        .firstSample = 1e3 * run.firstSampleSeconds,
                        .render = 1e3 * run.seconds};
    DescribeAcceleration(report, statistics.scene);

    report.throughput = {run.samplesPerSecond, session.RaysPerSample()};
    report.image = result.statistics;
    report.nonFiniteSamples = session.NonFiniteSamples();
    report.removed = result.removed;
    const rhi::MemoryStatistics memory = device.Memory();
    report.memory = {.devicePeakBytes = memory.peakBytes,
                     .hostPeakBytes = os::PeakResidentBytes(),
                     .deviceFallbackBytes = memory.fallbackBytes,
                     .isBudgetOfDriver = info.optional.memoryBudget,
                     .heaps = device.MemoryHeaps(),
                     .textureBytes = statistics.scene.textureBytes,
                     .textureBudgetBytes = statistics.scene.textureBudget,
                     .reducedTextures = statistics.scene.reducedTextures};
    return report;
}

}  // namespace raygraph::cli

#include "editor/cli/render_report.h"

#include "base/os/process.h"

namespace raygraph::cli {

namespace {

void DescribeScene(Report& report, const SceneInput& input) {
    const scene::SceneStatistics& statistics = input.statistics;
    report.scene = {.file = input.file,
                    .trianglesUnique = statistics.uniqueTriangles,
                    .trianglesPlaced = statistics.placedTriangles,
                    .instances = statistics.instanceCount,
                    .materials = statistics.materialCount,
                    .textures = statistics.textureCount,
                    .lights = statistics.lightCount};
}

void DescribeAcceleration(Report& report, const GpuSceneStatistics& statistics) {
    report.acceleration = {
        .blasCount = statistics.blasCount,
        .bytesBuilt = statistics.blasBytesBuilt,
        .bytesCompacted = statistics.blasBytesCompacted,
        .tlasBytes = statistics.tlasBytes,
        .whyCompactionOff = statistics.isCompactionOff ? statistics.whyCompactionOff : std::string()};
}

}  // namespace

Report DescribeRun(const RunSources& sources) {
    Report report;
    DescribeScene(report, sources.input);
    const rhi::DeviceInfo& info = sources.device.Info();
    report.device = {info.name, info.driver, Name(info.type)};

    const PassTimes& times = sources.session.Times();
    report.passes = times.Summary();
    const GpuSceneStatistics& statistics = sources.scene.Scene().Statistics();
    report.timingsMs.load = sources.input.loadMs;
    report.timingsMs.upload = statistics.uploadMs;
    report.timingsMs.blasBuild = times.TotalMs("BuildBlas");
    report.timingsMs.compaction = times.TotalMs("CompactBlas");
    report.timingsMs.pipelines = sources.scene.GraphRenderer().PipelineCreationMs();
    DescribeAcceleration(report, statistics);

    if (sources.session.TracesPaths())
        report.throughput.raysPerSample = sources.session.MeasureRaysPerSample();
    const rhi::MemoryStatistics memory = sources.device.Memory();
    report.memory = {.devicePeakBytes = memory.peakBytes,
                     .hostPeakBytes = os::PeakResidentBytes(),
                     .deviceFallbackBytes = memory.fallbackBytes,
                     .isBudgetOfDriver = info.optional.memoryBudget,
                     .heaps = sources.device.MemoryHeaps()};
    return report;
}

SettingTexts SettingsForReport(const RenderArguments& arguments, const RenderFile& render,
                               const std::optional<uint32_t>& samplesWanted) {
    SettingTexts texts = render.settings;
    texts["sample-offset"] = std::to_string(render.samples.front().first);
    if (samplesWanted) texts["spp"] = std::to_string(*samplesWanted);
    if (arguments.seconds) texts["time"] = ToText(static_cast<float>(*arguments.seconds));
    if (!render.environmentFile.empty()) texts["env"] = render.environmentFile;
    texts["exposure"] = ToText(arguments.exposureEv);
    texts["tonemap"] = Name(arguments.tonemap);
    return texts;
}

}  // namespace raygraph::cli

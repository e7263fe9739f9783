#include "editor/cli/report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "base/files.h"
#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "passes/tonemap.h"

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json OrNull(const std::optional<T>& value) {
    return value ? Json(*value) : Json();
}

Json PassesJson(const std::vector<session::PassTime>& passes) {
    Json list = Json::array();
    for (const session::PassTime& pass : passes)
        list.push_back({{"name", pass.name},
                        {"gpu_ms_median", pass.gpuMsMedian},
                        {"gpu_ms_total", pass.gpuMsTotal},
                        {"count", pass.count}});
    return list;
}

Json AccelerationJson(const Report& report) {
    Json json{{"blas_count", report.acceleration.blasCount},
              {"bytes_built", report.acceleration.bytesBuilt},
              {"bytes_compacted", report.acceleration.bytesCompacted},
              {"tlas_bytes", report.acceleration.tlasBytes}};
    if (!report.acceleration.compactionDisabledReason.empty())
        json["why_compaction_off"] = report.acceleration.compactionDisabledReason;
    return json;
}

Json MemoryJson(const Report& report) {
    Json heaps = Json::array();
    for (const rhi::MemoryHeap& heap : report.memory.heaps)
        heaps.push_back({{"of_device", heap.isDeviceLocal},
                         {"size_bytes", heap.sizeBytes},
                         {"budget_bytes", heap.budgetBytes},
                         {"used_bytes", heap.usedBytes}});
    return {{"device_peak_bytes", report.memory.devicePeakBytes},
            {"host_peak_bytes", report.memory.hostPeakBytes},
            {"device_fallback_bytes", report.memory.deviceFallbackBytes},
            {"budget_of_driver", report.memory.isBudgetOfDriver},
            {"texture_bytes", report.memory.textureBytes},
            {"texture_budget_bytes", report.memory.textureBudgetBytes},
            {"reduced_textures", report.memory.reducedTextures},
            {"heaps", heaps}};
}

Json ThroughputJson(const Report& report) {
    const auto& [samples, raysPerSample] = report.throughput;
    std::optional<double> millionSamples, millionRays;
    if (samples) millionSamples = *samples * 1e-6;
    if (samples && raysPerSample) millionRays = *samples * *raysPerSample * 1e-6;
    return {{"msamples_per_s", OrNull(millionSamples)},
            {"mrays_per_s", OrNull(millionRays)},
            {"rays_per_sample", OrNull(raysPerSample)}};
}

Json RemovedJson(const Report& report) {
    Json json = Json::object();
    for (const auto& [bias, removed] : report.removed)
        json[Name(bias)] = {{"luminance", removed.mean},
                            {"standard_error", OrNull(removed.standardError)},
                            {"share", OrNull(removed.share)},
                            {"share_standard_error", OrNull(removed.shareStandardError)},
                            {"samples", removed.samples}};
    return json;
}

}  // namespace

std::string ToJson(const Report& report) {
    const auto& times = report.timingsMs;
    Json json;
    json["schema"] = 2;
    json["scene"] = {{"file", report.scene.file},
                     {"triangles_unique", report.scene.trianglesUnique},
                     {"triangles_placed", report.scene.trianglesPlaced},
                     {"points_placed", report.scene.pointsPlaced},
                     {"segments_placed", report.scene.segmentsPlaced},
                     {"instances", report.scene.instances},
                     {"materials", report.scene.materials},
                     {"textures", report.scene.textures},
                     {"lights", report.scene.lights}};
    json["device"] = {
        {"name", report.device.name}, {"driver", report.device.driver}, {"type", report.device.type}};
    json["devices"] = report.devices;
    json["settings"] = report.settings;
    json["samples"] = report.samples;
    if (report.samplesOfPixels)
        json["samples_of_pixels"] = {{"least", report.samplesOfPixels->least},
                                     {"most", report.samplesOfPixels->most}};
    json["stopped"] = report.wasStopped;
    json["timings_ms"] = {{"load", times.load},
                          {"upload", times.upload},
                          {"blas_build", times.blasBuild},
                          {"compaction", times.compaction},
                          {"pipelines", times.pipelines},
                          {"first_sample", times.firstSample},
                          {"render", times.render}};
    json["passes"] = PassesJson(report.passes);
    json["acceleration"] = AccelerationJson(report);
    json["memory"] = MemoryJson(report);
    json["throughput"] = ThroughputJson(report);
    json["image"] = {{"mean", report.image.mean},
                     {"nonfinite_samples", report.nonFiniteSamples},
                     {"relative_error", OrNull(report.image.relativeError)}};
    json["removed"] = RemovedJson(report);
    // Names may come from files and drivers: bytes that are not valid UTF-8 are replaced
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void WriteTextFile(const std::filesystem::path& path, std::string_view text) {
    AtomicFile file(path);
    file.Write(std::as_bytes(std::span(text)));
    file.Commit();
}

session::SettingTexts SettingsForReport(const RenderArguments& arguments, const session::RenderFile& render,
                                        const std::optional<uint32_t>& samplesWanted) {
    session::SettingTexts texts = render.settings;
    texts["sample-offset"] = std::to_string(render.samples.front().first);
    if (samplesWanted) texts["spp"] = std::to_string(*samplesWanted);
    if (arguments.seconds) texts["time"] = session::ToText(static_cast<float>(*arguments.seconds));
    if (!render.environmentFile.empty()) texts["env"] = render.environmentFile;
    texts["exposure"] = session::ToText(DisplayOf(arguments).exposureEv);
    texts["tonemap"] = TonemapName(DisplayOf(arguments).tonemapOperator);
    const WhitePoint white = arguments.whitePoint.value_or(WhitePoint{passes::kDisplayWhitePoint});
    texts["white-point"] = white.kelvin ? session::ToText(static_cast<float>(*white.kelvin)) : "auto";
    texts["exr-type"] = Name(arguments.exrType.value_or(ExrType::Float));
    return texts;
}

// --- Texts about biases ---

namespace {

std::string Percent(double share) {
    return Text("{:.3g} %", 100.0 * share);
}

}  // namespace

std::string Option(session::Bias bias) {
    std::string option = std::string("--") + Name(bias);
    std::ranges::replace(option, '_', '-');
    return option;
}

std::string Describe(session::Bias bias, const session::RemovedLight& removed) {
    std::string text = Option(bias) + " removed ";
    if (!removed.share) return text + "nothing of no light";
    text += Percent(*removed.share);
    if (removed.shareStandardError) text += " +- " + Percent(*removed.shareStandardError);
    return text + " of the light";
}

}  // namespace raygraph::cli

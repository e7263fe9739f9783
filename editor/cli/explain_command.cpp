// Implements `raygraph explain`.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/os.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/explain_json.h"
#include "editor/cli/outputs.h"
#include "editor/cli/rendering.h"
#include "editor/session/explain/noise.h"
#include "editor/session/explain/path_text.h"
#include "editor/session/file/image_statistics.h"
#include "editor/session/file/sample_ranges.h"
#include "editor/session/settings/light_settings.h"
#include "renderer/image/exr.h"
#include "shaders/shared/light_records.h"

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kNoisiestPixels = 8;

std::string Percent(double share) {
    return Text("{:.3g} %", 100.0 * share);
}

std::string DescribeShares(const std::vector<LightGroupShare>& shares, size_t most) {
    std::string text;
    for (size_t i = 0; i < std::min(most, shares.size()); ++i)
        text += Text("{}{} {}", i > 0 ? ", " : "", shares[i].name, Percent(shares[i].share));
    return text.empty() ? "none" : text;
}

// The picture's name is `file`.
std::string DescribeNoise(const RenderFile& render, const std::vector<NoisyPixel>& noisiest,
                          const std::string& file) {
    const ImageStatistics all =
        render.adaptive
            ? Measure(render.radiance, render.variance, render.adaptive->counts)
            : Measure(render.radiance, render.variance, static_cast<uint32_t>(SampleCount(render.samples)));
    std::string text =
        Text("{}: {}x{} pixels of {} samples, relative error {:.3g}\n", file, render.size.width,
             render.size.height, SampleCount(render.samples), all.relativeError.value_or(0.0));
    const bool hasGroups = !render.lightGroups.empty();
    if (hasGroups)
        text += Text("light: {}\n", DescribeShares(LightGroupShares(render), gpu::kMaxLightGroups));
    if (noisiest.empty()) return text + "no pixel has noise\n";
    text += "pixels by their share of the picture's variance:\n";
    for (const NoisyPixel& pixel : noisiest) {
        text += Text("  {:>11}  {:>6}, relative error {:.3g}", Text("{},{}", pixel.pixel.x, pixel.pixel.y),
                     Percent(pixel.varianceShare), pixel.relativeError);
        if (hasGroups) text += Text(", light: {}", DescribeShares(LightGroupShares(render, pixel.pixel), 2));
        text += '\n';
    }
    // A render has no folder of its scene
    const std::filesystem::path beside = std::filesystem::path(file).parent_path() / render.sceneFile;
    std::error_code error;
    const bool isHere = std::filesystem::exists(render.sceneFile, error);
    const std::string scene = isHere                                   ? render.sceneFile
                              : std::filesystem::exists(beside, error) ? beside.string()
                                                                       : "FOLDER/" + render.sceneFile;
    return text + Text("the paths of the first: raygraph explain {} --settings-from {} --pixel {},{}\n",
                       os::ForShell(scene), os::ForShell(file), noisiest[0].pixel.x, noisiest[0].pixel.y);
}

std::string NoiseJson(const RenderFile& render, const std::vector<NoisyPixel>& noisiest) {
    const auto sharesJson = [](const std::vector<LightGroupShare>& shares) {
        Json json = Json::object();
        for (const LightGroupShare& group : shares) json[group.name] = group.share;
        return json;
    };
    const bool hasGroups = !render.lightGroups.empty();
    Json json{{"samples", SampleCount(render.samples)}};
    if (hasGroups) json["lightGroups"] = sharesJson(LightGroupShares(render));
    json["pixels"] = Json::array();
    for (const NoisyPixel& pixel : noisiest) {
        Json& out = json["pixels"].emplace_back();
        out["pixel"] = {pixel.pixel.x, pixel.pixel.y};
        out["varianceShare"] = pixel.varianceShare;
        out["relativeError"] = pixel.relativeError;
        if (hasGroups) out["lightGroups"] = sharesJson(LightGroupShares(render, pixel.pixel));
    }
    return json.dump(2) + '\n';
}

// Returns the request, with the samples of --settings-from where the command line names none.
ExplainRequest RequestFor(const ExplainArguments& arguments, const Log& log) {
    ExplainRequest request = arguments.request;
    if (arguments.settingsFrom.empty()) return request;
    const RenderFile render = ReadRenderFile(arguments.settingsFrom, log);
    if (render.sceneFile != arguments.scene.filename().string())
        WriteLog(log, LogLevel::Warning, log_category::kScene, "{} is a render of {}, not of {}",
                 arguments.settingsFrom, Printable(render.sceneFile), arguments.scene.filename());
    if (arguments.hasSamples || render.samples.empty()) return request;
    request.firstSample = render.samples.front().first;
    request.sampleCount = std::min(render.samples.front().count, 1u << 24);
    return request;
}

ExitCode ExplainRender(const ExplainArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    CheckWritable(FilesOf(arguments), log);
    const image::ExrThreads threads;
    const RenderFile render = ReadRenderFile(arguments.scene, log);
    const std::vector<NoisyPixel> noisiest = NoisiestPixels(render, kNoisiestPixels);
    OutputWriter outputs([&](const auto&, std::string_view why) { console.log.Fail(why); });
    for (const auto& [path, map] :
         {std::pair{arguments.noiseMap, &NoiseMap}, {arguments.groupMap, &LightGroupMap}})
        if (!path.empty()) outputs.Add(path, [&render, path, map] { image::WritePng(path, map(render)); });
    const std::string text = arguments.isJson ? NoiseJson(render, noisiest)
                                              : DescribeNoise(render, noisiest, arguments.scene.string());
    outputs.WriteAll();
    std::fputs(text.c_str(), stdout);
    return outputs.Result();
}

}  // namespace

ExitCode ExplainCommand(const ExplainArguments& arguments, Console& console) {
    if (!arguments.hasPixel) return ExplainRender(arguments, console);
    const Log log = console.log.ForLibraries();
    const PictureSettings settings = SettingsFrom(
        arguments.given,
        StoredSettings(arguments.settingsFrom, arguments.scene, arguments.environment, arguments.given, log));
    InputOptions options = InputOptionsFor(settings);
    options.root = arguments.root;
    options.environment = arguments.environment;
    options.log = log;
    SceneInput input = LoadInput(arguments.scene, options);
    RequireMapFor(arguments.given, input, ChooseLight(input, settings), "--env or --light studio");
    const std::unique_ptr<rhi::Device> device = OpenDevice({arguments.device, arguments.isValidating}, log);
    Explainer explainer(*device, std::move(input), settings, arguments.tracing);
    const Explanation explanation = explainer.Explain(RequestFor(arguments, log));
    const std::string text = arguments.isJson ? ExplanationJson(explanation) : Describe(explanation);
    std::fputs(text.c_str(), stdout);
    return ExitCode::Done;
}

}  // namespace raygraph::cli

#include "editor/cli/merge_report.h"

#include <nlohmann/json.hpp>

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;

Json PartJson(const MergedPart& part) {
    Json ranges = Json::array();
    for (const session::SampleRange& range : part.samples)
        ranges.push_back({{"first", range.first}, {"count", range.count}});
    const std::optional<double>& error = part.image.relativeError;
    return {{"file", part.file},
            {"samples", session::SampleCount(part.samples)},
            {"ranges", ranges},
            {"device", part.device},
            {"driver", part.driver},
            {"image", {{"mean", part.image.mean}, {"relative_error", error ? Json(*error) : Json()}}}};
}

}  // namespace

MergedPart DescribePart(const session::NamedRender& part) {
    const session::RenderFile& render = part.render;
    const auto count = static_cast<uint32_t>(session::SampleCount(render.samples));
    return {.file = part.name,
            .size = render.size,
            .samples = render.samples,
            .image = session::Measure(render.radiance, render.variance, count),
            .scene = render.sceneFile,
            .device = render.device,
            .driver = render.driver,
            .settings = render.settings,
            .aovs = AovsOf(render)};
}

std::string ToJson(const MergeReport& report) {
    Json json{{"schema", 1}};
    json["scene"] = report.output.scene;
    json["width"] = report.output.size.width;
    json["height"] = report.output.size.height;
    json["settings"] = report.output.settings;
    json["aovs"] = Json::array();
    for (const session::Aov aov : session::kAovs)
        if (report.output.aovs.Has(aov)) json["aovs"].push_back(Name(aov));
    json["inputs"] = Json::array();
    for (const MergedPart& part : report.inputs) json["inputs"].push_back(PartJson(part));
    json["output"] = PartJson(report.output);
    // Names may come from files and drivers: bytes that are not valid UTF-8 are replaced
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace raygraph::cli

#include "editor/cli/render_job.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/path_text.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/resume_settings.h"
#include "editor/session/settings/light_color.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/setting_table.h"
#include "passes/white_balance.h"
#include "renderer/image/exr_threads.h"

namespace raygraph::cli {

namespace {

// Returns the option of the first setting that differs; "" if none does.
std::string FirstChangedOption(const PictureSettings& a, const PictureSettings& b) {
    for (const PictureSetting& setting : PictureSettingTable())
        if (setting.text(a) != setting.text(b)) return std::string("--") + setting.name;
    return "";
}

// Refuses options and outputs that views other than the path-traced one would ignore.
void CheckView(const RenderArguments& arguments, const PictureSettings& settings) {
    const auto refuse = [&](const std::string& what) {
        throw MakeError(ErrorKind::Usage, "--view {}: {}", Name(settings.view), what);
    };
    if (settings.view != View::Raster && settings.raster.shadows != passes::RasterSettings{}.shadows)
        refuse("--shadows is for --view raster");
    if (settings.crop && !CanCrop(settings.view))
        refuse("it is drawn as a whole; --crop is for views of rays");
    if (settings.view == View::PathTraced) return;
    if (settings.paths.isEnvironmentHidden) refuse("only path-traced renders know --transparent");
    if (!arguments.resume.empty()) refuse("only path-traced renders are resumed");
    if (!settings.lightGroups.empty()) refuse("only path-traced renders have light for --light-group");
    if (settings.view != View::RayCost) {
        // The settings that the view uses
        PictureSettings its = settings;
        its.paths = {.sampler = settings.paths.sampler, .seed = settings.paths.seed};
        its.aperture = PictureSettings{}.aperture;  // these views have a pinhole camera
        its.focusDistance = PictureSettings{}.focusDistance;
        if (settings.view == View::Raster) its.paths.scattering = settings.paths.scattering;
        if (const std::string option = FirstChangedOption(its, settings); !option.empty())
            refuse("only path-traced renders know " + option);
        if (!ShowsLight(settings.view)) {
            its.environmentRotation = PictureSettings{}.environmentRotation;
            its.environmentTint = PictureSettings{}.environmentTint;
            its.background = PictureSettings{}.background;
            its.light = PictureSettings{}.light;
            if (!arguments.environment.empty()) refuse("there is no light that --env could give");
            if (const std::string option = FirstChangedOption(its, settings); !option.empty())
                refuse("there is no light for " + option);
        }
    }
    if (settings.view == View::Raster) {
        if (arguments.error) refuse("give --spp; --error is for path-traced renders");
        return;
    }
    if (!IsAverageable(settings.view) &&
        (arguments.seconds || arguments.error || arguments.samples.value_or(1) > 1))
        refuse("it is not averaged over samples; leave out --spp, --time and --error");
    if (arguments.error) refuse("only light has an error to estimate");
    if (WritesKind(arguments, OutputKind::Hdr)) refuse("an .hdr holds radiance; write an .exr");
    if (arguments.exposureEv) refuse("there is no light that --exposure could scale");
    if (arguments.tonemap) refuse("there is no light that --tonemap could map");
    if (arguments.whitePoint) refuse("there is no light that --white-point could balance");
}

// Refuses to drop channels that were asked for, or that the resumed file has.
void RequireExrForChannels(const RenderArguments& arguments, const RenderJob& job) {
    if (WritesKind(arguments, OutputKind::Exr)) return;
    const auto refuse = [&](const char* option, const std::string& ofFile) {
        throw MakeError(ErrorKind::Usage, "{} are written to an .exr, and there is no -o OUT.exr",
                        job.resumed ? Text("{}: its channels of {}", job.resumed->path, ofFile)
                                    : std::string(option) + ": its channels");
    };
    if (!job.aovs.IsEmpty()) refuse("--aov", ListOf(job.aovs));
    if (!job.settings.lightGroups.empty()) refuse("--light-group", "groups of lights");
}

// Returns the settings for options that are not given.
PictureSettings DefaultsOf(const RenderArguments& arguments, const Log& log) {
    if (arguments.settingsFrom.empty()) return {};
    const RenderFile render = ReadRenderFile(arguments.settingsFrom, log);
    PictureSettings settings = SettingsFrom(render.settings);
    const bool replacesLighting = !arguments.environment.empty() || arguments.given.contains("background");
    if (!render.environmentFile.empty() && !replacesLighting)
        Say(log, LogLevel::Warning, log_category::kScene,
            "{} was lit by the map {}, which is no setting: --env gives one again", arguments.settingsFrom,
            Printable(render.environmentFile));
    // A given light replaces the stored one
    const auto light = arguments.given.find(kLightSetting);
    const bool isStudio = light != arguments.given.end() && light->second == Name(DefaultLight::Studio);
    if (!arguments.environment.empty() || isStudio) settings.background.reset();
    // The choice made for one scene does not hold for another
    if (replacesLighting || render.sceneFile != arguments.scene.filename().string())
        settings.light = DefaultLight::Auto;
    if (arguments.given.contains("background")) {
        settings.environmentRotation = PictureSettings{}.environmentRotation;
        settings.environmentTint = PictureSettings{}.environmentTint;
    }
    return settings;
}

}  // namespace

passes::TonemapSettings DisplayFor(const RenderArguments& arguments, const PictureSettings& settings,
                                   const SceneInput& input) {
    passes::TonemapSettings display = DisplayOf(arguments);
    if (!arguments.whitePoint || arguments.whitePoint->kelvin) return display;
    const std::optional<glm::dvec3> light = LightColor(input, settings);
    if (!light)
        throw MakeError(ErrorKind::BadInput, "--white-point auto: {} has no light to take the color of",
                        Printable(input.file));
    display.whiteBalance = passes::WhiteBalance(passes::ChromaticityOf(*light));
    return display;
}

bool WritesKind(const RenderArguments& arguments, OutputKind kind) {
    return std::ranges::any_of(arguments.outputs, [&](const OutputFile& o) { return o.kind == kind; });
}

RenderJob PlanJob(const RenderArguments& arguments, const Log& log) {
    RenderJob job;
    const image::ExrThreads threads;
    const PlannedPicture first = PicturesToRender(arguments).front();
    job.resumed = ResumedFor(arguments, first.name, log);
    const bool rendersSeveral = arguments.frames || !arguments.cameras.empty();
    if (job.resumed && !rendersSeveral) {
        const RenderFile& render = job.resumed->render;
        job.settings = SettingsOf(*job.resumed, arguments);
        job.aovs = AovsOf(render);
        job.firstSample = render.samples.front().first;
    } else {
        // The session makes sure that each picture's render has these settings
        job.settings = SettingsFrom(arguments.given, DefaultsOf(arguments, log));
        if (first.at) job.settings.at = first.at;
        if (arguments.aovs) job.aovs = AovsFor(*arguments.aovs, job.settings);
        job.firstSample = arguments.sampleOffset.value_or(0);
    }
    if (arguments.shard && !arguments.frames && job.settings.isAdaptive)
        throw Error(ErrorKind::Usage,
                    "--shard: an adaptive render decides by all of its samples which are next, so that there "
                    "is nothing to divide beforehand; leave out --adaptive or --shard");
    if (arguments.shard && !arguments.frames && !IsAverageable(job.settings.view))
        throw MakeError(ErrorKind::Usage,
                        "--shard: --view {} is not averaged over samples, so that there is nothing to divide",
                        Name(job.settings.view));
    CheckView(arguments, job.settings);
    RequireExrForChannels(arguments, job);
    const bool isSingle = !IsAverageable(job.settings.view);
    const bool isOpenEnded = arguments.seconds || (arguments.error && !arguments.samples);
    if (!isOpenEnded)
        job.samplesWanted = isSingle ? 1 : arguments.samples.value_or(RenderArguments::kDefaultSamples);
    const uint64_t last = uint64_t{job.firstSample} + job.samplesWanted.value_or(1) - 1;
    if (last > std::numeric_limits<uint32_t>::max())
        throw MakeError(ErrorKind::Usage, "--sample-offset {}: sample {} is beyond the last, 4294967295",
                        job.firstSample, last);
    return job;
}

std::optional<ResumedRender> ResumedFor(const RenderArguments& arguments, const PictureName& name,
                                        const Log& log) {
    if (arguments.resume.empty()) return std::nullopt;
    const std::filesystem::path path = Named(arguments.resume, name);
    // Only a missing file counts: one that cannot be read now may be the last good one
    std::error_code error;
    if (arguments.checkpointMinutes &&
        std::filesystem::status(path, error).type() == std::filesystem::file_type::not_found)
        return std::nullopt;
    return ReadResumedRender(path, log);
}

void RequireSameRequest(const ResumedRender& complete, const RenderArguments& arguments, const RenderJob& job,
                        const PlannedPicture& picture) {
    const RenderFile& render = complete.render;
    const auto require = [&](bool isAsked, const std::string& difference) {
        if (!isAsked)
            throw MakeError(ErrorKind::BadInput,
                            "{} is complete, but another picture than the one that is asked for: {}",
                            complete.path, Printable(difference, 1024));
    };
    const auto names = [](const std::string& kept, const std::filesystem::path& asked) {
        const auto quoted = [](const std::string& name) { return name.empty() ? "none" : name; };
        return Text("{} against {}", quoted(kept), quoted(asked.filename().string()));
    };
    require(render.sceneFile == arguments.scene.filename().string(),
            "scene: " + names(render.sceneFile, arguments.scene));
    require(render.environmentFile == arguments.environment.filename().string(),
            "environment map: " + names(render.environmentFile, arguments.environment));
    SettingTexts asked = Texts(job.settings);
    if (picture.at) asked["at"] = AtText(picture.at);
    if (picture.camera) asked["camera"] = *picture.camera;
    const std::string difference = FirstDifference(render.settings, asked);
    require(difference.empty(), difference);
    const uint32_t first = render.samples.front().first;
    require(first == job.firstSample, Text("first sample: {} against {}", first, job.firstSample));
    require(AovsOf(render) == job.aovs, "its channels are those of other --aov");
}

std::string JobText(const RenderJob& job) {
    nlohmann::json json{{"settings", Texts(job.settings)}, {"first", job.firstSample}};
    json["aovs"] = nlohmann::json::array();
    for (const Aov aov : kAovs)
        if (job.aovs.Has(aov)) json["aovs"].push_back(Name(aov));
    if (job.samplesWanted) json["samples"] = *job.samplesWanted;
    // CBOR instead of text, since names and patterns may not be valid UTF-8
    const std::vector<uint8_t> bytes = nlohmann::json::to_cbor(json);
    return {bytes.begin(), bytes.end()};
}

RenderJob JobFrom(const std::string& text) {
    try {
        const nlohmann::json json = nlohmann::json::from_cbor(text);
        RenderJob job;
        job.settings = SettingsFrom(json.at("settings").get<SettingTexts>());
        for (const auto& name : json.at("aovs")) job.aovs.Set(ParseChoice<Aov>(name.get<std::string>()));
        job.firstSample = json.at("first").get<uint32_t>();
        if (json.contains("samples")) job.samplesWanted = json.at("samples").get<uint32_t>();
        return job;
    } catch (const nlohmann::json::exception& error) {
        throw MakeError(ErrorKind::BadInput, "the render that is asked for cannot be read: {}", error.what());
    }
}

}  // namespace raygraph::cli

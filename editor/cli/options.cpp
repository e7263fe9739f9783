#include "editor/cli/options.h"

#include <algorithm>
#include <limits>
#include <sstream>

#include "base/text.h"
#include "editor/cli/aov_request.h"
#include "editor/cli/command_files.h"
#include "editor/cli/device_list.h"
#include "editor/session/session.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/setting_table.h"
#include "passes/tonemap.h"

namespace raygraph::cli {

namespace {

constexpr size_t kHelpWidth = 72;
// These are the names of CLI11 validators
constexpr const char *kChoice = "choice", *kList = "list";

struct Group {
    const char* name;
    std::vector<std::string_view> options;
};

// Whatever is in no group is listed first, with --help.
const Group kGroups[] = {
    {"Output",
     {"output", "size", "crop", "view", "transparent", "exposure", "tonemap", "white-point", "exr-type",
      "contact-sheet", "aov", "denoise", "no-denoise", "denoiser", "light-group", "resume", "checkpoint",
      "settings-from", "report"}},
    {"Sampling", {"spp", "time", "error", "adaptive", "seed", "sample-offset", "shard"}},
    {"Camera", {"camera", "view-from", "orbit", "turntable", "aperture", "focus", "shutter"}},
    {"Light", {"backdrop", "ground", "env", "env-rotation", "env-tint", "background", "light", "shadows"}},
    {"Scene", {"scene", "variant", "at", "clips", "frames", "points", "lines", "root"}},
    {"Biases",
     {"max-depth", "clamp-indirect", "regularize", "shadow-terminator", "texture-lod", "texture-budget"}},
    {"Devices", {"device", "devices", "validate"}},
    {"Messages", {"progress", "quiet", "verbose", "log"}},
};
const Group kStudy{"Study",
                   {"sampler", "brdf", "distribution", "masking", "fresnel", "multiscatter", "nee",
                    "light-sampler", "mis", "rr", "rr-start", "traversal", "integrator-form"}};

}  // namespace

void SetGroups(CLI::App& command, bool showsStudy) {
    const auto has = [](const Group& group, const CLI::Option& option) {
        return std::ranges::any_of(
            group.options, [&](std::string_view name) { return option.check_lname(std::string(name)); });
    };
    for (CLI::Option* option : command.get_options()) {
        if (has(kStudy, *option)) option->group(showsStudy ? kStudy.name : "");
        for (const Group& group : kGroups)
            if (has(group, *option)) option->group(group.name);
    }
}

std::string Wrapped(std::string_view text) {
    std::string wrapped;
    while (text.size() > kHelpWidth) {
        const size_t space = text.rfind(' ', kHelpWidth);
        wrapped += text.substr(0, space);
        wrapped += '\n';
        text.remove_prefix(space + 1);
    }
    return wrapped + std::string(text);
}

CLI::Option* AddOption(CLI::App& app, const std::string& name, const char* operand, const std::string& help,
                       std::function<void(const std::string&)> take) {
    const std::string label = name.substr(name.rfind(',') + 1);
    return app
        .add_option_function<std::string>(
            name,
            [label, take = std::move(take)](const std::string& text) {
                try {
                    take(text);
                } catch (const Error& error) {
                    throw MakeError(error.Kind(), "{}: {}", label, error.what());
                }
            },
            Wrapped(help))
        ->type_name(operand);
}

// CLI11 stores no data of ours with an option except validators. One that is inactive neither checks nor
// appears in the help.
void SetChoices(CLI::Option& option, const std::vector<std::string_view>& names, Operands operands) {
    std::string joined;
    for (const std::string_view name : names) (joined += joined.empty() ? "" : "|") += name;
    option.check(CLI::Validator(joined).active(false), operands == Operands::List ? kList : kChoice);
}

Choices ChoicesOf(CLI::Option& option) {
    Choices choices;
    for (const char* kind : {kChoice, kList}) {
        try {
            CLI::Validator holder = *option.get_validator(kind);
            std::istringstream joined(holder.active().get_description());
            for (std::string name; std::getline(joined, name, '|');) choices.names.push_back(name);
            choices.isList = kind == kList;
        } catch (const CLI::OptionNotFound&) {
            // the validator is of another kind
        }
    }
    return choices;
}

void AddPath(CLI::App& app, const std::string& name, const char* operand, const char* help,
             std::filesystem::path& path) {
    AddOption(app, name, operand, help, [name, &path](const std::string& text) {
        if (text.empty()) throw Error(ErrorKind::Usage, "an empty path");
        path = text;
    });
}

void AddOutputs(CLI::App& app, const std::string& help, std::vector<OutputFile>& outputs,
                std::span<const OutputKind> kinds) {
    app.add_option_function<std::vector<std::string>>(
           "-o,--output",
           [&outputs, kinds](const std::vector<std::string>& paths) {
               for (const std::string& path : paths) {
                   try {
                       outputs.push_back(ParseOutput(path, kinds));
                   } catch (const Error& error) {
                       throw MakeError(error.Kind(), "-o: {}", error.what());
                   }
               }
           },
           Wrapped(help))
        ->type_name("OUT")
        ->allow_extra_args(false);
}

void AddVariant(CLI::App& app, std::string& variant) {
    AddOption(app, "--variant", "VARIANT", "Variant of the materials, by name or index (none)",
              [&variant](const std::string& text) { variant = text; });
}

void AddPointsAndLines(CLI::App& app, scene::PointsAndLines& radii) {
    const auto add = [&](const char* option, const std::string& what, scene::RoundRadius& radius) {
        AddOption(app, option, "RADIUS", what + kRadiusHelp,
                  [&radius](const std::string& text) { radius = scene::ParseRoundRadius(text); });
    };
    add("--points", "Radius of points, shown as spheres", radii.points);
    add("--lines", "Radius of lines, shown as capsules", radii.lines);
}

CLI::Option* AddScene(CLI::App& app, std::filesystem::path& path) {
    return app
        .add_option_function<std::string>(
            "FILE", [&path](const std::string& text) { path = text; }, "glTF scene, .gltf or .glb")
        ->type_name("");
}

void AddSettings(CLI::App& app, SettingTexts& given, const std::vector<std::string_view>& names,
                 const PictureSettings& defaults) {
    for (const PictureSetting& setting : PictureSettingTable()) {
        if (!names.empty() && std::ranges::find(names, setting.name) == names.end()) continue;
        CLI::Option* option =
            AddOption(app, std::string("--") + setting.name, setting.operand, setting.HelpWith(defaults),
                      [&setting, &given](const std::string& text) {
                          PictureSettings scratch;
                          setting.set(scratch, text);
                          given[setting.name] = setting.text(scratch);
                      });
        if (!setting.choices.empty()) SetChoices(*option, setting.choices);
        if (setting.isList) option->delimiter(';')->multi_option_policy(CLI::MultiOptionPolicy::Join);
    }
}

namespace {

// The names of --view-from; directions are those of Blender's views, with its -y as +z.
constexpr std::pair<std::string_view, scene::Orbit> kDirections[] = {
    {"front", {0.0f, 0.0f, false}},  {"back", {180.0f, 0.0f, false}}, {"right", {90.0f, 0.0f, false}},
    {"left", {-90.0f, 0.0f, false}}, {"top", {0.0f, 90.0f, false}},   {"bottom", {0.0f, -90.0f, false}},
    {"side", {90.0f, 0.0f, false}}};

scene::Orbit ParseOrbit(const std::string& text) {
    try {
        const std::vector<std::string_view> parts = ParseList(text);
        if (parts.size() == 2)
            return {static_cast<float>(ParseNumber(parts[0], -36000.0, 36000.0)),
                    static_cast<float>(ParseNumber(parts[1], -90.0, 90.0))};
    } catch (const Error&) {
        // The message for the whole text says more than the one for its part
    }
    throw MakeError(ErrorKind::Usage,
                    "{} is not AZ,EL: degrees around the scene, 0 in front and 90 on the right, and degrees "
                    "above the horizon, -90 to 90, such as 30,20",
                    Quoted(text));
}

}  // namespace

void AddOrbits(CLI::App& app, SettingTexts& given) {
    const auto give = [&given](const scene::Orbit& orbit) {
        if (given.contains("camera")) Reject("--camera, --view-from and --orbit exclude each other");
        given["camera"] = scene::ToText(orbit);
    };
    std::vector<std::string_view> names;
    for (const auto& [name, orbit] : kDirections) names.push_back(name);
    SetChoices(
        *AddOption(
            app, "--view-from", "SIDE",
            "Frame the scene, seen from its front (+z), back, right (+x; also: side), left, top (+y) or "
            "bottom",
            [give, names](const std::string& text) { give(kDirections[ParseChoice(text, names)].second); }),
        names);
    AddOption(app, "--orbit", "AZ,EL",
              "Frame the scene, seen from AZ degrees around it (0: the front, 90: the right) and EL degrees "
              "above the horizon",
              [give](const std::string& text) { give(ParseOrbit(text)); });
}

void AddTracing(CLI::App& app, TracingChoice& tracing) {
    const auto add = [&](const char* name, const char* operand, const char* help, auto& choice) {
        using Value = std::remove_reference_t<decltype(choice)>;
        CLI::Option* option = AddOption(app, name, operand, help, [&choice](const std::string& text) {
            choice = ParseChoice<Value>(text);
        });
        static constexpr auto kTexts = Texts(Value{});
        SetChoices(*option, {kTexts.begin(), kTexts.end()});
    };
    add("--traversal", "TRAVERSAL",
        "Ray traversal: driver (the device's ray tracing), software (Raygraph's shaders, for triangles that "
        "do "
        "not "
        "deform) or auto, the faster one (auto)",
        tracing.traversal);
    add("--integrator-form", "FORM",
        "Integrator: loop (each path to its end), wavefront (the same step of all paths) or auto, the faster "
        "one (auto)",
        tracing.form);
}

void AddDevice(CLI::App& app, std::string& device) {
    AddOption(app, "--device", "DEVICE",
              "Device by index or by a part of its name (RAYGRAPH_DEVICE, else the best suitable)",
              [&device](const std::string& text) { device = text; });
}

void AddValidate(CLI::App& app, bool& isValidating) {
    app.add_flag("--validate", isValidating,
                 Wrapped("Turn on the Vulkan validation layers and fail on any message"));
}

void AddLog(CLI::App& app, OutputArguments& arguments) {
    // A callback is needed: CLI11 2.4 counts a bound number as given from the start, and --quiet, which
    // excludes it, would always be refused.
    app.add_flag_function(
        "-v,--verbose", [&arguments](int64_t count) { arguments.verbosity = static_cast<uint32_t>(count); },
        Wrapped("Show information on stderr, such as times; -vv: debug messages, too"));
    AddPath(app, "--log", "FILE", "Write messages to a file, too, information included (with -vv all)",
            arguments.logFile);
}

void AddOutput(CLI::App& app, OutputArguments& arguments) {
    CLI::Option* quiet =
        app.add_flag("--quiet", arguments.isQuiet, "Show no progress, no warnings and no summary");
    AddLog(app, arguments);
    quiet->excludes("--verbose");
}

void AddProgress(CLI::App& app, OutputArguments& arguments) {
    constexpr auto kTexts = Texts(ProgressStyle{});
    CLI::Option* option = AddOption(
        app, "--progress", "STYLE", "How to show progress on stderr: " + ListForHelp(arguments.progress),
        [&arguments](const std::string& text) { arguments.progress = ParseChoice<ProgressStyle>(text); });
    SetChoices(*option, {kTexts.begin(), kTexts.end()});
}

void AddRoot(CLI::App& app, std::filesystem::path& root) {
    AddPath(app, "--root", "FOLDER",
            "Let the scene name files below this folder, too, such as ../textures/wood.png", root);
}

void AddEnvironment(CLI::App& app, std::filesystem::path& environment) {
    AddPath(app, "--env", "FILE", "Equirectangular environment map, .hdr or .exr", environment);
}

void Reject(const std::string& message) {
    throw Error(ErrorKind::Usage, message);
}

void CheckProgress(const OutputArguments& arguments) {
    const bool isShown =
        arguments.progress == ProgressStyle::Plain || arguments.progress == ProgressStyle::Json;
    if (arguments.isQuiet && isShown)
        Reject(Text("--quiet and --progress {} exclude each other", Name(arguments.progress)));
}

void CheckEnvironment(const SettingTexts& given, bool hasMap) {
    if (given.contains("background") && hasMap) Reject("--background and --env exclude each other");
    const auto light = given.find(kLightSetting);
    if (light != given.end() && light->second == Name(DefaultLight::Studio))
        for (const auto& [option, isGiven] :
             {std::pair("--background", given.contains("background")), std::pair("--env", hasMap)})
            if (isGiven) Reject(Text("{} and --light studio exclude each other", option));
    for (const char* option : {"env-rotation", "env-tint"})
        if (given.contains(option) && given.contains("background"))
            Reject(Text("--{} is of a map or the studio, which --background replaces", option));
}

// --- The options of `render` ---

namespace {

WhitePoint ParseWhitePoint(const std::string& text) {
    if (text == "auto") return {};
    try {
        return {ParseNumber(text, passes::kMinWhitePoint, passes::kMaxWhitePoint)};
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}, nor auto", error.what());
    }
}

void SetBackdrop(RenderArguments& arguments, const std::string& text) {
    if (arguments.given.contains("transparent")) Reject("--backdrop and --transparent exclude each other");
    arguments.given["transparent"] = text == "map" ? "off" : "on";
    arguments.backdrop = ParseBackdrop(text);
}

// Lists the AOVs from `first` up to `end`, which is excluded; without `end`, all the rest.
std::string ListOf(Aov first, std::optional<Aov> end) {
    std::string list;
    for (const Aov aov : kAovs)
        if (first <= aov && (!end || aov < *end)) list += std::string(list.empty() ? "" : ", ") + Name(aov);
    return list;
}

// Returns the name patterns of the outputs, the report and the resumed render.
std::vector<std::filesystem::path> PatternsOf(const RenderArguments& arguments) {
    const CommandFiles files = FilesOf(arguments, PictureName{});
    std::vector<std::filesystem::path> patterns = files.outputs;
    patterns.insert(patterns.end(), files.updated.begin(), files.updated.end());
    return patterns;
}

void CheckFrames(const RenderArguments& arguments) {
    if (arguments.given.contains("at")) Reject("--frames and --at exclude each other");
    for (const std::filesystem::path& path : PatternsOf(arguments))
        if (!HasNumberPlaceholder(path))
            Reject(Text("\"{}\" has no single run of # for the numbers of --frames, as name.####.exr", path));
}

void CheckCameras(const RenderArguments& arguments) {
    if (arguments.turntable || arguments.isContactSheet) return;
    for (const std::filesystem::path& path : PatternsOf(arguments))
        if (!HasCameraPlaceholder(path))
            Reject(Text("\"{}\" has no {{camera}} to tell the pictures of several --camera apart", path));
}

void CheckTurntable(const RenderArguments& arguments) {
    const auto camera = arguments.given.find("camera");
    if (camera != arguments.given.end() && !scene::OrbitFromText(camera->second))
        Reject("--turntable goes around the scene: --orbit or --view-from gives its start, not --camera");
    if (arguments.frames) Reject("--turntable and --frames exclude each other");
    if (arguments.shard)
        Reject("--turntable and --shard exclude each other; give each shard its own --orbit");
    if (arguments.isContactSheet) return;
    for (const std::filesystem::path& path : PatternsOf(arguments))
        if (!HasNumberPlaceholder(path))
            Reject(
                Text("\"{}\" has no single run of # for the numbers of --turntable, as name.##.png", path));
}

void CheckContactSheet(const RenderArguments& arguments) {
    for (const OutputFile& picture : PicturesOf(arguments))
        if (!IsDisplayed(picture.kind))
            Reject(Text("--contact-sheet: {} has no place for several pictures; give a .png", picture.path));
    if (!arguments.resume.empty() || arguments.checkpointMinutes)
        Reject("--contact-sheet keeps no samples: it goes with neither --resume nor --checkpoint");
    if (!arguments.report.empty()) Reject("--report is of a picture; a --contact-sheet has several");
}

void CheckCheckpoints(const RenderArguments& arguments) {
    const bool rendersSeveral = arguments.frames || !arguments.cameras.empty();
    if (!arguments.checkpointMinutes) {
        if (rendersSeveral && !arguments.resume.empty())
            Reject(
                Text("{} begins each picture; --resume goes on with one, and with several only with "
                     "--checkpoint",
                     arguments.frames      ? "--frames"
                     : arguments.turntable ? "--turntable"
                                           : "--camera"));
        return;
    }
    if (arguments.seconds && rendersSeveral)
        Reject("--checkpoint: with --time, no picture of several is ever complete; give --spp or --error");
    if (arguments.seconds && !arguments.samples && !arguments.error && !arguments.resume.empty())
        Reject("--checkpoint: with --time, a render that goes on is never complete; give --spp or --error");
    if (arguments.exrType == ExrType::Half)
        Reject("--checkpoint saves renders that can be resumed, and --exr-type half leaves out their sums");
    const std::vector<OutputFile> pictures = PicturesOf(arguments);
    if (!arguments.resume.empty() &&
        std::ranges::none_of(pictures, [&](const OutputFile& p) { return p.path == arguments.resume; }))
        Reject(Text("--checkpoint: \"{0}\" would never get further, as no -o writes it; give -o \"{0}\"",
                    arguments.resume));
    for (const OutputFile& picture : pictures)
        if (picture.kind == OutputKind::Exr) return;
    Reject("--checkpoint saves renders that can be resumed: it needs -o OUT.exr");
}

// Every camera is the text of a picture setting; the first one is given as that setting.
void AddCameras(CLI::App& render, RenderArguments& arguments) {
    const auto setting = std::ranges::find(PictureSettingTable(), std::string_view("camera"),
                                           [](const PictureSetting& s) { return std::string_view(s.name); });
    CLI::Option* option = render.get_option("--camera");
    const std::string help =
        option->get_description() +
        Wrapped("\nMay be given several times, for a picture each: {camera} in names of outputs");
    render.remove_option(option);
    render
        .add_option_function<std::vector<std::string>>(
            "--camera",
            [&arguments, &setting = *setting](const std::vector<std::string>& texts) {
                for (const std::string& text : texts) {
                    PictureSettings scratch;
                    try {
                        setting.set(scratch, text);
                    } catch (const Error& error) {
                        throw MakeError(error.Kind(), "--camera: {}", error.what());
                    }
                    arguments.cameras.push_back(setting.text(scratch));
                }
                arguments.given[setting.name] = arguments.cameras.front();
                if (arguments.cameras.size() == 1) arguments.cameras.clear();
            },
            help)
        ->type_name(setting->operand)
        ->allow_extra_args(false);
}

std::vector<std::filesystem::path> NamesWithShard(const RenderArguments& arguments) {
    std::vector<std::filesystem::path> names{arguments.report, arguments.resume};
    for (const OutputFile& output : arguments.outputs) names.push_back(output.path);
    return names;
}

// Refuses options with which the samples of a shard could not be merged.
void CheckShard(const RenderArguments& arguments) {
    if (arguments.seconds || arguments.error)
        Reject(
            Text("--shard is a part of a known number of samples, and {} knows none beforehand; give --spp",
                 arguments.seconds ? "--time" : "--error"));
    std::vector<OutputFile> pictures = arguments.outputs;
    if (!arguments.resume.empty()) pictures = PicturesOf(arguments);
    if (std::ranges::none_of(pictures, [](const OutputFile& o) { return o.kind == OutputKind::Exr; }))
        Reject(
            "--shard: a part of the samples is written to an .exr, for merge, and there is no -o "
            "OUT.####.exr");
    if (!arguments.resume.empty() && !arguments.samples)
        Reject("--resume with --shard needs --spp, the samples of all shards together");
    for (const std::filesystem::path& path : NamesWithShard(arguments))
        if (path.filename().string().find('#') != std::string::npos && !HasNumberPlaceholder(path))
            Reject(Text("\"{}\" has more than one run of # for the shard", path));
}

}  // namespace

passes::TonemapSettings DisplayOf(const DisplayArguments& arguments) {
    passes::TonemapSettings display;
    if (arguments.exposureEv) display.exposureEv = *arguments.exposureEv;
    if (arguments.tonemap) display.tonemapOperator = *arguments.tonemap;
    if (arguments.whitePoint && arguments.whitePoint->kelvin)
        display.whiteBalance = passes::WhiteBalance(passes::WhitePointAt(*arguments.whitePoint->kelvin));
    return display;
}

const char* TonemapName(TonemapOperator op) {
    return op == TonemapOperator::Linear ? "raw" : Name(op);
}

void AddDenoiser(CLI::App& app, const std::string& help, const std::vector<std::string_view>& names,
                 std::optional<FileDenoiser>& denoiser) {
    SetChoices(*AddOption(app, "--denoiser", "D", "Denoiser: " + help,
                          [&](const std::string& text) { denoiser = ParseChoice<FileDenoiser>(text); }),
               names);
}

void AddDisplay(CLI::App& app, const char* of, const char* whitePoint, const std::string& whitePointHelp,
                DisplayArguments& arguments) {
    const passes::TonemapSettings display = DisplayOf({});
    AddOption(app, "--exposure", "EV", Text("Exposure{} in stops ({})", of, display.exposureEv),
              [&](const std::string& text) {
                  arguments.exposureEv = static_cast<float>(ParseNumber(text, -100.0, 100.0));
              });
    std::vector<std::string_view> operators, notes;
    for (const TonemapOperator op : Values<TonemapOperator>()) {
        operators.push_back(TonemapName(op));
        notes.push_back(op == TonemapOperator::Linear ? "not encoded, for measuring"
                        : op == TonemapOperator::Srgb ? "no curve"
                                                      : "");
    }
    SetChoices(
        *AddOption(
            app, "--tonemap", "OP",
            Text("Tone curve{}: ", of) +
                ListForHelp(operators, notes, static_cast<size_t>(display.tonemapOperator)),
            [&arguments, operators](const std::string& text) {
                if (text == Name(TonemapOperator::Linear))
                    Reject(
                        "linear numbers are for an .exr; a .png has no curve with srgb, and is not even "
                        "encoded with raw");
                arguments.tonemap = static_cast<TonemapOperator>(ParseChoice(text, operators));
            }),
        operators);
    AddOption(
        app, "--white-point", whitePoint,
        Text("White balance{}: a light of K kelvin, {} to {}, is shown as white ({:g}: no "
             "change){}",
             of, passes::kMinWhitePoint, passes::kMaxWhitePoint, passes::kDisplayWhitePoint, whitePointHelp),
        [&](const std::string& text) { arguments.whitePoint = ParseWhitePoint(text); });
}

CLI::App* AddRender(CLI::App& app, RenderArguments& arguments) {
    CLI::App* render = app.add_subcommand("render", "Path-trace a glTF scene to pictures");
    AddScene(*render, arguments.scene)->required();
    constexpr auto kEndings = Texts(OutputKind{}), kNotes = Notes(OutputKind{});
    AddOutputs(
        *render,
        "Output file: " +
            ListForHelp({kEndings.begin(), kEndings.end()}, {kNotes.begin(), kNotes.end()}, kEndings.size()) +
            ". May be given several times. Default: " + kDefaultPicture + ", or the file that is resumed",
        arguments.outputs);
    AddOption(
        *render, "--spp", "N",
        Text("Samples a pixel; with --resume the total to reach. Default: until the error is {} or there are "
             "{}; denoised, {} or {}",
             RenderArguments::kCleanError, RenderArguments::kMostSamples, RenderArguments::kDenoisedError,
             RenderArguments::kMostDenoisedSamples),
        [&](const std::string& text) { arguments.samples = ParseCount(text, 1); });
    AddOption(*render, "--time", "SECONDS", "Render for this long instead of --spp",
              [&](const std::string& text) { arguments.seconds = ParseNumber(text, 0.0, 1e9); });
    AddOption(
        *render, "--error", "E",
        "Render until the estimated relative error of the picture is E, as 0.01; --spp or --time stop it "
        "earlier",
        [&](const std::string& text) { arguments.error = ParseNumber(text, 1e-6, 1.0); });
    AddOption(*render, "--sample-offset", "N",
              Text("Index of the first sample ({}): renders of disjoint ranges can be merged",
                   SessionDesc{}.firstSample),
              [&](const std::string& text) { arguments.sampleOffset = ParseCount(text); });
    AddOption(*render, "--frames", "A:B:STEP",
              "Render a picture for each time from A to B, in seconds; a run of # in names of outputs is the "
              "number, "
              "as name.####.exr",
              [&](const std::string& text) { arguments.frames = ParseFrames(text); });
    AddOption(*render, "--shard", "I/N|auto",
              "Render part I, from 0, of N parts of the samples, for `raygraph merge`, or of the --frames; "
              "auto: by the "
              "variables of a Slurm job array, srun or mpirun. Without --frames, a run of # in names of "
              "outputs is I",
              [&](const std::string& text) { arguments.shard = ParseShard(text); });
    AddSettings(*render, arguments.given);
    AddCameras(*render, arguments);
    AddOrbits(*render, arguments.given);
    AddOption(
        *render, "--backdrop", "BACKDROP",
        "What a .png shows behind the scene: map (the environment as it is; default), blur:N (blurred by N "
        "degrees), transparent, or a color as for --background, which neither exposure nor tone curve "
        "change. The environment lights and is mirrored all the same. An .exr is transparent there, but "
        "for map",
        [&](const std::string& text) { SetBackdrop(arguments, text); });
    AddOption(
        *render, "--turntable", "N",
        "Render N pictures from all around the scene, the first from --orbit (0,15); a run of # in names of "
        "outputs is the number, as name.##.png",
        [&](const std::string& text) { arguments.turntable = ParseCount(text, 1, FrameRange::kMaxCount); });
    render->add_flag(
        "--contact-sheet", arguments.isContactSheet,
        Wrapped(
            Text("Write all pictures side by side to one .png: those of --turntable, --frames and several "
                 "--camera, else six views of the scene. --size is that of each ({})",
                 ToText(kSheetPicture))));
    AddRoot(*render, arguments.root);
    AddEnvironment(*render, arguments.environment);
    AddDisplay(*render, " of a .png", "K|auto", "; auto: the light of the scene", arguments);
    constexpr auto kTypes = Texts(ExrType{});
    SetChoices(*AddOption(*render, "--exr-type", "TYPE", "Numbers of an .exr: " + ListForHelp(ExrType::Float),
                          [&](const std::string& text) { arguments.exrType = ParseChoice<ExrType>(text); }),
               {kTypes.begin(), kTypes.end()});
    CLI::Option* aov =
        AddOption(*render, "--aov", "LIST",
                  "Further channels of an .exr: " + ListOf(kAovs.front(), Aov::Denoising) +
                      "; light by its path: " + ListOf(Aov::Emission, Aov::Diffuse) +
                      ", or by its first scattering: " + ListOf(Aov::Diffuse, AovOf(kBiases.front())) +
                      "; light that a bias removed: " + ListOf(AovOf(kBiases.front()), std::nullopt) +
                      "; all of these; for `raygraph denoise`: " + Name(Aov::Denoising),
                  [&](const std::string& text) { arguments.aovs = ParseAovs(text); });
    std::vector<std::string_view> aovs{"all"};
    for (const Aov named : kAovs) aovs.push_back(Name(named));
    SetChoices(*aov, aovs, Operands::List);
    CLI::Option* denoise = render->add_flag_callback(
        "--denoise", [&] { arguments.denoise = true; },
        Wrapped(
            "Show a denoised picture in a .png, and add it to an .exr as denoised.R, denoised.G and "
            "denoised.B; the others stay as they are. Default: if all outputs are .png or .jpg, and neither "
            "--spp, --time nor --error is given"));
    render
        ->add_flag_callback(
            "--no-denoise", [&] { arguments.denoise = false; }, "Show the mean of the samples")
        ->excludes(denoise);
    constexpr auto kDenoisers = Texts(passes::Denoiser{});
    AddDenoiser(*render, ListForHelp(passes::Denoiser::Network), {kDenoisers.begin(), kDenoisers.end()},
                arguments.denoiser);
    AddPath(*render, "--resume", "FILE.exr", "Resume a stored render, with its settings", arguments.resume);
    AddOption(
        *render, "--checkpoint", "MINUTES",
        "Write the outputs at this interval; one must be an .exr. --resume may then name a file that does "
        "not exist yet, or one that is complete",
        [&](const std::string& text) { arguments.checkpointMinutes = ParseNumber(text, 1e-3, 1e6); });
    AddPath(*render, "--settings-from", "FILE.exr",
            "Take the settings of the picture from a render; given options override them",
            arguments.settingsFrom);
    AddTracing(*render, arguments.tracing);
    AddDevice(*render, arguments.device);
    AddOption(*render, "--devices", "LIST",
              "Devices that share the samples: all (of the best kind), or indices, as 0,1",
              [&](const std::string& text) { arguments.devices = ValidatedDevices(text); })
        ->excludes("--device");
    AddValidate(*render, arguments.isValidating);
    AddPath(*render, "--report", "FILE.json", "Write a report: the scene, times, memory, the error",
            arguments.report);
    AddProgress(*render, arguments);
    AddOutput(*render, arguments);
    return render;
}

void CheckDisplay(const DisplayArguments& arguments, const std::vector<OutputFile>& pictures) {
    const auto isShown = [](const OutputFile& picture) { return IsDisplayed(picture.kind); };
    const char* option = arguments.exposureEv   ? "--exposure"
                         : arguments.tonemap    ? "--tonemap"
                         : arguments.whitePoint ? "--white-point"
                                                : nullptr;
    if (option != nullptr && std::ranges::none_of(pictures, isShown))
        Reject(Text("{} is of a .png, and none is written", option));
}

void CheckRender(const RenderArguments& arguments) {
    CheckProgress(arguments);
    if (arguments.frames && !arguments.isContactSheet) CheckFrames(arguments);
    if (arguments.turntable) CheckTurntable(arguments);
    if (arguments.isContactSheet) CheckContactSheet(arguments);
    if (!arguments.cameras.empty()) CheckCameras(arguments);
    CheckCheckpoints(arguments);
    if (arguments.shard && !arguments.frames) CheckShard(arguments);
    if (arguments.samples && arguments.seconds) Reject("--spp and --time exclude each other");
    // A resumed render may have a map, which is not checked here
    if (arguments.resume.empty() || !arguments.environment.empty())
        CheckEnvironment(arguments.given, !arguments.environment.empty());
    if (!arguments.settingsFrom.empty() && !arguments.resume.empty())
        Reject("--settings-from begins a render; --resume goes on with one");
    CheckDisplay(arguments, PicturesOf(arguments));
    if (arguments.backdrop &&
        std::ranges::none_of(PicturesOf(arguments), [](const OutputFile& o) { return IsDisplayed(o.kind); }))
        Reject("--backdrop is of a .png, and none is written; an .exr has the scene with --transparent on");
    if (arguments.exrType && std::ranges::none_of(PicturesOf(arguments), [](const OutputFile& o) {
            return o.kind == OutputKind::Exr;
        }))
        Reject("--exr-type is of an .exr, and none is written");
    if (arguments.denoise == true && std::ranges::all_of(PicturesOf(arguments), [](const OutputFile& o) {
            return o.kind == OutputKind::Hdr;
        }))
        Reject("--denoise is of a .png and an .exr, and none is written");
    if (arguments.denoiser && arguments.denoise != true)
        Reject("--denoiser needs --denoise: add it, or leave --denoiser out");
    if (arguments.denoiser == FileDenoiser::Oidn)
        Reject(
            "--denoiser oidn works only with `raygraph denoise`: render with --aov denoising -o FILE.exr, "
            "then "
            "run `raygraph denoise FILE.exr --denoiser oidn -o OUT.png`");
    if (arguments.exrType == ExrType::Half && !arguments.resume.empty())
        for (const OutputFile& picture : PicturesOf(arguments))
            if (picture.path == arguments.resume)
                Reject(
                    Text("--exr-type half: {} would lose its sums, and could not be resumed again; give "
                         "another -o",
                         picture.path));
}

void ApplyBackdrop(RenderArguments& arguments) {
    std::optional<passes::BackdropSettings>& backdrop = arguments.backdrop;
    const auto transparent = arguments.given.find("transparent");
    arguments.isCutOut = !backdrop && transparent != arguments.given.end() && transparent->second == "on";
    const bool isMap = backdrop && !backdrop->color && backdrop->blurDegrees == 0.0f;
    if (isMap) {
        backdrop.reset();
        arguments.given.erase("transparent");
    }
    if (!HideBehindGround(arguments.given) && isMap) arguments.given["transparent"] = "off";
}

std::optional<passes::BackdropSettings> BackdropOf(const RenderArguments& arguments,
                                                   const PictureSettings& settings) {
    const bool showsShadow = settings.hasGround && settings.paths.isEnvironmentHidden;
    if (!arguments.backdrop && showsShadow && !arguments.isCutOut) return passes::BackdropSettings{};
    return arguments.backdrop;
}

void ApplyCameras(RenderArguments& arguments) {
    const auto given = arguments.given.find("camera");
    const bool isGiven = given != arguments.given.end();
    if (arguments.turntable) {
        scene::Orbit orbit = isGiven ? *scene::OrbitFromText(given->second) : scene::Orbit{0.0f, 15.0f};
        orbit.isTurntable = true;
        const float start = orbit.azimuth;
        for (uint32_t i = 0; i < *arguments.turntable; ++i) {
            orbit.azimuth = start + 360.0f * static_cast<float>(i) / static_cast<float>(*arguments.turntable);
            arguments.cameras.push_back(scene::ToText(orbit));
        }
    } else if (arguments.isContactSheet && !isGiven && !arguments.frames) {
        arguments.cameras.push_back(scene::ToText(scene::Orbit{30.0f, 20.0f}));
        for (const std::string_view side : {"front", "right", "back", "left", "top"})
            for (const auto& [name, orbit] : kDirections)
                if (name == side) arguments.cameras.push_back(scene::ToText(orbit));
    }
    if (!arguments.cameras.empty()) arguments.given["camera"] = arguments.cameras.front();
    if (arguments.isContactSheet && arguments.settingsFrom.empty())
        arguments.given.try_emplace("size", ToText(kSheetPicture));
}

void ApplyShard(RenderArguments& arguments) {
    if (!arguments.shard) return;
    const Shard shard = *arguments.shard;
    if (arguments.frames) {
        arguments.frames = PartOf(shard, *arguments.frames);
        return;
    }
    const ShardPart part = PartOf(shard, arguments.samples.value_or(RenderArguments::kDefaultSamples));
    const uint64_t first = uint64_t{arguments.sampleOffset.value_or(0)} + part.begin;
    if (first > std::numeric_limits<uint32_t>::max())
        Reject(Text("--sample-offset {}: {} begins with sample {}, beyond the last, 4294967295",
                    arguments.sampleOffset.value_or(0), Describe(shard), first));
    arguments.sampleOffset = static_cast<uint32_t>(first);
    arguments.samples = part.end - part.begin;
    const auto name = [&](std::filesystem::path& path) {
        if (HasNumberPlaceholder(path)) path = Numbered(path, shard.index);
    };
    for (OutputFile& output : arguments.outputs) name(output.path);
    name(arguments.report);
    name(arguments.resume);
}

std::string NothingToRenderReason(const RenderArguments& arguments) {
    if (!arguments.shard) return "";
    if (arguments.frames)
        return arguments.frames->Count() > 0 ? "" : Describe(*arguments.shard) + " has no frame to render";
    return arguments.samples != 0u ? "" : Describe(*arguments.shard) + " has no sample to render";
}

}  // namespace raygraph::cli

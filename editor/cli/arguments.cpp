#include "editor/cli/arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/exit_code.h"
#include "editor/cli/version.h"
#include "editor/session/parse.h"
#include "editor/session/session.h"
#include "editor/session/setting_table.h"

namespace raygraph::cli {

namespace {

// Help of options in lines that fit a terminal; CLI11 indents them.
constexpr size_t kHelpIndent = 28, kHelpWidth = 72;

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

// An option with one operand, given at most once. `take` may throw Error: the option's name is put before it.
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

void AddPath(CLI::App& app, const std::string& name, const char* operand, const char* help,
             std::filesystem::path& path) {
    AddOption(app, name, operand, help, [name, &path](const std::string& text) {
        if (text.empty()) throw Error(ErrorKind::Usage, "an empty path");
        path = text;
    });
}

void AddVariant(CLI::App& app, std::string& variant) {
    AddOption(app, "--variant", "VARIANT", "Which variant of the scene's materials, by name or index (none)",
              [&variant](const std::string& text) { variant = text; });
}

void AddPointsAndLines(CLI::App& app, scene::PointsAndLines& radii) {
    const auto add = [&](const char* option, const std::string& what, scene::RoundRadius& radius) {
        AddOption(app, option, "RADIUS", what + kRadiusHelp,
                  [&radius](const std::string& text) { radius = scene::ParseRoundRadius(text); });
    };
    add("--points", "Radius of the scene's points, shown as spheres", radii.points);
    add("--lines", "Radius of the scene's lines, shown as capsules", radii.lines);
}

CLI::Option* AddScene(CLI::App& app, std::filesystem::path& path) {
    return app
        .add_option_function<std::string>(
            "FILE", [&path](const std::string& text) { path = text; }, "glTF scene, .gltf or .glb")
        ->type_name("");
}

// The picture settings of these names; all of the table for none. `defaults` are the command's.
void AddSettings(CLI::App& app, SettingTexts& given, const std::vector<std::string_view>& names = {},
                 const PictureSettings& defaults = {}) {
    for (const PictureSetting& setting : PictureSettingTable()) {
        if (!names.empty() && std::ranges::find(names, setting.name) == names.end()) continue;
        CLI::Option* option =
            AddOption(app, std::string("--") + setting.name, setting.operand, setting.HelpWith(defaults),
                      [&setting, &given](const std::string& text) {
                          PictureSettings scratch;
                          setting.set(scratch, text);
                          given[setting.name] = setting.text(scratch);
                      });
        if (setting.isList) option->delimiter(';')->multi_option_policy(CLI::MultiOptionPolicy::Join);
    }
}

void AddDevice(CLI::App& app, std::string& device) {
    AddOption(app, "--device", "DEVICE", "Device by index or by a part of its name (the best suitable)",
              [&device](const std::string& text) { device = text; });
}

void AddLog(CLI::App& app, OutputArguments& arguments) {
    // As a function: CLI11 2.4 takes a flag that counts into a number as given from the start, and --quiet,
    // which excludes it, would always be refused.
    app.add_flag_function(
        "-v,--verbose", [&arguments](int64_t count) { arguments.verbosity = static_cast<uint32_t>(count); },
        Wrapped("Say more on stderr: what is done and how long it takes; -vv: debug messages too"));
    AddPath(app, "--log", "FILE", "Add messages to a file as well, from information on (with -vv all)",
            arguments.logFile);
}

void AddOutput(CLI::App& app, OutputArguments& arguments) {
    CLI::Option* quiet = app.add_flag("--quiet", arguments.isQuiet, "No progress, no warnings, no summary");
    AddLog(app, arguments);
    quiet->excludes("--verbose");
}

void AddEnvironment(CLI::App& app, std::filesystem::path& environment) {
    AddPath(app, "--env", "FILE", "Equirectangular environment map, .hdr or .exr", environment);
}

// "albedo, normal": from one up to another, which is not in it; without another all the rest.
std::string ListOf(Aov first, std::optional<Aov> end) {
    std::string list;
    for (const Aov aov : kAovs)
        if (first <= aov && (!end || aov < *end)) list += std::string(list.empty() ? "" : ", ") + Name(aov);
    return list;
}

CLI::App* AddRender(CLI::App& app, RenderArguments& arguments) {
    CLI::App* render = app.add_subcommand("render", "Path-trace a glTF scene to pictures");
    AddScene(*render, arguments.scene)->required();
    constexpr auto kEndings = Texts(OutputKind{}), kNotes = Notes(OutputKind{});
    render
        ->add_option_function<std::vector<std::string>>(
            "-o,--output",
            [&arguments](const std::vector<std::string>& paths) {
                for (const std::string& path : paths) {
                    try {
                        arguments.outputs.push_back(ParseOutput(path));
                    } catch (const Error& error) {
                        throw MakeError(error.Kind(), "-o: {}", error.what());
                    }
                }
            },
            Wrapped("Picture to write: " +
                    ListForHelp({kEndings.begin(), kEndings.end()}, {kNotes.begin(), kNotes.end()},
                                kEndings.size()) +
                    "; may be given several times. Default: " + kDefaultPicture +
                    ", or the file that is resumed"))
        ->type_name("OUT")
        ->allow_extra_args(false);
    AddOption(
        *render, "--spp", "N",
        Text("Samples a pixel ({}); with --resume the total to reach", RenderArguments::kDefaultSamples),
        [&](const std::string& text) { arguments.samples = ParseCount(text, 1); });
    AddOption(*render, "--time", "SECONDS", "Render for so long, instead of --spp",
              [&](const std::string& text) { arguments.seconds = ParseNumber(text, 0.0, 1e9); });
    AddOption(*render, "--error", "E",
              "Render until the estimated relative error of the picture is E, 0.01 say; --spp or --time stop "
              "it earlier",
              [&](const std::string& text) { arguments.error = ParseNumber(text, 1e-6, 1.0); });
    AddOption(*render, "--sample-offset", "N",
              Text("Index of the first sample ({}): renders of disjoint ranges can be merged",
                   SessionDesc{}.firstSample),
              [&](const std::string& text) { arguments.sampleOffset = ParseCount(text); });
    AddOption(
        *render, "--frames", "A:B:STEP",
        "Render a picture for each of these times of the animations, in seconds, instead of --at; names "
        "of outputs have a run of # for the number, as name.####.exr",
        [&](const std::string& text) { arguments.frames = ParseFrames(text); });
    AddSettings(*render, arguments.given);
    AddEnvironment(*render, arguments.environment);
    const passes::TonemapSettings display = DisplayOf({});
    AddOption(*render, "--exposure", "EV", Text("Stops of exposure of a .png ({})", display.exposureEv),
              [&](const std::string& text) {
                  arguments.exposureEv = static_cast<float>(ParseNumber(text, -100.0, 100.0));
              });
    AddOption(*render, "--tonemap", "OP", "Tone curve of a .png: " + ListForHelp(display.tonemapOperator),
              [&](const std::string& text) { arguments.tonemap = ParseChoice<TonemapOperator>(text); });
    AddOption(*render, "--aov", "LIST",
              "Further channels of an .exr: " + ListOf(kAovs.front(), Aov::Emission) +
                  "; the light by its path: " + ListOf(Aov::Emission, Aov::Diffuse) +
                  ", and by what scattered it first: " + ListOf(Aov::Diffuse, AovOf(kBiases.front())) +
                  "; what a bias took: " + ListOf(AovOf(kBiases.front()), std::nullopt) +
                  "; or all. Samples and variance are always there",
              [&](const std::string& text) { arguments.aovs = ParseAovs(text); });
    AddPath(*render, "--resume", "FILE.exr",
            "Go on with a render that was written before; its settings are kept", arguments.resume);
    AddDevice(*render, arguments.device);
    render->add_flag("--validate", arguments.isValidating,
                     Wrapped("Turn on the Vulkan validation layers and fail on any message"));
    AddPath(*render, "--report", "FILE.json", "Write what was rendered, how long it took and what it used",
            arguments.report);
    AddOutput(*render, arguments);
    return render;
}

CLI::App* AddBench(CLI::App& app, BenchArguments& arguments) {
    CLI::App* bench = app.add_subcommand("bench", "Time the passes against the barest ray tracing");
    AddScene(*bench, arguments.scene)->required();
    AddSettings(
        *bench, arguments.given,
        {"size",  "camera",   "scene",     "variant",      "at",           "clips",         "points",
         "lines", "sampler",  "brdf",      "multiscatter", "nee",          "light-sampler", "mis",
         "rr",    "rr-start", "max-depth", "background",   "env-rotation", "env-tint",      "texture-budget"},
        BenchDefaults());
    AddEnvironment(*bench, arguments.environment);
    AddOption(*bench, "--frames", "N", Text("Timed frames of each kind in a round ({})", arguments.frames),
              [&](const std::string& text) { arguments.frames = ParseCount(text, 1, 100000); });
    AddOption(*bench, "--rounds", "N",
              Text("Rounds; times are medians over all of them ({})", arguments.rounds),
              [&](const std::string& text) { arguments.rounds = ParseCount(text, 1, 1000); });
    AddPath(*bench, "--json", "FILE", "Write the result line to a file as well", arguments.json);
    AddPath(
        *bench, "--compare", "FILE",
        "Compare with the result of the same scene stored there, by the cost relative to limit_path; exit "
        "status 6 if it is slower",
        arguments.compare);
    AddOption(*bench, "--tolerance", "SHARE",
              Text("With --compare: by how much the cost may rise ({})", BenchArguments::kDefaultTolerance),
              [&](const std::string& text) { arguments.tolerance = ParseNumber(text, 0.0, 100.0); });
    AddDevice(*bench, arguments.device);
    AddOutput(*bench, arguments);
    return bench;
}

CLI::App* AddInfo(CLI::App& app, InfoArguments& arguments) {
    CLI::App* info = app.add_subcommand(
        "info", "Show what is in a scene, the devices of this machine, or glTF extensions");
    AddScene(*info, arguments.scene);
    AddOption(*info, "--scene", "SCENE", "Which scene of the glTF file, by name or index",
              [&](const std::string& text) { arguments.sceneChoice = text; });
    AddVariant(*info, arguments.variant);
    AddPointsAndLines(*info, arguments.pointsAndLines);
    info->add_flag("--devices", arguments.isListingDevices,
                   "List every Vulkan device, and why the unsuitable ones are not used");
    info->add_flag("--extensions", arguments.isListingExtensions,
                   "List glTF extensions: which are read, and why others are not");
    AddOutput(*info, arguments);
    return info;
}

CLI::App* AddGraph(CLI::App& app, GraphArguments& arguments) {
    CLI::App* graph = app.add_subcommand("graph", "Show the plan of a frame: passes, barriers, memory");
    AddScene(*graph, arguments.scene)->required();
    AddSettings(*graph, arguments.given,
                {"size", "camera", "scene", "variant", "at", "clips", "points", "lines"});
    graph->add_flag("--dot", arguments.isDot, "As Graphviz");
    graph->add_flag("--first", arguments.isFirstFrame,
                    "The first frame, which uploads and builds the scene, instead of a later one");
    AddDevice(*graph, arguments.device);
    AddOutput(*graph, arguments);
    return graph;
}

CLI::App* AddMerge(CLI::App& app, MergeArguments& arguments) {
    CLI::App* merge = app.add_subcommand("merge", "Merge renders of disjoint sample ranges into one");
    merge
        ->add_option_function<std::vector<std::string>>(
            "FILES",
            [&](const std::vector<std::string>& paths) {
                arguments.inputs.assign(paths.begin(), paths.end());
            },
            "Renders: two or more .exr files of `raygraph render`")
        ->type_name("")
        ->required();
    AddPath(*merge, "-o,--output", "OUT.exr", "The merged render (required)", arguments.output);
    AddOutput(*merge, arguments);
    return merge;
}

CLI::App* AddEdit(CLI::App& app, EditArguments& arguments) {
    CLI::App* edit =
        app.add_subcommand("edit", "Open a window on a scene: path-traced and raster views, edits");
    AddScene(*edit, arguments.scene);
    AddVariant(*edit, arguments.variant);
    AddSettings(*edit, arguments.given, {"texture-budget"});
    AddPointsAndLines(*edit, arguments.pointsAndLines);
    AddPath(*edit, "--headless-script", "FILE",
            "Play keys, mouse and waits from a file, without a window; see docs/editor.md", arguments.script);
    AddPath(*edit, "--shaders", "FOLDER", "Shader sources, for F5 to reload from", arguments.shaders);
    AddDevice(*edit, arguments.device);
    edit->add_flag("--validate", arguments.isValidating,
                   "Turn on the Vulkan validation layers and fail on any message");
    AddLog(*edit, arguments);
    return edit;
}

[[noreturn]] void Refuse(const std::string& message) {
    throw Error(ErrorKind::Usage, message);
}

void CheckEnvironment(const SettingTexts& given, bool hasMap) {
    if (given.contains("background") && hasMap) Refuse("--background and --env exclude each other");
    for (const char* option : {"env-rotation", "env-tint"})
        if (given.contains(option) && given.contains("background"))
            Refuse(Text("--{} is of a map, which --background replaces", option));
}

void CheckFrames(const RenderArguments& arguments) {
    if (arguments.given.contains("at")) Refuse("--frames and --at exclude each other");
    if (!arguments.resume.empty()) Refuse("--frames begins each frame; --resume goes on with one");
    CommandFiles files = FilesOf(arguments, {});
    for (const std::filesystem::path& path : files.outputs)
        if (!HasNumberPlace(path))
            Refuse(Text("{} has no single run of # for the numbers of --frames, as name.####.exr",
                        Quoted(path.string(), 1024)));
}

void CheckRender(const RenderArguments& arguments) {
    if (arguments.frames) CheckFrames(arguments);
    if (arguments.samples && arguments.seconds) Refuse("--spp and --time exclude each other");
    // A resumed render may have a map, which is not looked at here
    if (arguments.resume.empty() || !arguments.environment.empty())
        CheckEnvironment(arguments.given, !arguments.environment.empty());
    if (!arguments.exposureEv && !arguments.tonemap) return;
    for (const OutputFile& picture : PicturesOf(arguments))
        if (picture.kind == OutputKind::Png) return;
    Refuse(Text("{} is of a .png, and none is written", arguments.exposureEv ? "--exposure" : "--tonemap"));
}

void CheckBench(const BenchArguments& arguments) {
    CheckEnvironment(arguments.given, !arguments.environment.empty());
    if (arguments.tolerance && arguments.compare.empty())
        Refuse("--tolerance is of a comparison: it needs --compare");
}

void CheckMerge(const MergeArguments& arguments) {
    if (arguments.inputs.size() < 2) Refuse("merge needs two or more renders");
    if (arguments.output.empty()) Refuse("merge needs -o OUT.exr");
    if (ParseOutput(arguments.output).kind != OutputKind::Exr)
        Refuse(Text("-o: \"{}\" does not end in .exr", arguments.output.string()));
}

void CheckInfo(const InfoArguments& arguments) {
    const int wanted =
        int{!arguments.scene.empty()} + arguments.isListingDevices + arguments.isListingExtensions;
    if (wanted != 1) Refuse("info needs either a scene file, --devices or --extensions");
    if (!arguments.scene.empty()) return;
    const char* lists = arguments.isListingDevices ? "--devices" : "--extensions";
    if (!arguments.sceneChoice.empty())
        Refuse(Text("--scene is one of a scene file, and {} lists none", lists));
    if (!arguments.variant.empty())
        Refuse(Text("--variant is one of a scene file, and {} lists none", lists));
    if (arguments.pointsAndLines != scene::PointsAndLines{})
        Refuse(Text("--points and --lines are of a scene file, and {} lists none", lists));
}

void CheckEdit(const EditArguments& arguments) {
    if (arguments.scene.empty() && !arguments.variant.empty())
        Refuse("--variant is one of a scene: it needs a FILE");
}

std::string OneLine(std::string text) {
    std::ranges::replace(text, '\n', ' ');
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return Printable(text, 1024);
}

}  // namespace

passes::TonemapSettings DisplayOf(const RenderArguments& arguments) {
    passes::TonemapSettings display;
    if (arguments.exposureEv) display.exposureEv = *arguments.exposureEv;
    if (arguments.tonemap) display.tonemapOperator = *arguments.tonemap;
    return display;
}

PictureSettings BenchDefaults() {
    PictureSettings settings;
    settings.paths.biases.maxDepth = 16;
    return settings;
}

Arguments ParseArguments(int argc, const char* const* argv) {
    CLI::App app("Raygraph: path-traces glTF scenes on Vulkan devices.", "raygraph");
    app.require_subcommand(0, 1);  // none is our own error: CLI11's would hide a misspelt one
    app.get_formatter()->column_width(kHelpIndent);
    app.get_formatter()->label("SUBCOMMAND", "COMMAND");
    app.get_formatter()->label("REQUIRED", "(required)");
    app.set_version_flag("--version", std::string("raygraph ") + kVersion);
    app.footer(
        "raygraph COMMAND --help shows a command's options.\n"
        "Exit status: " +
        ListOfExitCodes() + ".");

    RenderArguments renderArguments;
    BenchArguments benchArguments;
    InfoArguments infoArguments;
    GraphArguments graphArguments;
    MergeArguments mergeArguments;
    EditArguments editArguments;
    const CLI::App* render = AddRender(app, renderArguments);
    const CLI::App* bench = AddBench(app, benchArguments);
    const CLI::App* info = AddInfo(app, infoArguments);
    const CLI::App* graph = AddGraph(app, graphArguments);
    const CLI::App* merge = AddMerge(app, mergeArguments);
    const CLI::App* edit = AddEdit(app, editArguments);

    for (CLI::App* command : app.get_subcommands({})) command->group("Commands");

    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        return ShowText{app.help()};
    } catch (const CLI::CallForVersion&) {
        return ShowText{app.version() + "\n"};
    } catch (const CLI::ParseError& error) {
        Refuse(OneLine(error.what()) + " (see raygraph --help)");
    }
    if (*render) {
        CheckRender(renderArguments);
        return renderArguments;
    }
    if (*bench) {
        CheckBench(benchArguments);
        return benchArguments;
    }
    if (*info) {
        CheckInfo(infoArguments);
        return infoArguments;
    }
    if (*graph) return graphArguments;
    if (*edit) {
        CheckEdit(editArguments);
        return editArguments;
    }
    if (!*merge)
        Refuse("a command is needed: render, edit, bench, info, graph or merge (see raygraph --help)");
    CheckMerge(mergeArguments);
    return mergeArguments;
}

}  // namespace raygraph::cli

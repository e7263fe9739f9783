#include "editor/cli/arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <set>
#include <sstream>
#include <utility>

#include "base/files.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/command_tree.h"
#include "editor/cli/completion.h"
#include "editor/cli/exit_code.h"
#include "editor/cli/options.h"
#include "editor/cli/version.h"
#include "editor/graph_run/graph_file.h"
#include "editor/session/settings/parse.h"

namespace raygraph::cli {

namespace {

constexpr std::pair<const char*, const char*> kEnvironment[] = {
    {"RAYGRAPH_DEVICE", "device, by index or by a part of its name, where --device names none"},
    {"RAYGRAPH_LOG", "level of messages, for all or by category: warning,shaders=debug,cache=off"},
    {"XDG_CACHE_HOME", "has the folder raygraph with compiled pipelines and references (default: ~/.cache)"},
    {"XDG_CONFIG_HOME", "has the folder raygraph with the editor's settings (default: ~/.config)"},
};

CLI::App* AddBench(CLI::App& app, BenchArguments& arguments) {
    CLI::App* bench = app.add_subcommand("bench", "Time the passes against the barest ray tracing");
    AddScene(*bench, arguments.scene)->required();
    AddSettings(
        *bench, arguments.given,
        {"size",  "camera",   "scene",     "variant",      "at",           "clips",         "points",
         "lines", "sampler",  "brdf",      "multiscatter", "nee",          "light-sampler", "mis",
         "rr",    "rr-start", "max-depth", "background",   "env-rotation", "env-tint",      "texture-budget"},
        BenchDefaults());
    AddRoot(*bench, arguments.root);
    AddEnvironment(*bench, arguments.environment);
    AddOption(*bench, "--frames", "N", Text("Timed frames of each kind in a round ({})", arguments.frames),
              [&](const std::string& text) { arguments.frames = ParseCount(text, 1, 100000); });
    AddOption(*bench, "--rounds", "N",
              Text("Rounds; times are medians over all of them ({})", arguments.rounds),
              [&](const std::string& text) { arguments.rounds = ParseCount(text, 1, 1000); });
    AddOption(*bench, "--samples-at-once", "N",
              "Samples of every pixel in a frame (as many as a render takes)",
              [&](const std::string& text) { arguments.batchSize = ParseCount(text, 1, 64); });
    bench->add_flag("--viewport", arguments.hasViewport,
                    Wrapped("Also time a host's viewport: the cost of a sample without a budget and with the "
                            "editor's, relative to the frames of a render"));
    bench->add_flag("--pipelines", arguments.isListingPipelines,
                    Wrapped("Also show the time to create each pipeline, and the driver's statistics of its "
                            "programs: registers, memory"));
    AddPath(*bench, "--json", "FILE", "Write the result line to a file as well", arguments.json);
    AddPath(
        *bench, "--compare", "FILE",
        "Compare with the result of the same scene stored there, by the cost relative to limit_path; exit "
        "status 6 if it is slower",
        arguments.compare);
    AddOption(*bench, "--tolerance", "SHARE",
              Text("With --compare: by how much the cost may rise ({})", BenchArguments::kDefaultTolerance),
              [&](const std::string& text) { arguments.tolerance = ParseNumber(text, 0.0, 100.0); });
    AddTracing(*bench, arguments.tracing);
    AddDevice(*bench, arguments.device);
    AddProgress(*bench, arguments);
    AddOutput(*bench, arguments);
    return bench;
}

CLI::App* AddInfo(CLI::App& app, InfoArguments& arguments) {
    CLI::App* info = app.add_subcommand(
        "info", "Show what is in a scene, the devices of this machine, or glTF extensions");
    AddScene(*info, arguments.scene);
    AddOption(*info, "--scene", "SCENE", "Scene of the glTF file, by name or index (the file's default)",
              [&](const std::string& text) { arguments.sceneChoice = text; });
    AddVariant(*info, arguments.variant);
    AddPointsAndLines(*info, arguments.pointsAndLines);
    AddRoot(*info, arguments.root);
    info->add_flag("--devices", arguments.isListingDevices,
                   "List every Vulkan device, and why the unsuitable ones are not used");
    info->add_flag("--extensions", arguments.isListingExtensions,
                   "List glTF extensions: which are read, and why others are not");
    info->add_flag("--json", arguments.isJson, "Print JSON");
    AddOutput(*info, arguments);
    return info;
}

void AddGraphRun(CLI::App& graph, GraphRunArguments& arguments) {
    CLI::App* run = graph.add_subcommand("run", "Run a render graph that a JSON file describes");
    AddOption(*run, "FILE.json", "", "Description of the graph; see docs/graph.md",
              [&](const std::string& text) { arguments.description = text; })
        ->required();
    AddPath(*run, "-o,--output", "FOLDER", "Write the outputs into this folder (the working folder)",
            arguments.folder);
    AddOption(
        *run, "--frames", "N", "Number of frames (that of the description)",
        [&](const std::string& text) { arguments.frames = ParseCount(text, 1, graph_run::kMaxFrames); });
    CLI::Option* dot = run->add_flag("--dot", arguments.isDot, "Print the plan for Graphviz");
    run->add_flag("--plan", arguments.showsPlan, "Print the plan of the last frame")->excludes(dot);
    run->add_flag("--time", arguments.showsTimes,
                  "Print each pass with its GPU time, the median of the frames")
        ->excludes(dot);
    AddDevice(*run, arguments.device);
    AddValidate(*run, arguments.isValidating);
    AddOutput(*run, arguments);
}

// `run` is a command of its own within this one.
CLI::App* AddGraph(CLI::App& app, GraphArguments& arguments, GraphRunArguments& run) {
    CLI::App* graph = app.add_subcommand("graph", "Show the plan of a frame: passes, barriers, memory");
    AddScene(*graph, arguments.scene);  // CLI11 would take `run` for one that is required
    AddGraphRun(*graph, run);
    AddSettings(*graph, arguments.given,
                {"size", "camera", "scene", "variant", "at", "clips", "points", "lines", "light"});
    AddRoot(*graph, arguments.root);
    CLI::Option* dot = graph->add_flag("--dot", arguments.isDot, "Print Graphviz");
    graph->add_flag("--json", arguments.isJson, "Print JSON")->excludes(dot);
    graph->add_flag("--first", arguments.isFirstFrame,
                    "Show the first frame, which uploads and builds the scene, not a later one");
    AddDevice(*graph, arguments.device);
    AddOutput(*graph, arguments);
    return graph;
}

CLI::App* AddExplain(CLI::App& app, ExplainArguments& arguments) {
    CLI::App* explain =
        app.add_subcommand("explain", "Show which paths made a pixel what it is, or where a render is noisy");
    AddScene(*explain, arguments.scene)
        ->description("glTF scene, .gltf or .glb, with --pixel; or a render, .exr: its noisiest pixels")
        ->required();
    ExplainRequest& request = arguments.request;
    AddOption(*explain, "--pixel", "X,Y", "Pixel of the scene's picture, from its upper left corner",
              [&](const std::string& text) {
                  const std::vector<std::string_view> parts = ParseList(text);
                  if (parts.size() != 2) Reject(Text("\"{}\" is not X,Y", Printable(text)));
                  request.pixel = {ParseCount(parts[0]), ParseCount(parts[1])};
                  arguments.hasPixel = true;
              });
    AddPath(*explain, "--noise-map", "FILE.png",
            "Write the relative error of the render's pixels as a heat map, from .001 (dark blue) to 1 "
            "(light yellow)",
            arguments.noiseMap);
    AddPath(*explain, "--group-map", "FILE.png",
            "Write which light group lights each pixel of a render with --light-group", arguments.groupMap);
    CLI::Option* sample = AddOption(*explain, "--sample", "N", "Explain the sample of this index",
                                    [&](const std::string& text) {
                                        request.sample = ParseCount(text);
                                        arguments.hasSamples = true;
                                    });
    AddOption(*explain, "--brightest", "K", Text("Explain the K brightest samples ({})", request.brightest),
              [&](const std::string& text) { request.brightest = ParseCount(text, 1, 1000); })
        ->excludes(sample);
    AddOption(*explain, "--spp", "N",
              Text("Number of samples from which the brightest are chosen ({}, or those of --settings-from)",
                   request.sampleCount),
              [&](const std::string& text) {
                  request.sampleCount = ParseCount(text, 1, 1u << 24);
                  arguments.hasSamples = true;
              })
        ->excludes(sample);
    AddOption(*explain, "--sample-offset", "N", Text("Index of the first of them ({})", request.firstSample),
              [&](const std::string& text) {
                  request.firstSample = ParseCount(text);
                  arguments.hasSamples = true;
              })
        ->excludes(sample);
    AddSettings(*explain, arguments.given,
                {"size",         "camera",    "scene",          "variant",      "at",
                 "clips",        "shutter",   "points",         "lines",        "seed",
                 "sampler",      "brdf",      "distribution",   "masking",      "fresnel",
                 "multiscatter", "nee",       "light-sampler",  "mis",          "rr",
                 "rr-start",     "max-depth", "clamp-indirect", "regularize",   "shadow-terminator",
                 "texture-lod",  "aperture",  "focus",          "env-rotation", "env-tint",
                 "background",   "light",     "texture-budget"});
    AddOrbits(*explain, arguments.given);
    AddRoot(*explain, arguments.root);
    AddEnvironment(*explain, arguments.environment);
    AddPath(*explain, "--settings-from", "FILE.exr",
            "Take the settings of the picture, and its samples, from a render; given options override them",
            arguments.settingsFrom);
    explain->add_flag("--cpu", arguments.request.isOnCpu, "Trace by the shaders compiled as C++");
    explain->add_flag("--json", arguments.isJson, "Print JSON");
    AddTracing(*explain, arguments.tracing);
    AddDevice(*explain, arguments.device);
    AddValidate(*explain, arguments.isValidating);
    AddOutput(*explain, arguments);
    return explain;
}

void CheckExplain(const ExplainArguments& arguments) {
    CheckEnvironment(arguments.given, !arguments.environment.empty());
    const bool isRender = LowerExtension(arguments.scene) == ".exr";
    const bool isOfScene = arguments.hasPixel || arguments.request.isOnCpu || !arguments.given.empty() ||
                           !arguments.settingsFrom.empty();
    if (isRender && isOfScene)
        Reject(
            Text("explain {} takes no options of a scene: a pixel's paths are those of raygraph explain "
                 "SCENE --settings-from {} --pixel X,Y",
                 Printable(arguments.scene.string()), Printable(arguments.scene.string())));
    if (!isRender && !(arguments.noiseMap.empty() && arguments.groupMap.empty()))
        Reject("--noise-map and --group-map show the .exr of a render, not a scene");
    if (!isRender && !arguments.hasPixel) Reject("explain needs --pixel X,Y of the scene's picture");
    for (const std::filesystem::path& map : {arguments.noiseMap, arguments.groupMap})
        if (!map.empty()) ParseOutput(map, std::array{OutputKind::Png});
}

CLI::App* AddMerge(CLI::App& app, MergeArguments& arguments) {
    CLI::App* merge = app.add_subcommand("merge", "Merge renders of disjoint sample ranges into one");
    merge
        ->add_option_function<std::vector<std::string>>(
            "FILES",
            [&](const std::vector<std::string>& paths) {
                arguments.inputs.assign(paths.begin(), paths.end());
            },
            "Renders: .exr files of `raygraph render`; a single one is copied")
        ->type_name("")
        ->required();
    AddPath(*merge, "-o,--output", "OUT.exr", "The merged render (required)", arguments.output);
    AddPath(*merge, "--report", "FILE.json", "Write a report: the merged renders, statistics of the picture",
            arguments.report);
    AddOutput(*merge, arguments);
    return merge;
}

constexpr auto kPngAndExr = std::to_array({OutputKind::Png, OutputKind::Exr});

CLI::App* AddDenoise(CLI::App& app, DenoiseArguments& arguments) {
    CLI::App* denoise = app.add_subcommand("denoise", "Take noise out of a stored render, without its scene");
    AddOption(*denoise, "FILE.exr", "",
              "Render made by `raygraph render --aov denoising` (or --aov albedo,normal, with more noise "
              "left). May also be an output, which replaces it",
              [&](const std::string& text) { arguments.input = text; })
        ->required();
    AddOutputs(*denoise,
               "Output file: .png (tone-mapped) or .exr (the render, and the denoised picture as denoised.R, "
               "denoised.G and denoised.B; required). May be given several times",
               arguments.outputs, kPngAndExr);
    constexpr auto kDenoisers = Texts(FileDenoiser{});
    AddDenoiser(*denoise, ListForHelp(FileDenoiser::Network), {kDenoisers.begin(), kDenoisers.end()},
                arguments.denoiser);
    AddDisplay(*denoise, " of a .png", "K", "", arguments);
    AddDevice(*denoise, arguments.device);
    AddValidate(*denoise, arguments.isValidating);
    AddOutput(*denoise, arguments);
    return denoise;
}

// Adds the options of ComparedArguments.
void AddCompared(CLI::App& app, ComparedArguments& arguments) {
    AddOption(app, "--transfer", "CURVE", "Transfer function of a .png: " + ListForHelp(TransferCurve::Srgb),
              [&](const std::string& text) {
                  const float exposureEv = arguments.transfer.exposureEv;
                  arguments.transfer = ParseTransfer(text);
                  arguments.transfer.exposureEv = exposureEv;
              });
    AddOption(app, "--exposure", "EV",
              "Exposure in stops that a .png has, and with which FLIP and SSIM see the others (0)",
              [&](const std::string& text) {
                  arguments.transfer.exposureEv = static_cast<float>(ParseNumber(text, -100.0, 100.0));
              });
    AddDevice(app, arguments.device);
    AddValidate(app, arguments.isValidating);
}

CLI::App* AddCompare(CLI::App& app, CompareArguments& arguments) {
    CLI::App* compare = app.add_subcommand("compare", "Measure the difference of two pictures");
    compare
        ->add_option_function<std::vector<std::string>>(
            "FILES",
            [&](const std::vector<std::string>& paths) {
                arguments.reference = paths.at(0);
                arguments.picture = paths.at(1);
            },
            Wrapped("The picture that counts as right and the one to measure: .exr, .hdr or .png"))
        ->type_name("")
        ->required()
        ->expected(2);
    AddOutputs(*compare,
               "Output file: .png (map of FLIP) or .exr (R, G and B: picture minus reference; stops; flip). "
               "May be given several times",
               arguments.outputs, kPngAndExr);
    AddPath(*compare, "--json", "FILE", "Write the numbers to a file as well", arguments.json);
    AddCompared(*compare, arguments);
    AddOutput(*compare, arguments);
    return compare;
}

CLI::App* AddVerify(CLI::App& app, VerifyArguments& arguments) {
    CLI::App* verify =
        app.add_subcommand("verify", "Judge pictures of another renderer by the path-traced reference");
    VerifyCase& only = arguments.only;
    AddOption(*verify, "FILE", "", "glTF scene, .gltf or .glb; or a list of scenes and pictures, .json",
              [&](const std::string& text) { only.scene = text; })
        ->required();
    verify
        ->add_option_function<std::vector<std::string>>(
            "PICTURES",
            [&](const std::vector<std::string>& paths) { only.pictures.assign(paths.begin(), paths.end()); },
            "Pictures of the scene: .exr, .hdr or .png")
        ->type_name("");
    AddSettings(*verify, only.given,
                {"size",    "crop",         "camera", "scene",    "variant",    "at",         "clips",
                 "shutter", "points",       "lines",  "seed",     "brdf",       "max-depth",  "aperture",
                 "focus",   "env-rotation", "light",  "env-tint", "background", "light-group"});
    // These mean something else here, or have other defaults
    for (const auto& [name, help] :
         {std::pair{"--size", "Size of the pictures in pixels (that of the first one)"},
          {"--crop", "Part of the picture that the pictures show, counted from its upper left corner (none)"},
          {"--seed", "Seed of the reference's random numbers (2031)"},
          {"--light-group",
           "Name a group of lights, of which the report says whether the picture lacks its light: by "
           "patterns of the "
           "shell for the names of materials, lights and nodes. May be given eight times"}})
        verify->get_option(name)->description(Wrapped(help));
    AddOption(
        *verify, "--against", "VIEW",
        "What the picture shows instead of all light: raster, albedo, normals, depth or another --view of "
        "render",
        [&](const std::string& text) { only.given["view"] = Name(ParseChoice<View>(text)); });
    AddRoot(*verify, only.root);
    AddEnvironment(*verify, only.environment);
    const auto limit = [&](const char* name, const char* help, double Tolerance::*field) {
        AddOption(
            *verify, name, "X", Text("{} ({})", help, only.tolerance.*field),
            [&only, field](const std::string& text) { only.tolerance.*field = ParseNumber(text, 0.0, 1e6); });
    };
    limit("--tolerance", "Relative error that is allowed beyond noise, of tiles and of pixels",
          &Tolerance::relative);
    limit("--bad-tiles", "Share of the tiles that may be beyond it", &Tolerance::tiles);
    limit("--bad-pixels", "Share of the pixels that may be beyond it", &Tolerance::pixels);
    limit("--energy", "Relative error of the mean of the picture that is allowed beyond noise",
          &Tolerance::energy);
    limit("--parts",
          "Relative error that is allowed beyond noise of a part of the light, of an object or a material",
          &Tolerance::parts);
    limit("--flip", "Mean FLIP that is allowed above what noise explains", &Tolerance::flip);
    limit("--ssim", "By how much the SSIM may be below what noise explains", &Tolerance::ssim);
    AddOption(
        *verify, "--region", "object|material:PATTERN=X",
        "Another --tolerance for objects or materials whose names match; X is a number, or ignore. Several "
        "are separated by ;",
        [&](const std::string& text) {
            std::istringstream stream(text);
            for (std::string region; std::getline(stream, region, ';');)
                only.regions.push_back(ParseRegion(region));
        })
        ->delimiter(';')
        ->multi_option_policy(CLI::MultiOptionPolicy::Join);
    AddPath(*verify, "--mask", "FILE", "Picture whose black pixels do not count: .png, .exr or .hdr",
            only.mask);
    AddPath(*verify, "--accepted", "FOLDER",
            "Folder of accepted differences, by the names of the pictures: what is in it counts as right",
            only.accepted);
    verify->add_flag("--update", arguments.isUpdating,
                     Wrapped("Store the difference of each picture that is not right as accepted"));
    AddOption(
        *verify, "--spp", "N",
        Text("The most samples a pixel of the reference ({}); it gets as many as the verdict needs, from "
             "64 on",
             only.maxSamples),
        [&](const std::string& text) { only.maxSamples = ParseCount(text, 2, 1u << 24); });
    AddOption(*verify, "--picture-spp", "N",
              Text("Samples a pixel of a picture that does not say its noise; 0: it has none, as a raster "
                   "picture (estimated, {} or more)",
                   kLeastPictureSamples),
              [&](const std::string& text) { only.pictureSamples = ParseCount(text, 0, 1u << 24); });
    AddOption(*verify, "--jobs", "N", Text("Scenes of a list at a time ({})", arguments.jobs),
              [&](const std::string& text) { arguments.jobs = ParseCount(text, 1, 256); });
    verify->add_flag_callback(
        "--no-cache", [&] { arguments.isCached = false; }, Wrapped("Neither read nor store the reference"));
    AddPath(*verify, "--json", "FILE", "Write the report as JSON", arguments.json);
    AddPath(*verify, "--html", "FILE", "Write the report as one page, with its pictures in it",
            arguments.html);
    AddCompared(*verify, arguments);
    AddProgress(*verify, arguments);
    AddOutput(*verify, arguments);
    return verify;
}

CLI::App* AddEdit(CLI::App& app, EditArguments& arguments) {
    CLI::App* edit = app.add_subcommand("edit", "View and edit a scene in a window, path-traced or drawn");
    AddScene(*edit, arguments.scene);
    AddVariant(*edit, arguments.variant);
    AddSettings(*edit, arguments.given,
                {"camera", "aperture", "focus", "env-rotation", "light", "env-tint", "background", "ground",
                 "texture-budget"});
    AddOption(*edit, "--backdrop", "BACKDROP",
              "What is behind the scene, as for render: map, blur:N, a color or transparent",
              [&](const std::string& text) {
                  static_cast<void>(ParseBackdrop(text));
                  arguments.backdrop = text;
              });
    AddOrbits(*edit, arguments.given);
    AddDisplay(*edit, "", "K", "", arguments);
    AddRoot(*edit, arguments.root);
    AddEnvironment(*edit, arguments.environment);
    std::vector<std::string> names = EditViewNames();
    const std::vector<std::string_view> views(names.begin(), names.end());
    SetChoices(*AddOption(*edit, "--view", "VIEW",
                          "View at the start: " +
                              ListForHelp(views, std::vector<std::string_view>(views.size()), views.size()) +
                              ". Default: the last one",
                          [&](const std::string& text) { arguments.view = ParseEditView(text); }),
               views);
    AddPointsAndLines(*edit, arguments.pointsAndLines);
    AddPath(*edit, "--headless-script", "FILE",
            "Run a script of keys, mouse and waits without a window; see docs/editor.md", arguments.script);
    edit->add_flag("--keys", arguments.isListingKeys, "List the keys and what the mouse does, and exit");
    AddPath(*edit, "--shaders", "FOLDER", "Shader sources, for F5 to reload from", arguments.shaders);
    AddDevice(*edit, arguments.device);
    edit->add_flag("--validate", arguments.isValidating,
                   "Turn on the Vulkan validation layers and fail on any message");
    AddLog(*edit, arguments);
    return edit;
}

CLI::App* AddCompletion(CLI::App& app, Shell& shell) {
    CLI::App* completion =
        app.add_subcommand("completion", "Print a script with which a shell completes command lines");
    constexpr auto kShells = Texts(Shell{});
    CLI::Option* option = completion->add_option_function<std::string>(
        "SHELL", [&shell](const std::string& text) { shell = ParseChoice<Shell>(text); },
        "bash, zsh or fish");
    option->type_name("")->required();
    SetChoices(*option, {kShells.begin(), kShells.end()});
    return completion;
}

void CheckBench(const BenchArguments& arguments) {
    CheckProgress(arguments);
    CheckEnvironment(arguments.given, !arguments.environment.empty());
    if (arguments.tolerance && arguments.compare.empty())
        Reject("--tolerance is of a comparison: it needs --compare");
}

void CheckMerge(const MergeArguments& arguments) {
    if (arguments.output.empty()) Reject("merge needs -o OUT.exr");
    if (ParseOutput(arguments.output).kind != OutputKind::Exr)
        Reject(Text("-o: \"{}\" does not end in .exr", arguments.output));
}

void CheckDenoise(const DenoiseArguments& arguments) {
    if (arguments.outputs.empty()) Reject("denoise needs -o OUT.exr or -o OUT.png");
    CheckDisplay(arguments, arguments.outputs);
    if (arguments.whitePoint && !arguments.whitePoint->kelvin)
        Reject(
            "--white-point auto: needs the scene, which denoise does not read; give a number of kelvin, such "
            "as 5000");
}

void CheckVerify(VerifyArguments& arguments, const CLI::App& verify) {
    CheckProgress(arguments);
    VerifyCase& only = arguments.only;
    only.transfer = arguments.transfer;
    if (LowerExtension(only.scene) == ".json") {
        if (!only.pictures.empty()) Reject("verify: a list has its pictures in it; give none beside it");
        const std::set<std::string> ofRuns{"FILE",     "--update",   "--jobs",        "--no-cache",
                                           "--json",   "--html",     "--validate",    "--quiet",
                                           "--device", "--progress", "--no-progress", "--verbose"};
        for (const CLI::Option* option : verify.get_options())
            if (option->count() > 0 && !ofRuns.contains(option->get_name()))
                Reject(Text("{} cannot be used with a list; set it in {}", option->get_name(),
                            Printable(only.scene.filename().string())));
        arguments.suite = std::exchange(only.scene, {});
        return;
    }
    if (only.pictures.empty()) Reject("verify needs a picture of the scene");
    CheckEnvironment(only.given, !only.environment.empty());
    if (arguments.isUpdating && only.accepted.empty())
        Reject("--update stores differences in the folder of --accepted, which is missing");
}

void CheckInfo(const InfoArguments& arguments) {
    const int wanted =
        int{!arguments.scene.empty()} + arguments.isListingDevices + arguments.isListingExtensions;
    if (wanted != 1) Reject("info needs either a scene file, --devices or --extensions");
    if (!arguments.scene.empty()) return;
    const char* lists = arguments.isListingDevices ? "--devices" : "--extensions";
    if (!arguments.sceneChoice.empty())
        Reject(Text("--scene is one of a scene file, and {} lists none", lists));
    if (!arguments.variant.empty())
        Reject(Text("--variant is one of a scene file, and {} lists none", lists));
    if (arguments.pointsAndLines != scene::PointsAndLines{})
        Reject(Text("--points and --lines are of a scene file, and {} lists none", lists));
    if (!arguments.root.empty()) Reject(Text("--root is of a scene file, and {} lists none", lists));
}

void CheckEdit(const EditArguments& arguments) {
    if (arguments.scene.empty() && !arguments.variant.empty())
        Reject("--variant is one of a scene: it needs a FILE");
    if (arguments.scene.empty() && arguments.given.contains("camera"))
        Reject("--camera looks at a scene: it needs a FILE");
    if (arguments.whitePoint && !arguments.whitePoint->kelvin)
        Reject("--white-point auto: render knows it; give a number of kelvin, such as 5000");
    CheckEnvironment(arguments.given, !arguments.environment.empty());
}

std::string OneLine(std::string text) {
    std::ranges::replace(text, '\n', ' ');
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return Printable(text, 1024);
}

// Describes the first word that the program does not know, with a suggestion; describes the error if every
// word is known.
std::string DescribeUsageError(CLI::App& app, const CLI::ParseError& error) {
    const ProgramText program = TextsOf(app);
    std::string chosen;  // "graph run"
    for (const CLI::App* at = &app; !at->get_subcommands().empty();) {
        at = at->get_subcommands().front();
        chosen += (chosen.empty() ? "" : " ") + at->get_name();
    }
    std::vector<std::string> known;
    std::string help = program.name;
    if (chosen.empty()) {
        for (const CommandText& command : program.commands) known.push_back(command.name);
    } else {
        help += " " + chosen;
    }
    const CommandText* command = nullptr;
    for (const CommandText& candidate : program.commands)
        if (candidate.name == chosen) command = &candidate;
    for (const OptionText& option : command ? command->options : program.options)
        known.insert(known.end(), option.names.begin(), option.names.end());
    help = " (see " + help + " --help)";

    for (const std::string& word : app.remaining(true)) {
        // After a command, the word may be the operand of an unknown option
        const bool isOption = word.starts_with('-') && word.size() > 1;
        if (command && !isOption) continue;
        const std::string name = word.substr(0, isOption ? word.find('=') : word.npos);
        const std::optional<std::string> meant = Suggestion(name, known);
        const std::string what = !isOption ? "there is no command " + Quoted(name)
                                 : command ? Text("{} has no option {}", command->name, Printable(name))
                                           : "there is no option " + Printable(name);
        return what + (meant ? "; did you mean " + *meant + "?" : "") + help;
    }
    return OneLine(error.what()) + help;
}

// Returns what ends the help of the program.
std::string Overview() {
    std::string text = "raygraph COMMAND --help shows the options of a command.\n\nExit status:\n";
    for (const ExitCodeText& each : kExitCodes)
        text += Text("  {:<24}  {}\n", static_cast<int>(each.code), each.text);
    text += "\nraygraph FILE.glb, or .gltf, is short for raygraph edit FILE.glb.\n";
    text += "\nEnvironment:\n";
    for (const auto& [variable, meaning] : kEnvironment) text += Text("  {:<24}  {}\n", variable, meaning);
    return text;
}

// Returns the help of the program, or of the command that was given. CLI11 leaves two empty lines between
// groups.
std::string HelpOf(const CLI::App& app) {
    std::string help = app.help();
    for (size_t at = 0; (at = help.find("\n\n\n", at)) != help.npos;) help.erase(at, 1);
    return help;
}

}  // namespace

PictureSettings BenchDefaults() {
    PictureSettings settings;
    settings.size = {640, 360};
    settings.paths.biases.maxDepth = 16;
    settings.light = DefaultLight::None;
    return settings;
}

namespace {

// `raygraph scene.glb` is `raygraph edit scene.glb`.
bool IsScene(std::string_view word) {
    const std::string extension = LowerExtension(word);
    return !word.starts_with('-') && (extension == ".glb" || extension == ".gltf");
}

}  // namespace

Arguments ParseArguments(int argc, const char* const* argv) {
    std::vector<const char*> words;
    for (int i = 0; i < argc; ++i) {
        if (i == 1 && IsScene(argv[i])) words.push_back("edit");
        words.push_back(argv[i]);
    }
    CLI::App app("Raygraph: path-traces glTF scenes on Vulkan devices.", "raygraph");
    app.require_subcommand(0, 1);  // a missing command is our own error: CLI11's would hide a misspelt one
    app.get_formatter()->column_width(kHelpIndent);
    app.get_formatter()->label("SUBCOMMAND", "COMMAND");
    app.get_formatter()->label("REQUIRED", "(required)");
    app.set_help_all_flag("--help-all", "Print all options, those for experiments included, and exit");
    app.set_version_flag("--version", std::string("raygraph ") + kVersion);

    RenderArguments renderArguments;
    BenchArguments benchArguments;
    InfoArguments infoArguments;
    GraphArguments graphArguments;
    GraphRunArguments graphRunArguments;
    ExplainArguments explainArguments;
    MergeArguments mergeArguments;
    DenoiseArguments denoiseArguments;
    CompareArguments compareArguments;
    VerifyArguments verifyArguments;
    EditArguments editArguments;
    const CLI::App* render = AddRender(app, renderArguments);
    const CLI::App* bench = AddBench(app, benchArguments);
    const CLI::App* info = AddInfo(app, infoArguments);
    const CLI::App* graph = AddGraph(app, graphArguments, graphRunArguments);
    const CLI::App* explain = AddExplain(app, explainArguments);
    const CLI::App* merge = AddMerge(app, mergeArguments);
    const CLI::App* denoise = AddDenoise(app, denoiseArguments);
    const CLI::App* compare = AddCompare(app, compareArguments);
    const CLI::App* verify = AddVerify(app, verifyArguments);
    const CLI::App* edit = AddEdit(app, editArguments);
    Shell shell{};
    const CLI::App* completion = AddCompletion(app, shell);
    // is shown for the program alone: commands take the footer that it has when they are added
    app.footer(Overview());

    const auto setGroups = [&app](bool showsStudy) {
        for (CLI::App* command : app.get_subcommands({})) SetGroups(*command, showsStudy);
    };
    setGroups(false);
    for (CLI::App* command : app.get_subcommands({})) {
        command->group("Commands");
        for (CLI::App* within : command->get_subcommands({})) within->group("Commands");
    }

    try {
        app.parse(static_cast<int>(words.size()), words.data());
    } catch (const CLI::CallForHelp&) {
        return ShowText{HelpOf(app)};
    } catch (const CLI::CallForAllHelp&) {
        setGroups(true);
        return ShowText{HelpOf(app)};
    } catch (const CLI::CallForVersion&) {
        return ShowText{app.version() + "\n"};
    } catch (const CLI::ParseError& error) {
        Reject(DescribeUsageError(app, error));
    }
    if (*completion) return ShowText{CompletionScript(TextsOf(app), shell)};
    if (*render) {
        ApplyBackdrop(renderArguments);
        CheckRender(renderArguments);
        ApplyCameras(renderArguments);
        ApplyShard(renderArguments);
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
    if (*graph && graph->got_subcommand("run")) return graphRunArguments;
    if (*graph) {
        if (graphArguments.scene.empty()) Reject("graph needs a scene, or run (see raygraph graph --help)");
        return graphArguments;
    }
    if (*explain) {
        CheckExplain(explainArguments);
        return explainArguments;
    }
    if (*denoise) {
        CheckDenoise(denoiseArguments);
        return denoiseArguments;
    }
    if (*compare) {
        return compareArguments;
    }
    if (*verify) {
        CheckVerify(verifyArguments, *verify);
        return verifyArguments;
    }
    if (*edit) {
        CheckEdit(editArguments);
        return editArguments;
    }
    if (!*merge)
        Reject(
            "a command is needed: render, edit, bench, info, graph, explain, merge, denoise, compare or "
            "verify (see raygraph --help)");
    CheckMerge(mergeArguments);
    return mergeArguments;
}

}  // namespace raygraph::cli

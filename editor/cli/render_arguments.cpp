#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/options.h"
#include "editor/session/parse.h"
#include "editor/session/session.h"

namespace raygraph::cli {

namespace {

// "albedo, normal": from one up to another, which is not in it; without another all the rest.
std::string ListOf(Aov first, std::optional<Aov> end) {
    std::string list;
    for (const Aov aov : kAovs)
        if (first <= aov && (!end || aov < *end)) list += std::string(list.empty() ? "" : ", ") + Name(aov);
    return list;
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

}  // namespace

passes::TonemapSettings DisplayOf(const RenderArguments& arguments) {
    passes::TonemapSettings display;
    if (arguments.exposureEv) display.exposureEv = *arguments.exposureEv;
    if (arguments.tonemap) display.tonemapOperator = *arguments.tonemap;
    return display;
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
    constexpr auto kOperators = Texts(TonemapOperator{});
    SetChoices(
        *AddOption(*render, "--tonemap", "OP",
                   "Tone curve of a .png: " + ListForHelp(display.tonemapOperator),
                   [&](const std::string& text) { arguments.tonemap = ParseChoice<TonemapOperator>(text); }),
        {kOperators.begin(), kOperators.end()});
    CLI::Option* aov =
        AddOption(*render, "--aov", "LIST",
                  "Further channels of an .exr: " + ListOf(kAovs.front(), Aov::Emission) +
                      "; the light by its path: " + ListOf(Aov::Emission, Aov::Diffuse) +
                      ", and by what scattered it first: " + ListOf(Aov::Diffuse, AovOf(kBiases.front())) +
                      "; what a bias took: " + ListOf(AovOf(kBiases.front()), std::nullopt) +
                      "; or all. Samples and variance are always there",
                  [&](const std::string& text) { arguments.aovs = ParseAovs(text); });
    std::vector<std::string_view> aovs{"all"};
    for (const Aov named : kAovs) aovs.push_back(Name(named));
    SetChoices(*aov, aovs, Operands::List);
    AddPath(*render, "--resume", "FILE.exr",
            "Go on with a render that was written before; its settings are kept", arguments.resume);
    AddDevice(*render, arguments.device);
    render->add_flag("--validate", arguments.isValidating,
                     Wrapped("Turn on the Vulkan validation layers and fail on any message"));
    AddPath(*render, "--report", "FILE.json", "Write what was rendered, how long it took and what it used",
            arguments.report);
    AddProgress(*render, arguments);
    AddOutput(*render, arguments);
    return render;
}

void CheckRender(const RenderArguments& arguments) {
    CheckProgress(arguments);
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

}  // namespace raygraph::cli

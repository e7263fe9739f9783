#include "editor/cli/options.h"

#include <algorithm>
#include <sstream>

#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/setting_table.h"

namespace raygraph::cli {

namespace {

constexpr size_t kHelpWidth = 72;
// Names of CLI11 validators
constexpr const char *kChoice = "choice", *kList = "list";

struct Group {
    const char* name;
    std::vector<std::string_view> options;
};

// Whatever is in no group is listed first, with --help.
const Group kGroups[] = {
    {"Output",
     {"output", "size", "crop", "view", "transparent", "exposure", "tonemap", "white-point", "exr-type",
      "aov", "light-group", "resume", "checkpoint", "settings-from", "report"}},
    {"Sampling", {"spp", "time", "error", "adaptive", "seed", "sample-offset", "shard"}},
    {"Camera", {"camera", "aperture", "focus", "shutter"}},
    {"Light", {"env", "env-rotation", "env-tint", "background", "light", "shadows"}},
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
        "Ray traversal: driver (the device's ray tracing), own (Raygraph's shaders, for triangles that do "
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
    CLI::Option* quiet = app.add_flag("--quiet", arguments.isQuiet, "No progress, no warnings, no summary");
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
            "Folder below which the scene may name files, too, such as ../textures/wood.png", root);
}

void AddEnvironment(CLI::App& app, std::filesystem::path& environment) {
    AddPath(app, "--env", "FILE", "Equirectangular environment map, .hdr or .exr", environment);
}

void Refuse(const std::string& message) {
    throw Error(ErrorKind::Usage, message);
}

void CheckProgress(const OutputArguments& arguments) {
    const bool isShown =
        arguments.progress == ProgressStyle::Plain || arguments.progress == ProgressStyle::Json;
    if (arguments.isQuiet && isShown)
        Refuse(Text("--quiet and --progress {} exclude each other", Name(arguments.progress)));
}

void CheckEnvironment(const SettingTexts& given, bool hasMap) {
    if (given.contains("background") && hasMap) Refuse("--background and --env exclude each other");
    const auto light = given.find(kLightSetting);
    if (light != given.end() && light->second == Name(DefaultLight::Studio))
        for (const auto& [option, isGiven] :
             {std::pair("--background", given.contains("background")), std::pair("--env", hasMap)})
            if (isGiven) Refuse(Text("{} and --light studio exclude each other", option));
    for (const char* option : {"env-rotation", "env-tint"})
        if (given.contains(option) && given.contains("background"))
            Refuse(Text("--{} is of a map or the studio, which --background replaces", option));
}

}  // namespace raygraph::cli

// Adds options, and those that several commands share. It is for the sources of the command line alone.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "editor/cli/arguments.h"

namespace raygraph::cli {

// The help wraps to fit a terminal; CLI11 indents its lines.
inline constexpr size_t kHelpIndent = 28;
std::string Wrapped(std::string_view text);

// Adds an option with one operand that may be given at most once. `take` may throw Error, to which the
// option's name is added.
CLI::Option* AddOption(CLI::App& app, const std::string& name, const char* operand, const std::string& help,
                       std::function<void(const std::string&)> take);
// Tells completion that an option takes one of several names, or a list of them with commas. The option
// parses them itself.
enum class Operands { One, List };
void SetChoices(CLI::Option& option, const std::vector<std::string_view>& names,
                Operands operands = Operands::One);
struct Choices {
    std::vector<std::string> names;  // accepted names; empty: any text
    bool isList = false;
};
Choices ChoicesOf(CLI::Option& option);
void AddOutputs(CLI::App& app, const std::string& help, std::vector<OutputFile>& outputs,
                std::span<const OutputKind> kinds = kOutputKinds);
void AddPath(CLI::App& app, const std::string& name, const char* operand, const char* help,
             std::filesystem::path& path);

CLI::Option* AddScene(CLI::App& app, std::filesystem::path& path);
void AddVariant(CLI::App& app, std::string& variant);
void AddPointsAndLines(CLI::App& app, scene::PointsAndLines& radii);
// Adds the picture settings of these names, or all if there are none. `defaults` are the command's.
void AddSettings(CLI::App& app, SettingTexts& given, const std::vector<std::string_view>& names = {},
                 const PictureSettings& defaults = {});
// Adds --view-from and --orbit, which give the setting `camera` from outside of the scene. Call it after
// --camera was added.
void AddOrbits(CLI::App& app, SettingTexts& given);
void AddRoot(CLI::App& app, std::filesystem::path& root);
void AddEnvironment(CLI::App& app, std::filesystem::path& environment);
void AddDevice(CLI::App& app, std::string& device);
void AddValidate(CLI::App& app, bool& isValidating);
// Adds --denoiser; `help` lists its values, those of `names`, which completion offers.
void AddDenoiser(CLI::App& app, const std::string& help, const std::vector<std::string_view>& names,
                 std::optional<FileDenoiser>& denoiser);
// Returns the name of --tonemap: what the operator Linear writes with eight bits is called raw, as nothing
// else can show it.
const char* TonemapName(TonemapOperator op);
// Adds --exposure, --tonemap and --white-point, for the help `of` a picture; `whitePoint` is the operand of
// the last one.
void AddDisplay(CLI::App& app, const char* of, const char* whitePoint, const std::string& whitePointHelp,
                DisplayArguments& arguments);
// Adds --traversal and --integrator-form.
void AddTracing(CLI::App& app, TracingChoice& tracing);
// Adds --verbose and --log; AddOutput also adds --quiet.
void AddLog(CLI::App& app, OutputArguments& arguments);
void AddOutput(CLI::App& app, OutputArguments& arguments);
// Adds --progress, for commands that show any.
void AddProgress(CLI::App& app, OutputArguments& arguments);

// Sorts the options of a command into the groups of its help. Those that exist for study, to compare methods
// or to measure, are in no group without `showsStudy`: the help leaves them out.
void SetGroups(CLI::App& command, bool showsStudy);

// Throws Error{Usage}.
[[noreturn]] void Reject(const std::string& message);
// Refuses --exposure and the like unless a .png is written.
void CheckDisplay(const DisplayArguments& arguments, const std::vector<OutputFile>& pictures);
void CheckProgress(const OutputArguments& arguments);
void CheckEnvironment(const SettingTexts& given, bool hasMap);

// Adds the command `render`, with the checks that concern several options.
CLI::App* AddRender(CLI::App& app, RenderArguments& arguments);
void CheckRender(const RenderArguments& arguments);
// Applies --backdrop map, and --ground: the environment is hidden where only the shadow of a ground is seen.
void ApplyBackdrop(RenderArguments& arguments);
// Applies --turntable and --contact-sheet: each of their pictures has a camera.
void ApplyCameras(RenderArguments& arguments);
// Applies --shard: samples, frames and names become the shard's.
void ApplyShard(RenderArguments& arguments);

}  // namespace raygraph::cli

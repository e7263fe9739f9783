// Options that several commands have, and how options are added: for the sources of the command line alone.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "editor/cli/arguments.h"

namespace raygraph::cli {

// Help in lines that fit a terminal; CLI11 indents them.
inline constexpr size_t kHelpIndent = 28;
std::string Wrapped(std::string_view text);

// An option with one operand, given at most once. `take` may throw Error: the option's name is put before it.
CLI::Option* AddOption(CLI::App& app, const std::string& name, const char* operand, const std::string& help,
                       std::function<void(const std::string&)> take);
// What an option takes, where that is a name out of some, or a list of them with commas between: for
// completion. Parsing them is the option's own.
enum class Operands { One, List };
void SetChoices(CLI::Option& option, const std::vector<std::string_view>& names,
                Operands operands = Operands::One);
struct Choices {
    std::vector<std::string> names;  // none: it takes something else
    bool isList = false;
};
Choices ChoicesOf(CLI::Option& option);
void AddPath(CLI::App& app, const std::string& name, const char* operand, const char* help,
             std::filesystem::path& path);

CLI::Option* AddScene(CLI::App& app, std::filesystem::path& path);
void AddVariant(CLI::App& app, std::string& variant);
void AddPointsAndLines(CLI::App& app, scene::PointsAndLines& radii);
// The picture settings of these names; all of the table for none. `defaults` are the command's.
void AddSettings(CLI::App& app, SettingTexts& given, const std::vector<std::string_view>& names = {},
                 const PictureSettings& defaults = {});
void AddRoot(CLI::App& app, std::filesystem::path& root);
void AddEnvironment(CLI::App& app, std::filesystem::path& environment);
void AddDevice(CLI::App& app, std::string& device);
// --traversal and --integrator-form.
void AddTracing(CLI::App& app, TracingChoice& tracing);
// --verbose and --log; AddOutput adds --quiet to them.
void AddLog(CLI::App& app, OutputArguments& arguments);
void AddOutput(CLI::App& app, OutputArguments& arguments);
// --progress, of commands that show any.
void AddProgress(CLI::App& app, OutputArguments& arguments);

// Error{Usage}.
[[noreturn]] void Refuse(const std::string& message);
void CheckProgress(const OutputArguments& arguments);
void CheckEnvironment(const SettingTexts& given, bool hasMap);

// The command `render`, and what cannot be said of its options one by one.
CLI::App* AddRender(CLI::App& app, RenderArguments& arguments);
void CheckRender(const RenderArguments& arguments);
// With --shard: makes samples, frames and names those of the shard.
void TakeShard(RenderArguments& arguments);

}  // namespace raygraph::cli

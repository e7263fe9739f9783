#include "editor/cli/man_page.h"

#include "base/text.h"
#include "editor/cli/exit_code.h"
#include "editor/cli/version.h"

namespace raygraph::cli {

namespace {

constexpr const char* kDescription =
    " Each command has its own options. Results are written to standard output, messages and progress to "
    "standard error.";

struct Entry {
    const char *name, *text;
};

constexpr Entry kEnvironment[] = {
    {"RAYGRAPH_DEVICE",
     "The device of commands that are given no --device, by index or by a part of its name."},
    {"RAYGRAPH_LOG",
     "Levels of messages, for all or by category: info, or warning,shaders=debug,cache=off. Levels are "
     "debug, "
     "info, warning, error and off."},
    {"XDG_CACHE_HOME",
     "Where the folder raygraph is, with compiled pipelines and which form of the integrator is the fastest; "
     "without it in ~/.cache."},
    {"XDG_CONFIG_HOME",
     "Where the folder raygraph with the settings of the editor is; without it in ~/.config."},
};

constexpr Entry kExamples[] = {
    {"raygraph render cornell.gltf -o cornell.png --size 512x512 --spp 256", "Renders a picture."},
    {"raygraph render cornell.gltf --resume cornell.exr --spp 1024", "Goes on with one that was stored."},
    {"raygraph render cornell.gltf --progress json",
     "Says how it gets on by an object a line on standard error, for scripts."},
    {"raygraph info --devices", "Shows which devices there are."},
    {"source <(raygraph completion bash)", "Teaches bash to complete commands and options."},
};

// Escapes text for roff: a dash becomes a minus sign, so that it can be copied and searched for.
std::string Escaped(std::string_view text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '\\')
            escaped += "\\e";
        else if (c == '-')
            escaped += "\\-";
        else if (c == '^' || c == '~')
            escaped += c == '^' ? "\\(ha" : "\\(ti";
        else
            escaped += c;
    }
    // A line that begins with one of these would be a roff request
    const bool isRequest = escaped.starts_with('.') || escaped.starts_with('\'');
    return (isRequest ? "\\&" : "") + escaped;
}

std::string Bold(std::string_view text) {
    return "\\fB" + Escaped(text) + "\\fR";
}

std::string Italic(std::string_view text) {
    return "\\fI" + Escaped(text) + "\\fR";
}

std::string Tagged(const std::string& tag, std::string_view text) {
    return ".TP\n" + tag + "\n" + Escaped(text) + "\n";
}

std::string TagOf(const OptionText& option) {
    std::string tag;
    for (const std::string& name : option.names) tag += (tag.empty() ? "" : ", ") + Bold(name);
    if (option.operand.empty()) return tag;
    return tag + (tag.empty() ? "" : " ") + Italic(option.operand);
}

std::string Sentence(std::string text) {
    if (!text.empty() && !text.ends_with('.')) text += '.';
    return text;
}

std::string Options(const std::vector<OptionText>& options) {
    std::string page;
    for (const OptionText& option : options) page += Tagged(TagOf(option), Sentence(option.help));
    return page;
}

std::string Synopsis(const ProgramText& program, const CommandText& command) {
    std::string operand;
    if (const OptionText* positional = command.Positional()) {
        operand = Italic(positional->operand);
        if (!positional->isRequired) operand = Text("[{}]", operand);
        if (positional->isRepeatable) operand += "...";
    }
    return Text("{} {} [{}]... {}\n", Bold(program.name), Bold(command.name), Italic("OPTION"), operand);
}

}  // namespace

std::string ManPage(const ProgramText& program) {
    std::string page = Text(".TH RAYGRAPH 1 \"\" \"raygraph {}\" \"User Commands\"\n", kVersion);
    page += ".nh\n.ad l\n.SH NAME\nraygraph \\- path\\-trace glTF scenes on Vulkan devices\n.SH SYNOPSIS\n";
    for (const CommandText& command : program.commands) page += Synopsis(program, command) + ".br\n";
    page += Bold(program.name) + " [" + Italic("OPTION") + "]\n";
    page += ".SH DESCRIPTION\n" + Escaped(program.help + kDescription) + "\n";
    page += ".SH OPTIONS\n" + Options(program.options);
    page += ".SH COMMANDS\n";
    for (const CommandText& command : program.commands)
        page += ".SS " + Synopsis(program, command) + Escaped(Sentence(command.help)) + "\n" +
                Options(command.options);
    page += ".SH ENVIRONMENT\n";
    for (const Entry& variable : kEnvironment) page += Tagged(Bold(variable.name), variable.text);
    page += ".SH \"EXIT STATUS\"\n";
    for (const ExitCodeText& status : kExitCodes)
        page += Tagged(Bold(std::to_string(static_cast<int>(status.code))), Sentence(status.text));
    page += ".SH EXAMPLES\n";
    for (const Entry& example : kExamples) page += Tagged(Bold(example.name), example.text);
    return page;
}

}  // namespace raygraph::cli

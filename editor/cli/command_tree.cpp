#include "editor/cli/command_tree.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <vector>

#include "editor/cli/options.h"

namespace raygraph::cli {

namespace {

constexpr size_t kMaxBrief = 76;

OptionText TextOf(CLI::Option& option) {
    OptionText text;
    for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
    const bool isPositional = text.names.empty();
    const bool isFlag = !isPositional && option.get_expected_max() == 0;
    if (!isFlag) text.operand = isPositional ? option.get_name(true) : option.get_type_name();
    text.help = option.get_description();
    std::ranges::replace(text.help, '\n', ' ');
    Choices choices = ChoicesOf(option);
    text.choices = std::move(choices.names);
    text.isList = choices.isList;
    // Repeatable options are -v, lists, and options whose texts are joined
    text.isRepeatable = std::ranges::find(text.names, "-v") != text.names.end() ||
                        option.get_items_expected_max() > 1 ||
                        option.get_multi_option_policy() == CLI::MultiOptionPolicy::Join;
    return text;
}

std::vector<OptionText> OptionsOf(CLI::App& app) {
    std::vector<OptionText> options;
    for (CLI::Option* option : app.get_options()) options.push_back(TextOf(*option));
    return options;
}

// Adds the commands of `app`, each before those within it.
void AddCommands(ProgramText& program, CLI::App& app, const std::string& before) {
    for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
        const std::string name = before + command->get_name();
        program.commands.push_back({name, command->get_description(), OptionsOf(*command)});
        AddCommands(program, *command, name + " ");
    }
}

}  // namespace

bool OptionText::TakesFile() const {
    return operand.starts_with("FILE") || operand.starts_with("OUT");
}

std::vector<std::string> OptionText::Extensions() const {
    std::vector<std::string> found;
    const auto add = [&](const std::string& text, size_t dot) {
        size_t end = dot + 1;
        while (end < text.size() && std::islower(static_cast<unsigned char>(text[end]))) ++end;
        if (end > dot + 1) found.push_back(text.substr(dot, end - dot));
    };
    if (!TakesFile()) return found;
    if (const size_t dot = operand.find('.'); dot != operand.npos) {
        add(operand, dot);
        return found;
    }
    for (size_t dot = help.find(" ."); dot != help.npos; dot = help.find(" .", dot + 1)) add(help, dot + 1);
    return found;
}

std::string OptionText::Brief() const {
    size_t end = std::min(help.find("; "), help.find(". "));
    if (!choices.empty() || TakesFile()) end = std::min(end, help.find(": "));
    std::string brief = help.substr(0, end);
    if (brief.size() <= kMaxBrief) return brief;
    return brief.substr(0, brief.rfind(' ', kMaxBrief - 3)) + "...";
}

const OptionText* CommandText::Positional() const {
    const auto found =
        std::ranges::find_if(options, [](const OptionText& option) { return option.names.empty(); });
    return found == options.end() ? nullptr : &*found;
}

ProgramText TextsOf(CLI::App& app) {
    ProgramText program{app.get_name(), app.get_description(), OptionsOf(app), {}};
    AddCommands(program, app, "");
    return program;
}

// --- Suggestions ---

namespace {

// No option has longer words, and comparing them would take long.
constexpr size_t kMaxLetters = 64;

std::string_view WithoutDashes(std::string_view word) {
    return word.substr(std::min(word.find_first_not_of('-'), word.size()));
}

}  // namespace

size_t EditDistance(std::string_view a, std::string_view b) {
    // Only the last three rows of the table of distances between prefixes of a and b are kept
    std::vector<size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        std::swap(before, last);
        std::swap(last, row);
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before[j - 2] + 1);
        }
    }
    return row[b.size()];
}

std::optional<std::string> Suggestion(std::string_view misspelt, std::span<const std::string> words) {
    misspelt = WithoutDashes(misspelt);
    if (misspelt.empty() || misspelt.size() > kMaxLetters) return std::nullopt;
    std::optional<std::string> nearest;
    size_t least = 0;
    for (const std::string& word : words) {
        const std::string_view letters = WithoutDashes(word);
        const size_t distance = EditDistance(misspelt, letters);
        if (distance > std::max<size_t>(1, letters.size() / 3) || distance >= letters.size()) continue;
        if (nearest && distance >= least) continue;
        nearest = word;
        least = distance;
    }
    return nearest;
}

}  // namespace raygraph::cli

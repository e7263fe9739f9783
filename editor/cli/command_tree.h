// ProgramText holds the commands and their options as plain texts, for suggestions and completion.
// Suggestion finds the word that a misspelt one was meant to be.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace raygraph::cli {

struct OptionText {
    std::vector<std::string> names;    // "-o", "--output"; empty: a positional operand
    std::string operand;               // "OUT"; "": a flag
    std::string help;                  // one paragraph
    std::vector<std::string> choices;  // accepted names; empty: any text
    bool isList = false;               // several choices, separated by commas
    bool isRepeatable = false;

    bool TakesFile() const;
    bool TakesFolder() const { return operand == "FOLDER"; }
    // Returns the extensions of its files, as operand and help name them: ".exr"; empty: any.
    std::vector<std::string> Extensions() const;
    // Returns the first clause of the help.
    std::string Brief() const;
};

struct CommandText {
    std::string name;  // "graph run": a command within another one
    std::string help;
    std::vector<OptionText> options;

    bool IsWithin() const { return name.find(' ') != std::string::npos; }
    // Returns the positional operand of the command; null: it has none.
    const OptionText* Positional() const;
};

struct ProgramText {
    std::string name;
    std::string help;
    std::vector<OptionText> options;
    std::vector<CommandText> commands;
};

ProgramText TextsOf(CLI::App& app);

// Returns how many letters must be inserted, removed, replaced or swapped with their neighbor to turn `a`
// into `b`.
size_t EditDistance(std::string_view a, std::string_view b);

// Returns the nearest word if at most a third of its letters differ. Leading dashes are ignored.
std::optional<std::string> Suggestion(std::string_view misspelt, std::span<const std::string> words);

}  // namespace raygraph::cli

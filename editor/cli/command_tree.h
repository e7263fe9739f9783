// The commands and their options as plain texts: what --help shows, for what else is made of it.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace raygraph::cli {

struct OptionText {
    std::vector<std::string> names;    // "-o", "--output"; none: a file or word that follows the command
    std::string operand;               // "OUT"; "": a flag
    std::string help;                  // one paragraph
    std::vector<std::string> choices;  // names that it takes; none: it takes something else
    bool isList = false;               // it takes several of these, with commas between
    bool isRepeatable = false;
    bool isRequired = false;

    bool TakesFile() const;
    bool TakesFolder() const { return operand == "FOLDER"; }
    // Of its files, as operand and help name them: ".exr"; none: any.
    std::vector<std::string> Extensions() const;
    // The first clause of the help.
    std::string Brief() const;
};

struct CommandText {
    std::string name;
    std::string help;
    std::vector<OptionText> options;

    // What follows the command without a name; null: nothing does.
    const OptionText* Positional() const;
};

struct ProgramText {
    std::string name;
    std::string help;
    std::vector<OptionText> options;
    std::vector<CommandText> commands;
};

ProgramText TextsOf(CLI::App& app);

}  // namespace raygraph::cli

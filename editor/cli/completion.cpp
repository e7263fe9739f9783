#include "editor/cli/completion.h"

#include <fmt/ranges.h>

#include "base/text.h"

namespace raygraph::cli {

namespace {

// Puts the text in single quotes as the shell reads them: fish knows \' within quotes, the others do not.
std::string Quote(std::string_view text, Shell shell) {
    std::string quoted = "'";
    for (const char c : text) {
        if (c == '\'')
            quoted += shell == Shell::Fish ? "\\'" : "'\\''";
        else if (c == '\\' && shell == Shell::Fish)
            quoted += "\\\\";
        else
            quoted += c;
    }
    return quoted + "'";
}

std::string Joined(const std::vector<std::string>& words, const char* between = " ") {
    return Text("{}", fmt::join(words, between));
}

std::vector<std::string> NamesOf(const std::vector<OptionText>& options) {
    std::vector<std::string> names;
    for (const OptionText& option : options)
        names.insert(names.end(), option.names.begin(), option.names.end());
    return names;
}

// Returns the last words of the commands whose name is `before` and one word: of the program's own for "", of
// those within graph for "graph ".
std::vector<std::string> NamesWithin(const ProgramText& program, const std::string& before) {
    std::vector<std::string> names;
    for (const CommandText& command : program.commands) {
        if (!command.name.starts_with(before)) continue;
        const std::string last = command.name.substr(before.size());
        if (last.find(' ') == std::string::npos) names.push_back(last);
    }
    return names;
}

// --- bash ---

constexpr const char* kBashBegin =
    R"(# Completion of raygraph for bash, as `raygraph completion bash` prints it.

# Files with these endings, or all for none, and folders.
_raygraph_files() {
    local word=$1 ending
    shift
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(
        compgen -d -- "$word"
        (($# > 0)) || compgen -f -- "$word"
        for ending; do compgen -f -X "!*$ending" -- "$word"; done
    )
}

_raygraph_words() {
    mapfile -t COMPREPLY < <(compgen -W "$2" -- "$1")
}

# Words with commas between them.
_raygraph_list() {
    local before=
    [[ $1 != *,* ]] || before=${1%,*},
    compopt -o nospace 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -P "$before" -W "$2" -- "${1##*,}")
}

_raygraph() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command= i
    # --option=word is three words to bash
    if [[ $word == = ]]; then
        word=
    elif [[ $before == = ]] && ((COMP_CWORD > 1)); then
        before=${COMP_WORDS[COMP_CWORD-2]}
    fi
    COMPREPLY=()
    # A command may be within another one: "graph run"
    for ((i = 1; i < COMP_CWORD; ++i)); do
        case "$command${command:+ }${COMP_WORDS[i]}" in
)";

// Returns the name as a pattern of a case.
std::string BashPattern(const CommandText& command) {
    return command.IsWithin() ? Text("\"{}\"", command.name) : command.name;
}

std::vector<std::string> BashPatterns(const std::vector<CommandText>& commands) {
    std::vector<std::string> patterns;
    for (const CommandText& command : commands) patterns.push_back(BashPattern(command));
    return patterns;
}

std::string BashWords(const OptionText& option) {
    if (!option.choices.empty())
        return Text("_raygraph_{} \"$word\" {}", option.isList ? "list" : "words",
                    Quote(Joined(option.choices), Shell::Bash));
    if (option.TakesFolder())
        return "compopt -o filenames 2>/dev/null; "
               "mapfile -t COMPREPLY < <(compgen -d -- \"$word\")";
    if (!option.TakesFile()) return ":";
    std::string words = "_raygraph_files \"$word\"";
    for (const std::string& ending : option.Extensions()) words += " " + ending;
    return words;
}

std::string BashScript(const ProgramText& program) {
    std::string script = kBashBegin;
    script += Text("            {}) command+=${{command:+ }}${{COMP_WORDS[i]}} ;;\n",
                   Joined(BashPatterns(program.commands), "|"));
    script += "        esac\n    done\n    case $command:$before in\n";
    for (const CommandText& command : program.commands)
        for (const OptionText& option : command.options) {
            if (option.names.empty() || option.operand.empty()) continue;
            std::string pattern;
            for (const std::string& name : option.names)
                pattern += Text("{}{}:{}", pattern.empty() ? "" : "|", BashPattern(command), name);
            script += Text("        {}) {}; return ;;\n", pattern, BashWords(option));
        }
    script += "    esac\n    case $command in\n";
    script +=
        Text("        '') _raygraph_words \"$word\" {} ;;\n",
             Quote(Joined(NamesWithin(program, "")) + " " + Joined(NamesOf(program.options)), Shell::Bash));
    for (const CommandText& command : program.commands) {
        script += Text("        {})\n            if [[ $word == -* ]]; then\n", BashPattern(command));
        script += Text("                _raygraph_words \"$word\" {}\n",
                       Quote(Joined(NamesOf(command.options)), Shell::Bash));
        if (const OptionText* positional = command.Positional())
            script += Text("            else\n                {}\n", BashWords(*positional));
        for (const std::string& within : NamesWithin(program, command.name + " "))
            script += Text("                [[ {0} != \"$word\"* ]] || COMPREPLY+=({0})\n", within);
        script += "            fi ;;\n";
    }
    return script + "    esac\n}\n\ncomplete -F _raygraph raygraph\n";
}

// --- zsh ---

// Escapes a text for zsh's brackets, and for the part after a colon.
std::string ZshEscaped(std::string_view text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
        escaped += c;
    }
    return escaped;
}

// Returns "*.exr" or "*.(png|exr)": zsh would take a single name in brackets for a qualifier.
std::string ZshPattern(const std::vector<std::string>& endings) {
    if (endings.size() == 1) return "*" + endings.front();
    std::vector<std::string> names;
    for (const std::string& ending : endings) names.push_back(ending.substr(1));
    return Text("*.({})", Joined(names, "|"));
}

// Returns the operand with its choices, e.g. ":SAMPLER:(sobol pcg tea)".
std::string ZshOperand(const OptionText& option) {
    if (option.operand.empty()) return "";
    std::string action = " ";
    if (option.isList)
        action = "_sequence compadd - " + Joined(option.choices);
    else if (!option.choices.empty())
        action = Text("({})", Joined(option.choices));
    else if (option.TakesFolder())
        action = "_files -/";
    else if (option.TakesFile() && option.Extensions().empty())
        action = "_files";
    else if (option.TakesFile())
        action = Text("_files -g \"{}\"", ZshPattern(option.Extensions()));
    return Text(":{}:{}", ZshEscaped(option.operand), action);
}

std::string ZshOptions(const std::vector<OptionText>& options, const char* indent) {
    std::string script;
    for (const OptionText& option : options) {
        if (option.names.empty()) {
            script +=
                Text(" \\\n{}{}", indent,
                     Quote(Text("{}{}", option.isRepeatable ? '*' : '1', ZshOperand(option)), Shell::Zsh));
            continue;
        }
        for (const std::string& name : option.names) {
            const std::string others = option.isRepeatable        ? "*"
                                       : option.names.size() == 1 ? ""
                                                                  : Text("({})", Joined(option.names));
            script +=
                Text(" \\\n{}{}", indent,
                     Quote(Text("{}{}[{}]{}", others, name, ZshEscaped(option.Brief()), ZshOperand(option)),
                           Shell::Zsh));
        }
    }
    return script + "\n";
}

std::string ZshScript(const ProgramText& program) {
    std::string script =
        "#compdef raygraph\n"
        "# Completion of raygraph for zsh, as `raygraph completion zsh` prints it.\n\n"
        "_raygraph() {\n"
        "    local curcontext=\"$curcontext\" state line\n"
        "    local -a commands=(\n";
    for (const CommandText& command : program.commands)
        if (!command.IsWithin())
            script += Text("        {}\n", Quote(command.name + ":" + ZshEscaped(command.help), Shell::Zsh));
    script += "    )\n    _arguments -C";
    std::string options = ZshOptions(program.options, "        ");
    options.pop_back();
    script += options +
              " \\\n        '1:command:->command' \\\n        '*::argument:->argument'\n"
              "    case $state in\n"
              "        command) _describe command commands ;;\n"
              "        argument)\n        local name=$line[1]\n";
    for (const CommandText& command : program.commands)
        if (command.IsWithin())
            script += Text(
                "        if [[ CURRENT -gt 2 && \"$words[1] $words[2]\" == \"{0}\" ]]; then\n"
                "            name=\"{0}\"; shift words; (( CURRENT-- ))\n"
                "        elif [[ CURRENT -eq 2 && $words[1] == {1} ]]; then\n"
                "            compadd {2}\n        fi\n",
                command.name, command.name.substr(0, command.name.rfind(' ')),
                command.name.substr(command.name.rfind(' ') + 1));
    script += "        case $name in\n";
    for (const CommandText& command : program.commands)
        script += Text("            {}) _arguments{}                ;;\n", BashPattern(command),
                       ZshOptions(command.options, "                "));
    // A file in fpath is the function itself, so it must call it; a sourced file only defines it
    return script +
           "        esac ;;\n    esac\n}\n\n"
           "if [[ $funcstack[1] == _raygraph ]]; then\n    _raygraph \"$@\"\nelse\n"
           "    compdef _raygraph raygraph\nfi\n";
}

// --- fish ---

std::string FishScript(const ProgramText& program) {
    std::string script =
        "# Completion of raygraph for fish, as `raygraph completion fish` prints it.\n\n"
        "# Words with commas between them.\n"
        "function __raygraph_list\n"
        "    set -l before (string match -r '.*,' -- (commandline -ct) | string replace -r '^.*=' '')\n"
        "    printf '%s\\n' $before$argv\n"
        "end\n\ncomplete -c raygraph -f\n";
    const auto add = [&](const std::string& condition, const OptionText& option) {
        std::string line = "complete -c raygraph -n " + Quote(condition, Shell::Fish);
        for (const std::string& name : option.names)
            line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
        const bool isNamed = !option.names.empty();
        if (option.isList)
            line += " -x -a " + Quote("(__raygraph_list " + Joined(option.choices) + ")", Shell::Fish);
        else if (!option.choices.empty())
            line += std::string(isNamed ? " -x" : "") + " -a " + Quote(Joined(option.choices), Shell::Fish);
        else if (option.TakesFolder())
            line += " -x -a '(__fish_complete_directories)'";
        else if (option.TakesFile())
            line += isNamed ? " -r -F" : " -F";
        else if (!option.operand.empty())
            line += " -x";
        if (isNamed) line += " -d " + Quote(option.Brief(), Shell::Fish);
        script += line + "\n";
    };
    for (const OptionText& option : program.options) add("__fish_use_subcommand", option);
    for (const CommandText& command : program.commands) {
        const size_t space = command.name.rfind(' ');
        const std::string last = command.name.substr(space + 1);
        const std::string seen = "__fish_seen_subcommand_from ";
        script +=
            Text("complete -c raygraph -n {} -a {} -d {}\n",
                 Quote(command.IsWithin() ? seen + command.name.substr(0, space) : "__fish_use_subcommand",
                       Shell::Fish),
                 last, Quote(command.help, Shell::Fish));
        std::string condition = seen + last;
        for (const std::string& within : NamesWithin(program, command.name + " "))
            condition += "; and not " + seen + within;
        for (const OptionText& option : command.options) add(condition, option);
    }
    return script;
}

}  // namespace

std::string CompletionScript(const ProgramText& program, Shell shell) {
    switch (shell) {
        case Shell::Bash:
            return BashScript(program);
        case Shell::Zsh:
            return ZshScript(program);
        case Shell::Fish:
            break;
    }
    return FishScript(program);
}

}  // namespace raygraph::cli

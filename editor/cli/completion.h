// Generates shell completion of the command line from the texts of --help.
#pragma once

#include <string>

#include "editor/cli/command_tree.h"
#include "shaders/shared/choice.h"

namespace raygraph::cli {

#define RAYGRAPH_SHELLS(X, Of) \
    X(Of, Bash, 0, "bash", "") \
    X(Of, Zsh, 1, "zsh", "")   \
    X(Of, Fish, 2, "fish", "")
RAYGRAPH_CHOICE(Shell, RAYGRAPH_SHELLS)

// Returns a script that the shell sources: it defines the completion of `raygraph`, and runs nothing else.
std::string CompletionScript(const ProgramText& program, Shell shell);

}  // namespace raygraph::cli

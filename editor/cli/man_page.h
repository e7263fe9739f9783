// Generates the manual page raygraph(1) from the texts of --help.
#pragma once

#include <string>

#include "editor/cli/command_tree.h"

namespace raygraph::cli {

// Returns roff with the macros of man(7).
std::string ManPage(const ProgramText& program);

}  // namespace raygraph::cli

// Prints lines for people: results to stdout, everything else to stderr.
#pragma once

#include <string>
#include <string_view>

#include "editor/cli/program_log.h"
#include "editor/cli/progress.h"

namespace raygraph::cli {

// Holds a command's means of output.
struct Console {
    // `levels` is RAYGRAPH_LOG, or null. Throws as ProgramLog does.
    Console(const OutputArguments& arguments, const char* levels)
        : progress(stderr, arguments.isQuiet, arguments.progress), log(arguments, levels, progress) {}

    Progress progress;
    ProgramLog log;
};

// Prints the line to stdout.
void PrintLine(std::string_view text);

// Throws Error{Io} unless everything printed has reached stdout. Each command ends with this.
void RequirePrinted();

}  // namespace raygraph::cli

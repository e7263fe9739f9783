// Lines for people: results on stdout, everything else on stderr.
#pragma once

#include <string_view>

#include "editor/cli/program_log.h"
#include "editor/cli/progress.h"

namespace raygraph::cli {

// What a command speaks through.
struct Console {
    // `levels`: RAYGRAPH_LOG, or null. Errors as ProgramLog.
    Console(const OutputArguments& arguments, const char* levels)
        : progress(stderr, arguments.isQuiet, arguments.progress), log(arguments, levels, progress) {}

    Progress progress;
    ProgramLog log;
};

// On stdout.
void PrintLine(std::string_view text);

// Throws Error{Io} unless all that was printed on stdout has got there. Each command ends with this.
void RequirePrinted();

}  // namespace raygraph::cli

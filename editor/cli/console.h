// Lines for people: results on stdout, everything else on stderr.
#pragma once

#include <string_view>
#include <vector>

#include "editor/cli/progress.h"

namespace raygraph::cli {

// "raygraph: warning: ..." on stderr, past a progress line.
void Warn(Progress& progress, std::string_view text);
void WarnAll(Progress& progress, const std::vector<std::string>& texts);
void PrintLine(std::string_view text);

}  // namespace raygraph::cli

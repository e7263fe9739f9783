#include "editor/cli/console.h"

#include <cstdio>

namespace raygraph::cli {

void Warn(Progress& progress, std::string_view text) {
    progress.Clear();
    std::fprintf(stderr, "raygraph: warning: %.*s\n", static_cast<int>(text.size()), text.data());
}

void WarnAll(Progress& progress, const std::vector<std::string>& texts) {
    for (const std::string& text : texts) Warn(progress, text);
}

void PrintLine(std::string_view text) {
    std::printf("%.*s\n", static_cast<int>(text.size()), text.data());
}

}  // namespace raygraph::cli

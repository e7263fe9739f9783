#include "editor/cli/console.h"

#include <cstdio>

namespace raygraph::cli {

void PrintLine(std::string_view text) {
    std::printf("%.*s\n", static_cast<int>(text.size()), text.data());
}

}  // namespace raygraph::cli

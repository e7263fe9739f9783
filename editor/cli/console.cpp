#include "editor/cli/console.h"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "base/text.h"

namespace raygraph::cli {

void PrintLine(std::string_view text) {
    std::printf("%.*s\n", static_cast<int>(text.size()), text.data());
}

void RequirePrinted() {
    errno = 0;
    const bool isFlushed = std::fflush(stdout) == 0;
    if (isFlushed && std::ferror(stdout) == 0) return;
    // If an earlier write failed, its reason is not known any more
    const std::string why = isFlushed || errno == 0 ? "" : ": " + std::generic_category().message(errno);
    throw Error(ErrorKind::Io, "stdout cannot be written" + why);
}

}  // namespace raygraph::cli

#include "editor/cli/console.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "base/text.h"

namespace raygraph::cli {

void PrintLine(std::string_view text) {
    std::printf("%.*s\n", static_cast<int>(text.size()), text.data());
}

std::string ForShell(const std::string& text) {
    constexpr std::string_view kPlain = "+,-./:=@_%";
    const bool isPlain = !text.empty() && std::ranges::all_of(text, [&](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               kPlain.find(c) != kPlain.npos;
    });
    if (isPlain) return text;
    std::string quoted = "'";
    for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
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

// Texts made of values with {fmt}, whose format strings are checked when they are compiled. For our own
// sources and programs: not installed, so that hosts need no {fmt} to compile with our headers. Threads: any.
#pragma once

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "base/printable.h"

namespace raygraph {

template <typename... Values>
std::string Text(fmt::format_string<Values...> format, Values&&... values) {
    return fmt::format(format, std::forward<Values>(values)...);
}

// Example: throw MakeError(ErrorKind::Usage, "buffer '{}': {} bytes", name, size);
template <typename... Values>
Error MakeError(ErrorKind kind, fmt::format_string<Values...> format, Values&&... values) {
    return Error(kind, fmt::format(format, std::forward<Values>(values)...));
}

// Sends a message; its text is made only if the log listens at that level. A text for which there is no
// memory is not sent.
template <typename... Values>
void WriteLog(const Log& log, LogLevel level, std::string_view category, fmt::format_string<Values...> format,
              Values&&... values) noexcept {
    if (!log.IsEnabled(level)) return;
    try {
        log.Send(level, category, fmt::format(format, std::forward<Values>(values)...));
    } catch (...) {
        // No message is worth a failure, least of all in a destructor
    }
}

// Returns "512 B", "1.5 KiB", "24 MiB", "3.2 GiB".
std::string BytesText(uint64_t bytes);
// Returns "4.2 ms", "850 ms", "12 s", "4 min 5 s", "2 h 3 min".
std::string DurationText(double seconds);

}  // namespace raygraph

// Lets Text, MakeError and WriteLog take paths. The text is Printable, so that no file name acts on a
// terminal or ends the line, and has at most 1024 bytes.
template <>
struct fmt::formatter<std::filesystem::path> {
    template <typename Parsed>
    constexpr auto parse(Parsed& parsed) {
        return parsed.begin();
    }
    template <typename Context>
    auto format(const std::filesystem::path& path, Context& context) const {
        const std::string text = raygraph::Printable(path.string(), 1024);
        return std::copy(text.begin(), text.end(), context.out());
    }
};

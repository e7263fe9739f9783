// Lets Text, MakeError and Say take paths: the text is Printable, so that no name of a file acts on a
// terminal or ends the line, and has at most 1024 bytes. Not installed, as base/text.h is not. Threads: any.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "base/printable.h"

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

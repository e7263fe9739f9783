#include "editor/cli/log_levels.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::cli {

namespace {

LogLevel ParseLevel(std::string_view text) {
    std::vector<std::string_view> names;
    for (int i = 0; i <= static_cast<int>(LogLevel::Off); ++i) {
        const auto level = static_cast<LogLevel>(i);
        if (text == Name(level)) return level;
        names.emplace_back(Name(level));
    }
    throw MakeError(ErrorKind::BadInput, "{} is no level: {}", Quoted(text), fmt::join(names, ", "));
}

void RequireCategory(std::string_view text) {
    std::vector<std::string_view> known(kLogCategories.begin(), kLogCategories.end());
    known.push_back(kProgramCategory);
    if (std::ranges::find(known, text) == known.end())
        throw MakeError(ErrorKind::BadInput, "{} is no category: {}", Quoted(text), fmt::join(known, ", "));
}

}  // namespace

LogLevel LogLevels::Of(std::string_view category) const {
    const auto known = byCategory.find(category);
    return known == byCategory.end() ? general : known->second;
}

LogLevel LogLevels::Lowest() const {
    LogLevel lowest = general;
    for (const auto& [category, level] : byCategory) lowest = std::min(lowest, level);
    return lowest;
}

LogLevels LogLevels::AtLeast(LogLevel level) const {
    LogLevels levels = *this;
    levels.general = std::min(general, level);
    return levels;
}

LogLevels ParseLogLevels(std::string_view text) {
    LogLevels levels;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find(',', begin), text.size());
        const std::string_view entry = text.substr(begin, end - begin);
        begin = end + 1;
        const size_t equals = entry.find('=');
        if (equals == std::string_view::npos) {
            levels.general = ParseLevel(entry);
            continue;
        }
        const std::string_view category = entry.substr(0, equals);
        RequireCategory(category);
        levels.byCategory[std::string(category)] = ParseLevel(entry.substr(equals + 1));
    }
    return levels;
}

}  // namespace raygraph::cli

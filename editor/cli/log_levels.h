// LogLevels sets the minimal level of messages, overall and by category: RAYGRAPH_LOG and -v.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "base/log.h"

namespace raygraph::cli {

// Category of the program's own messages, beside kLogCategories.
inline constexpr std::string_view kProgramCategory = "program";

struct LogLevels {
    LogLevel general = LogLevel::Warning;
    std::map<std::string, LogLevel, std::less<>> byCategory;  // exceptions from the overall level

    LogLevel Of(std::string_view category) const;
    // Returns the lowest level of any category.
    LogLevel Lowest() const;
    // Returns these levels with every category that was not named lowered to `level`, if it is higher.
    LogLevels AtLeast(LogLevel level) const;
};

// Parses "info", "shaders=debug", "warning,cache=off,shaders=debug". Throws Error{BadInput}.
LogLevels ParseLogLevels(std::string_view text);

}  // namespace raygraph::cli

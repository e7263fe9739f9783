// From which level on messages are of interest, in general and by category: RAYGRAPH_LOG and -v.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "base/log.h"

namespace raygraph::cli {

// Category of what the program itself says, beside kLogCategories.
inline constexpr std::string_view kProgramCategory = "program";

struct LogLevels {
    LogLevel general = LogLevel::Warning;
    std::map<std::string, LogLevel, std::less<>> byCategory;  // those that differ

    LogLevel Of(std::string_view category) const;
    // The lowest of all.
    LogLevel Lowest() const;
    // With all categories that were not named at `level` at least.
    LogLevels AtLeast(LogLevel level) const;
};

// "info", "shaders=debug", "warning,cache=off,shaders=debug". Error{BadInput} saying what is wrong.
LogLevels ParseLogLevels(std::string_view text);

}  // namespace raygraph::cli

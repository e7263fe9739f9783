// Suggests the correct word for a misspelt one.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace raygraph::cli {

// Returns how many letters must be inserted, removed, replaced or swapped with their neighbor to turn `a`
// into `b`.
size_t EditDistance(std::string_view a, std::string_view b);

// Returns the nearest word if at most a third of its letters differ. Leading dashes are ignored.
std::optional<std::string> Suggestion(std::string_view misspelt, std::span<const std::string> words);

}  // namespace raygraph::cli

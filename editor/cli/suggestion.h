// What somebody may have meant who misspelt a word.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace raygraph::cli {

// How many letters must be put in, left out, replaced or swapped with their neighbor to make `b` of `a`.
size_t EditDistance(std::string_view a, std::string_view b);

// The nearest of these, if it is near: at most a third of its letters are wrong. Dashes before a word do not
// count.
std::optional<std::string> Suggestion(std::string_view misspelt, std::span<const std::string> words);

}  // namespace raygraph::cli

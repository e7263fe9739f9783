#include "editor/cli/suggestion.h"

#include <algorithm>
#include <vector>

namespace raygraph::cli {

namespace {

// No option has longer words, and comparing them would take long.
constexpr size_t kMaxLetters = 64;

std::string_view WithoutDashes(std::string_view word) {
    return word.substr(std::min(word.find_first_not_of('-'), word.size()));
}

}  // namespace

size_t EditDistance(std::string_view a, std::string_view b) {
    // Rows of the table of distances between prefixes of a and b; only the last three are kept
    std::vector<size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        std::swap(before, last);
        std::swap(last, row);
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before[j - 2] + 1);
        }
    }
    return row[b.size()];
}

std::optional<std::string> Suggestion(std::string_view misspelt, std::span<const std::string> words) {
    misspelt = WithoutDashes(misspelt);
    if (misspelt.empty() || misspelt.size() > kMaxLetters) return std::nullopt;
    std::optional<std::string> nearest;
    size_t least = 0;
    for (const std::string& word : words) {
        const std::string_view letters = WithoutDashes(word);
        const size_t distance = EditDistance(misspelt, letters);
        if (distance > std::max<size_t>(1, letters.size() / 3) || distance >= letters.size()) continue;
        if (nearest && distance >= least) continue;
        nearest = word;
        least = distance;
    }
    return nearest;
}

}  // namespace raygraph::cli

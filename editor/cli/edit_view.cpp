#include "editor/cli/edit_view.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "editor/session/settings/parse.h"

namespace raygraph::cli {

namespace {

// Makes "side by side" and "FLIP" words of a command line.
std::string WordOf(std::string_view name) {
    std::string word(name);
    std::ranges::transform(word, word.begin(), [](unsigned char c) {
        return c == ' ' ? '-' : static_cast<char>(std::tolower(c));
    });
    return word;
}

std::vector<std::pair<std::string, EditView>> Views() {
    std::vector<std::pair<std::string, EditView>> views;
    for (const viewport::View view : Values<viewport::View>())
        if (view != viewport::View::Surface) views.emplace_back(WordOf(Name(view)), EditView{.view = view});
    for (const viewport::View view : Values<viewport::View>())
        if (viewport::IsComparison(view))
            views.emplace_back("real-time-" + WordOf(Name(view)),
                               EditView{.view = view, .compared = viewport::Compared::RealTime});
    for (const passes::View view : Values<passes::View>())
        if (!passes::ShowsLight(view))
            views.emplace_back(Name(view), EditView{.view = viewport::View::Surface, .surface = view});
    return views;
}

}  // namespace

std::vector<std::string> EditViewNames() {
    std::vector<std::string> names;
    for (const auto& [name, view] : Views()) names.push_back(name);
    return names;
}

EditView ParseEditView(std::string_view text) {
    const std::vector<std::string> names = EditViewNames();
    return Views()[session::ParseChoice(text, {names.begin(), names.end()})].second;
}

}  // namespace raygraph::cli

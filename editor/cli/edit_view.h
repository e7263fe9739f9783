// The views of the editor, as `edit --view` names them: those of `render`, and those that compare two of
// them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "editor/viewport/view_settings.h"

namespace raygraph::cli {

struct EditView {
    viewport::View view = viewport::View::PathTraced;
    std::optional<passes::View> surface;  // of viewport::View::Surface

    bool operator==(const EditView&) const = default;
};

// "path-traced", "side-by-side", "normals", ...
std::vector<std::string> EditViewNames();
// Error{Usage} that lists them.
EditView ParseEditView(std::string_view text);

}  // namespace raygraph::cli

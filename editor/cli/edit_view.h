// Names the views of the editor for `edit --view`: those of `render`, and those that compare two of them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "editor/viewport/view_settings.h"

namespace raygraph::cli {

struct EditView {
    viewport::View view = viewport::View::PathTraced;
    std::optional<passes::View> surface;  // for viewport::View::Surface
    viewport::Compared compared = viewport::Compared::Raster;

    bool operator==(const EditView&) const = default;
};

// Returns "path-traced", "side-by-side", "real-time-side-by-side", "normals", ...
std::vector<std::string> EditViewNames();
// Throws Error{Usage} that lists the names.
EditView ParseEditView(std::string_view text);

}  // namespace raygraph::cli

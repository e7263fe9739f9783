// Two renders of different samples of one picture, as one render.
#pragma once

#include "editor/cli/render_file.h"

namespace raygraph::cli {

// A render and the name by which errors call it.
struct NamedRender {
    std::string name;
    RenderFile render;
};

// The render that has the samples of all `parts`: means weighted by sample counts, variances pooled (Chan,
// Golub and LeVeque 1979, "Updating Formulae and a Pairwise Algorithm for Computing Sample Variances"), in
// double. Depth, ids, device and driver are those of the first part.
// Error{BadInput} naming two parts when their samples overlap, their settings, scene or environment differ,
// or one has channels that the other lacks. At least one part.
RenderFile Merge(std::vector<NamedRender> parts);

}  // namespace raygraph::cli

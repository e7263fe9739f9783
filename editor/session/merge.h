// Two renders of different samples of one picture, as one render. Threads: pure functions.
#pragma once

#include "editor/session/render_file.h"

namespace raygraph::session {

// A render and the name by which errors call it.
struct NamedRender {
    std::string name;
    RenderFile render;
};

// The render that has the samples of all `parts`, with the bits of one run that took all of them, in whatever
// order the parts are given. Depth, ids, device and driver are those of the part with the first samples.
// Error{BadInput} naming two parts when their samples overlap, their settings, scene or environment differ,
// or one has channels that the other lacks; naming one that lacks sums to add, or has planes of
// another size than its picture. Error{Usage} without parts.
RAYGRAPH_API RenderFile Merge(std::vector<NamedRender> parts);

}  // namespace raygraph::session

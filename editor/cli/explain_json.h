// An explained pixel as JSON, for scripts.
#pragma once

#include <string>

#include "editor/session/explain/explain.h"

namespace raygraph::cli {

// Returns one object, in lines. The values of a vertex are those of shaders/shared/path_vertex_list.h, by
// these names; positions are in world space.
std::string ExplanationJson(const session::Explanation& explanation);

}  // namespace raygraph::cli

// Explained paths as text, for a terminal and for a panel. Threads: pure functions, for any thread.
#pragma once

#include <string>
#include <vector>

#include "base/api.h"
#include "editor/session/explain/explain.h"

namespace raygraph::session {

// Returns the cause of a sample's value in a line: the largest contribution, with the lamp that it is of, how
// the lamp was found and with which probability; or why a black sample is black.
RAYGRAPH_API std::string CauseOf(const ExplainedPath& path, const PathNames& names);

// Holds a vertex in a row of a table.
struct VertexRow {
    std::string place;  // what the ray meets: "frosted" of "pane"
    std::string next;   // the lobe with its probability, or why the path ends
    std::string light;  // contributions to the sample with their lights; "": none
};
RAYGRAPH_API VertexRow RowOf(const gpu::PathVertexRecord& vertex, const PathNames& names);

// Returns the lines of one vertex, the first of which names it; `origin` is Explanation::origin.
RAYGRAPH_API std::vector<std::string> LinesOf(const ExplainedPath& path, size_t vertex,
                                              const PathNames& names, const glm::dvec3& origin);

// Returns everything, in lines: the pixel, its brightest samples with their causes, and their vertices.
RAYGRAPH_API std::string Describe(const Explanation& explanation);

}  // namespace raygraph::session

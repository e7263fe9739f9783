// Culling: finds the passes of a frame that lead to something that is needed (renderer/graph/compile.h).
// Threads: pure functions of their arguments.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/graph/frame_graph.h"

namespace raygraph {

// Returns, for each pass, 1 if it is kept.
std::vector<uint8_t> LivePasses(const FrameGraph& graph);

}  // namespace raygraph

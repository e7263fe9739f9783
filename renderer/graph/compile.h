// Compile: makes the execution plan of a declared frame. Needs no device and makes no vk* call; the same
// graph gives the same plan. Threads: a pure function.
//
//   order       as declared: a pass can only use the results of earlier passes
//   culling     a pass is kept if it is keepAlive, or if a root or a kept pass needs what it writes. The
//               contents of a persistent resource at the end of the frame are needed if it is Always, or if
//               a kept pass uses its contents from the beginning of the frame. Each level of each layer of a
//               texture is decided separately.
//   lifetimes   from first to last use among the kept passes
//   aliasing    transients with disjoint lifetimes and a common memory type share a block, largest first
//   barriers    one batch before each pass (renderer/graph/barrier_planner.h), each for the levels and layers
//               that need the same. An import is left in one layout.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"

namespace raygraph {

// Throws Error{Usage} for a root that a later pass has overwritten.
Plan Compile(const FrameGraph& graph);

// Returns, for each pass, 1 if it is kept: if it leads to something that is needed.
std::vector<uint8_t> LivePasses(const FrameGraph& graph);

}  // namespace raygraph

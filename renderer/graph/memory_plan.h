// The planner that decides which transients share memory. Threads: a pure function.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"

namespace raygraph {

// The memory in which PlanMemory works.
struct BlockMemory {
    std::vector<uint32_t> order;  // the transients, largest first
    // One bit for each position of the frame, block after block: an occupant lives there.
    std::vector<uint64_t> isOccupied;
};

// Gives every used transient with memory requirements a block (Lifetime::block, Plan::blocks) by first fit,
// largest first. Transients share a block if their lifetimes are disjoint and they have a memory type in
// common. Every occupant lies at the start of its block.
void PlanMemory(const FrameGraph& graph, Plan& plan, BlockMemory& memory);

}  // namespace raygraph

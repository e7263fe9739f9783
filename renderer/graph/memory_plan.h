// The planner that decides which transients share memory. Threads: a pure function.
#pragma once

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"

namespace raygraph {

// Gives every used transient with memory requirements a block (Lifetime::block, Plan::blocks) by first fit,
// largest first. Transients share a block if their lifetimes are disjoint and they have a memory type in
// common. Every occupant lies at the start of its block.
void PlanMemory(const FrameGraph& graph, Plan& plan);

}  // namespace raygraph

// Memory planner: which transients share memory. Pure.
#pragma once

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"

namespace raygraph {

// Gives every used transient with memory requirements a block (Lifetime::block, Plan::blocks): first fit,
// largest first, where lifetimes are disjoint and a memory type is common. Every occupant lies at the start
// of its block.
void PlanMemory(const FrameGraph& graph, Plan& plan);

}  // namespace raygraph

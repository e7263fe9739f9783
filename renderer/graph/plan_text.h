// The plan of a frame as text: for people, and for tests that compare it. Pure; the same plan gives the same
// text.
#pragma once

#include <string>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"

namespace raygraph {

// One block a pass: number, name, kind, what it reads and writes with versions, what it waits for; then the
// culled passes with the reason, the resources with their lifetimes, and the shared memory with the bytes
// saved.
std::string DescribePlan(const FrameGraph& graph, const Plan& plan);

// Graphviz: passes as boxes (culled ones dashed), versions of resources as ellipses. `dot -Tsvg` draws it.
std::string DescribePlanDot(const FrameGraph& graph, const Plan& plan);

}  // namespace raygraph

// The plan of a frame as text, for people and for tests that compare it. The same plan gives the same text.
// Threads: pure functions, for any thread.
#pragma once

#include <string>

#include "base/api.h"
#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"

namespace raygraph {

// Returns one block for each pass: number, name, kind, reads and writes with versions, and waits. They are
// followed by the culled passes with the reason, the resources with their lifetimes, and the shared memory
// with the bytes saved.
RAYGRAPH_API std::string DescribePlan(const FrameGraph& graph, const Plan& plan);

// Returns Graphviz text: passes as boxes (culled ones dashed), versions of resources as ellipses. `dot -Tsvg`
// draws it.
RAYGRAPH_API std::string DescribePlanDot(const FrameGraph& graph, const Plan& plan);

// Returns the content of DescribePlan as JSON, for scripts: the passes in order of execution, each with its
// reads and writes and the barriers before it; culled passes with the reason; resources; shared memory.
// Resources are referred to by index, and passes in lifetimes by position, where one past the last is the end
// of the frame.
RAYGRAPH_API std::string DescribePlanJson(const FrameGraph& graph, const Plan& plan);

// The following functions return parts of the plan in one line each, for tools that draw it. This one returns
// text such as "radiance: RayTracingShader write -> ComputeShader read, General".
RAYGRAPH_API std::string BarrierText(const FrameGraph& graph, const PlannedBarrier& barrier);
// Returns text such as "radiance v1 (storage write)", "chain v3 level 2 (storage read)".
RAYGRAPH_API std::string UseText(const FrameGraph& graph, const ResourceUse& use);
// Returns text such as "texture 640x360 rgba32f", "texture 64x64 r32f, 7 levels, 6 layers".
RAYGRAPH_API std::string ResourceText(const GraphResource& resource);
// Returns why a pass of plan.culled is culled: "nothing needs radiance".
RAYGRAPH_API std::string CullReason(const FrameGraph& graph, const Plan& plan, uint32_t culled);

}  // namespace raygraph

// Divides the executed passes of a frame into batches, one for each submission: passes that may run beside
// others go to the compute queue, and a batch waits for another where its passes depend on one of the other
// queue. Pure; threads: any.
//
// A batch is complete before what waits for it begins, so that no barrier is needed between the two beyond
// transitions and transfers of ownership. The first batch has no passes: what precedes the frame on the main
// queue, and its first barriers, precede both queues. The last batch is one of the main queue, which waits
// for all others: who waits for the frame waits for that queue alone.
#pragma once

#include "base/api.h"
#include "renderer/graph/plan.h"

namespace raygraph {

// Returns whether passes of this kind can run on a compute queue.
RAYGRAPH_API bool CanRunOnComputeQueue(PassKind kind);

// Fills in plan.batches from plan.passes, which are reordered so that the passes of a batch are adjacent. The
// order on each queue stays that of declaration. Without a pass for the compute queue, or without that queue
// (FrameGraph::computeFamily), all passes are one batch.
RAYGRAPH_API void PlanQueues(const FrameGraph& graph, Plan& plan);

}  // namespace raygraph

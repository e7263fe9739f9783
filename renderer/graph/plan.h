// Plan: the result of compiling a FrameGraph, as plain data that refers to the graph by index. Threads: plain
// values, for any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/graph/access.h"
#include "renderer/graph/barrier_planner.h"
#include "renderer/graph/frame_graph.h"
#include "rhi/resources.h"

namespace raygraph {

inline constexpr uint32_t kNone = ~0u;

struct PlannedBarrier {
    uint32_t resource = 0;
    Subresources part{.levelCount = 1, .layerCount = 1};  // a part of a texture
    Dependency dependency{};
    // The first use of a transient waits for the last occupant of its memory: a resource of this frame or,
    // with followsLastFrame, the contents that the frame before left there.
    uint32_t predecessor = kNone;
    bool followsLastFrame = false;
    // Both IGNORED: no transfer of ownership.
    uint32_t srcQueueFamily = VK_QUEUE_FAMILY_IGNORED;
    uint32_t dstQueueFamily = VK_QUEUE_FAMILY_IGNORED;
};

// Holds barriers that are recorded together: [first, first + count) of Plan::barriers.
struct BarrierRange {
    uint32_t first = 0;
    uint32_t count = 0;
};

struct PlannedPass {
    uint32_t pass = 0;  // index into FrameGraph::passes
    BarrierRange barriers{};
};

// Holds the passes of one submission (renderer/graph/queue_plan.h): [firstPass, firstPass + passCount) of
// Plan::passes.
struct PlannedBatch {
    rhi::QueueKind queue = rhi::QueueKind::Main;
    uint32_t firstPass = 0;
    uint32_t passCount = 0;
    uint32_t waitsFor =
        kNone;               // an earlier batch, of the other queue, that it waits for with all before that
    BarrierRange release{};  // after its passes: ownership to the other queue's family

    bool operator==(const PlannedBatch&) const = default;
};

// Holds the lifetime of one resource, in positions among the executed passes.
struct Lifetime {
    uint32_t first = kNone;  // kNone: no executed pass uses it
    uint32_t last = 0;
    uint32_t block = kNone;  // a block of transient memory
    // A pass of the compute queue uses it, beside passes at other positions: it shares no memory.
    bool isConcurrent = false;

    bool IsUsed() const { return first != kNone; }
};

struct Plan {
    std::vector<PlannedPass> passes;  // in order of execution
    std::vector<uint32_t> culled;     // indices into FrameGraph::passes
    std::vector<PlannedBatch>
        batches;  // in order of submission; at least one, and the last on the main queue
    std::vector<PlannedBarrier> barriers;
    BarrierRange acquire;             // before the first pass: ownership from other owners' queue families
    BarrierRange regain;              // after the last pass: ownership from the compute queue's family
    BarrierRange finish;              // after the last pass: for the readers of the roots
    BarrierRange release;             // after `finish`: ownership to other owners' queue families
    std::vector<Lifetime> lifetimes;  // indexed by resource
    std::vector<rhi::MemoryRequirements> blocks;  // of transient memory
    uint64_t bytesWithoutAliasing = 0;            // bytes of all transients that have a block
    std::vector<ResourceState> states;  // by number (FrameGraph::ForEachSubresource), after the frame
    // By block, after the frame: one state for all its occupants together, since an earlier one may extend
    // beyond the last.
    std::vector<ResourceState> blockStates;

    // Empties the plan; the vectors keep their memory.
    void Clear() {
        passes.clear();
        culled.clear();
        batches.clear();
        barriers.clear();
        acquire = regain = finish = release = {};
        lifetimes.clear();
        blocks.clear();
        bytesWithoutAliasing = 0;
        states.clear();
        blockStates.clear();
    }
};

}  // namespace raygraph

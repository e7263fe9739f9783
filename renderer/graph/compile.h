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

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/memory_plan.h"
#include "renderer/graph/plan.h"

namespace raygraph {

// The memory in which passes are culled. By subresource, isNeeded tells whether its contents are needed after
// the current pass, and needsHistory whether those from before the frame are needed.
struct CullMemory {
    std::vector<uint8_t> isKept;  // indexed by pass
    std::vector<uint8_t> isNeeded;
    std::vector<uint8_t> needsHistory;
};

// The memory in which Compile works. Kept from frame to frame, it makes Compile allocate nothing for a frame
// that needs no more than an earlier one.
struct CompileMemory {
    struct BlockUse {
        uint32_t occupant = kNone;  // the last resource that used the block
        // The occupant before `occupant`, or followsLastFrame for the contents that the last frame left in
        // the block.
        uint32_t predecessor = kNone;
        bool followsLastFrame = false;
        // The stages and writes of all occupants so far. An earlier occupant may extend beyond the last one.
        AccessMasks access;
    };
    // The memory of a frame with passes on both queues.
    // By subresource: its state for the compute queue, and what the queues did to it.
    struct QueueUse {
        rhi::QueueKind changedOn = rhi::QueueKind::Main;  // by the last write, transition or transfer
        bool isSynchronized = false;              // the state for the other queue tells of that change, too
        std::array<uint32_t, 2> lastBatch{0, 0};  // by queue: the batch of its last use
    };
    struct Release {
        uint32_t batch = 0;
        PlannedBarrier barrier;
    };
    std::vector<ResourceState> computeStates;
    std::vector<QueueUse> queueUses;
    std::vector<Release> releases;
    std::vector<BlockUse> blockUses;  // indexed by block
    std::vector<ResourceState> states;
    CullMemory culling;
    BlockMemory blocks;
};

// Makes `plan` that of the graph. Throws Error{Usage} for a root that a later pass has overwritten.
void Compile(const FrameGraph& graph, Plan& plan, CompileMemory& memory);
Plan Compile(const FrameGraph& graph);

}  // namespace raygraph

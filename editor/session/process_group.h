// ProcessGroup connects processes that render one picture together, each on devices of its own. The component
// raygraph-mpi (editor/mpi) implements it with MPI ranks. Threads: see ProcessGroup.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "base/api.h"
#include "editor/session/group/block_queue.h"
#include "passes/accumulate.h"

namespace raygraph::session {

// All processes make the same calls in the same order, and each call returns when its process's part is done.
// A waiting process sleeps. Throws Error{Io} for failures between the processes. Threads: the one that uses
// the Session.
class RAYGRAPH_API ProcessGroup {
  public:
    virtual ~ProcessGroup() = default;

    virtual uint32_t Rank() const = 0;  // index of this process; the root is 0
    virtual uint32_t Size() const = 0;  // number of processes
    // Return rank and size among the processes on this computer.
    virtual uint32_t LocalRank() const = 0;
    virtual uint32_t LocalSize() const = 0;
    bool IsRoot() const { return Rank() == 0; }

    // Replaces the bytes by those of the root; all processes pass equally many.
    virtual void Broadcast(std::span<std::byte> bytes) = 0;
    // Return the sum or the minimum over all processes to each of them.
    virtual uint64_t Sum(uint64_t value) = 0;
    virtual uint64_t Minimum(uint64_t value) = 0;
    // Adds the sums of all processes, with the same layout, to those of the root; elsewhere they become
    // undefined.
    virtual void AddAtRoot(passes::ExactSums& sums) = 0;

    // Runs one round of blocks: `dealer`, which only the root has, deals to the devices of all processes;
    // this process's devices ask `queue`. Returns when no blocks are left and this process's devices know it.
    // `tick` is called repeatedly, on the root with whether another process wants the round to end early; it
    // returns whether this process does. The root then stops the dealer. Throws the error of a failed device.
    using Tick = std::function<bool(bool isStopRequested)>;
    virtual void Deal(BlockDealer* dealer, BlockQueue& queue, const Tick& tick) = 0;
};

}  // namespace raygraph::session

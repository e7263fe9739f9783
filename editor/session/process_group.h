// Processes that render one picture together, each on devices of its own: what a Session needs of them. The
// component raygraph-mpi (editor/mpi) has the one that is made of MPI ranks. Threads: see ProcessGroup.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "base/api.h"
#include "editor/session/block_dealer.h"
#include "editor/session/block_queue.h"
#include "passes/exact_sums.h"

namespace raygraph::session {

// All processes make the same calls in the same order, and each call returns when its process's part is done.
// A process that waits sleeps. Errors: Error{Io} for what fails between the processes. Threads: that which
// uses the Session.
class RAYGRAPH_API ProcessGroup {
  public:
    virtual ~ProcessGroup() = default;

    virtual uint32_t Rank() const = 0;  // the number of this process; the root is 0
    virtual uint32_t Size() const = 0;  // processes
    // Of those on this computer.
    virtual uint32_t LocalRank() const = 0;
    virtual uint32_t LocalSize() const = 0;
    bool IsRoot() const { return Rank() == 0; }

    // Replaces the bytes, as many everywhere, by those of the root.
    virtual void Broadcast(std::span<std::byte> bytes) = 0;
    // The sum over all processes, or the least value, for each of them.
    virtual uint64_t Sum(uint64_t value) = 0;
    virtual uint64_t Least(uint64_t value) = 0;
    // Adds the sums of all processes, of one layout, to those of the root; elsewhere they are left undefined.
    virtual void AddAtRoot(passes::ExactSums& sums) = 0;

    // One round of blocks: `dealer`, which the root alone has, deals to the devices of all processes; those
    // of this one ask `queue`. Returns when it has no more and the devices of this process know. `tick` is
    // called again and again, on the root with whether another process wants the round to end early; it
    // returns whether this one does. On the root it stops the dealer then. Throws the error of a device that
    // fails.
    using Tick = std::function<bool(bool isStopRequested)>;
    virtual void Deal(BlockDealer* dealer, BlockQueue& queue, const Tick& tick) = 0;
};

}  // namespace raygraph::session

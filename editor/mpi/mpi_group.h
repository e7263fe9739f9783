// The ranks of an MPI job as a ProcessGroup. MPI deals with messages and sums, and is called from one thread.
#pragma once

#include <mpi.h>

#include <vector>

#include "editor/session/process_group.h"

namespace raygraph::mpi {

// Wraps MPI_COMM_WORLD. It must live between MPI_Init_thread, with at least MPI_THREAD_FUNNELED, and
// MPI_Finalize. Threads: the one that initialized MPI.
class MpiGroup final : public session::ProcessGroup {
  public:
    // Throws Error{Io} for a failed call, here and below, if MPI returns at all.
    MpiGroup();
    ~MpiGroup() override;
    MpiGroup(const MpiGroup&) = delete;
    MpiGroup& operator=(const MpiGroup&) = delete;

    uint32_t Rank() const override { return m_rank; }
    uint32_t Size() const override { return m_size; }
    uint32_t LocalRank() const override { return m_localRank; }
    uint32_t LocalSize() const override { return m_localSize; }

    void Broadcast(std::span<std::byte> bytes) override;
    uint64_t Sum(uint64_t value) override;
    uint64_t Minimum(uint64_t value) override;
    void AddAtRoot(passes::ExactSums& sums) override;
    void Deal(session::BlockDealer* dealer, session::BlockQueue& queue, const Tick& tick) override;

  private:
    // Returns when all ranks have called it. It sleeps, whereas MPI's own waiting keeps a core busy.
    void WaitForAll();
    uint64_t Reduced(uint64_t value, MPI_Op op);
    void DealAsRoot(session::BlockDealer& dealer, session::BlockQueue& queue, const Tick& tick);
    void RequestFromRoot(session::BlockQueue& queue, const Tick& tick);

    MPI_Comm m_world = MPI_COMM_NULL;  // our own communicator
    uint32_t m_rank = 0, m_size = 1, m_localRank = 0, m_localSize = 1;
};

}  // namespace raygraph::mpi

// BlasBuilder: builds, compacts, refits and rebuilds bottom-level acceleration structures.
//
//     blas = builder.Add(desc);                    // any number
//     builder.Reserve();                           // takes the memory of their builds: here it can run out
//     builder.RecordBuilds(cmd);                   // builds, and asks for the compacted sizes
//     each frame: if (builder.Poll()) builder.RecordCompaction(cmd);   // never waits for the device
//
// A list that is dropped, or whose submission fails, undoes what was recorded into it: its builds and
// compactions are pending again. Statistics count submitted work.
//
// The builder orders its own steps on the device; making the results visible to their readers (a TLAS build,
// a trace) is up to the caller that records the list. Threads: one at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/api.h"
#include "rhi/acceleration_structure.h"
#include "rhi/resources.h"

namespace raygraph::rhi {

class CommandList;

struct BlasBuilderDesc {
    std::string name = "blas builder";
    uint64_t scratchBudget = 64ull << 20;  // bytes of scratch memory for the builds of one batch
    // False: structures stay as built. Deforming ones always stay so, because a rebuild needs that memory.
    // Compaction turns itself off after the first batch on a driver where it saves nothing.
    bool compacts = true;
    // Bytes of the compacted structures of one RecordCompaction, which exist beside the ones that they
    // replace. A larger structure is compacted alone.
    uint64_t compactionBudget = 64ull << 20;
};

struct CompactionStatistics {
    uint32_t blasCount = 0;       // live BLASes whose build was submitted
    uint64_t bytesBuilt = 0;      // bytes of the structures as built
    uint64_t bytesCompacted = 0;  // in use now; equals bytesBuilt where nothing was compacted
    uint32_t pending = 0;         // BLASes whose compaction is not recorded yet
    uint32_t buildCount = 0;      // builds submitted so far
    uint32_t batchCount = 0;      // build batches submitted so far
    uint32_t refitCount = 0;      // updates submitted so far
    uint32_t rebuildCount = 0;    // rebuilds of Deforming ones in place, submitted so far
    bool isOff = false;
    std::string disabledReason;  // one line; empty while it is on
};

class RAYGRAPH_API BlasBuilder {
  public:
    explicit BlasBuilder(Device& device, const BlasBuilderDesc& desc = {});
    ~BlasBuilder();
    BlasBuilder(const BlasBuilder&) = delete;
    BlasBuilder& operator=(const BlasBuilder&) = delete;

    // Registers a BLAS; RecordBuilds builds it. Dropping the last reference drops the BLAS at any time, also
    // before its build or compaction (memory is freed when the timeline allows). Throws Error{Usage} naming
    // the BLAS for a Desc without geometry, with both kinds of geometry, with null or misaligned addresses or
    // more primitives than the device supports.
    [[nodiscard]] std::shared_ptr<Blas> Add(const BlasDesc& desc);

    // Allocates the memory for building everything added since the last build, structures and scratch, and
    // the scratch memory of refits, as large as updates of all Deforming ones need under the budget, or the
    // largest rebuild: RecordBuilds and RecordRefits then allocate no more. On an Error everything stays
    // added, and what has been allocated is kept for the next call; it is freed with its BLAS, scratch of
    // refits by Trim.
    void Reserve();
    // Frees the scratch memory of refits where no Deforming BLAS is left. Reserve does so, too.
    void Trim() noexcept;
    // Builds everything added since the last call, in batches whose scratch stays under the budget; a single
    // BLAS that needs more has a batch and scratch of its own. Reserves memory that Reserve has not. On an
    // Error nothing is recorded and everything stays added.
    void RecordBuilds(CommandList& commands);

    // Checks for compacted sizes that have arrived, and allocates the memory for as many BLASes as
    // BlasBuilderDesc::compactionBudget allows; never waits. Returns true if RecordCompaction has work to do.
    // If memory is short, every kRetryPolls-th call tries again.
    bool Poll();
    static constexpr uint32_t kRetryPolls = 32;
    // Copies the BLASes for which Poll has allocated memory into smaller ones, which replace them at once for
    // everything recorded after this call; the old ones are retired once the list has been submitted.
    void RecordCompaction(CommandList& commands);

    // Updates Deforming BLASes in place. Addresses and strides of `desc` may differ from the build's; index
    // values must be the same, and no primitive may become inactive (NaN) or active again. With `rebuilds`,
    // in which neither counts, the structure is rebuilt in the same memory: as good as a new one, at the same
    // address. A TLAS with it has to be updated in either case, and need not be rebuilt. Batches share the
    // scratch memory of Reserve.
    struct RefitRequest {
        Blas* blas = nullptr;
        std::optional<BlasDesc> desc;  // none: that of the build, whose buffers have other contents by now
        bool rebuilds = false;
    };
    // Throws Error{Usage} naming the BLAS, before anything is recorded: for Static kind, before its build,
    // for the same BLAS twice, and for changed geometry, triangle, vertex or box counts or opacity.
    void RecordRefits(CommandList& commands, std::span<const RefitRequest> requests);

    CompactionStatistics Statistics() const;

  private:
    struct Impl;
    std::shared_ptr<Impl> m_impl;  // lists that are being recorded hold it weakly
};

}  // namespace raygraph::rhi

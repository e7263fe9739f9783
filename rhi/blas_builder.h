// BlasBuilder: builds, compacts and refits bottom-level acceleration structures.
//
//     blas = builder.Add(desc);                    // any number
//     builder.RecordBuilds(cmd);                   // builds, and asks for the compacted sizes
//     each frame: if (builder.Poll()) builder.RecordCompaction(cmd);   // never waits for the device
//
// A list that is dropped, or whose submission fails, undoes what was recorded into it: its builds and
// compactions are due again. Statistics count what has been submitted.
//
// The builder orders its own steps on the device; making the results visible to their readers (a TLAS build,
// a trace) is the work of who records the list. Threads: one at a time.
#pragma once

#include <cstdint>
#include <memory>
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
    // Off: keep what the build made. On a driver where compaction gains nothing it turns itself off after the
    // first batch.
    bool compacts = true;
    bool compactsWithoutGain = false;  // keep compacting even then: to test the copy path on such a driver
};

struct CompactionStatistics {
    uint32_t blasCount = 0;       // live BLASes whose build was submitted
    uint64_t bytesBuilt = 0;      // what their builds made
    uint64_t bytesCompacted = 0;  // what they take now; equals bytesBuilt where nothing was compacted
    uint32_t pending = 0;         // Static ones whose compaction is not yet recorded
    uint32_t buildCount = 0;      // builds submitted so far
    uint32_t batchCount = 0;      // build batches submitted so far
    uint32_t refitCount = 0;      // updates submitted so far
    bool isOff = false;
    std::string whyOff;  // one line; empty while it is on
};

class RAYGRAPH_API BlasBuilder {
  public:
    explicit BlasBuilder(Device& device, const BlasBuilderDesc& desc = {});
    ~BlasBuilder();
    BlasBuilder(const BlasBuilder&) = delete;
    BlasBuilder& operator=(const BlasBuilder&) = delete;

    // Takes note of a BLAS; RecordBuilds builds it. Dropping the last reference drops the BLAS at any time,
    // also before its build or compaction (memory is freed when the timeline allows). Throws Error{Usage}
    // naming the BLAS for a Desc without geometry, with both kinds of geometry, with null or misaligned
    // addresses or more primitives than the device takes.
    [[nodiscard]] std::shared_ptr<Blas> Add(const BlasDesc& desc);

    // Builds everything added since the last call, in batches whose scratch stays under the budget; a single
    // BLAS that needs more has a batch and scratch of its own. On an Error nothing is recorded and everything
    // stays added.
    void RecordBuilds(CommandList& commands);

    // Looks for compacted sizes that have arrived; never waits. True: RecordCompaction has something to do.
    bool Poll();
    // Copies every BLAS whose size has arrived into a smaller one, which takes its place at once for
    // everything recorded after this call; the old one is retired
    // once the list has been submitted. On an Error nothing is recorded and everything stays due.
    void RecordCompaction(CommandList& commands);

    // Updates Deforming BLASes in place. Addresses and strides of `desc` may differ from the build's; index
    // values must be the same, and no primitive may become inactive (NaN) or active again.
    struct RefitRequest {
        Blas* blas = nullptr;
        BlasDesc desc;
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

// Compaction: queries the compacted sizes of built BLASes and detects, without waiting, when they have
// arrived. For rhi/ alone.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "rhi/blas_builder.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class Compaction {
  public:
    struct Ready {
        std::shared_ptr<Blas> blas;
        AccelerationStructure structure;  // new structure of the compacted size
    };

    Compaction(Device& device, const BlasBuilderDesc& desc);
    ~Compaction();
    Compaction(const Compaction&) = delete;
    Compaction& operator=(const Compaction&) = delete;

    // A BLAS, and the structure of its recorded build.
    struct Query {
        std::weak_ptr<Blas> blas;
        VkAccelerationStructureKHR structure = VK_NULL_HANDLE;
    };
    // Creates a pool for this many queries. Returns null for a count of 0, if compaction is off, and if there
    // is no memory for a pool: then structures stay as built.
    VkQueryPool CreatePool(size_t count);
    // Takes ownership of the pool; does nothing with a null one.
    void RecordQueries(CommandList& commands, VkQueryPool pool, std::span<const Query> queries);
    // Must be called if the list with these queries will not be executed.
    void Abandon(VkQueryPool pool);

    // Returns true if TakeSlice will return anything.
    bool Poll();
    // Returns BLASes whose size has arrived, whose compaction is worthwhile, and for which there is memory
    // and budget, except those that have been dropped.
    std::vector<Ready> TakeSlice();
    void Requeue(std::span<const Ready> slice);

    bool IsOff() const { return !m_disabledReason.empty(); }
    const std::string& DisabledReason() const { return m_disabledReason; }
    uint32_t PendingCount() const;

  private:
    struct Entry {
        std::weak_ptr<Blas> blas;
        uint64_t bytes = 0;
    };
    struct Batch {
        VkQueryPool pool = VK_NULL_HANDLE;
        std::vector<Entry> entries;
        // Set by the device's retire queue once the list with the queries has completed (or was dropped).
        std::shared_ptr<std::atomic<bool>> isCompleted;
    };
    // A BLAS with the memory of its compacted copy.
    struct Reserved {
        std::weak_ptr<Blas> blas;
        AccelerationStructure structure;
    };
    bool ReadSizes(Batch& batch);
    void Judge(const Batch& batch);
    bool IsWorthCompacting(const Entry& entry) const;
    void ReserveSlice();
    void Release(Batch& batch);

    Device& m_device;
    uint64_t m_budget = 0;
    bool m_isJudged = false;
    std::string m_disabledReason;
    std::vector<Batch> m_waiting;
    std::vector<Entry> m_ready;
    std::vector<Reserved> m_slice;  // the next structures to copy
    uint32_t m_pollsToRetry = 0;    // polls to wait for after memory has run out
    bool m_hasRunOut = false;
};

}  // namespace raygraph::rhi

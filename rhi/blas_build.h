// The parts of BlasBuilder: scratch memory that builds share in batches, the Vulkan structures of a BlasDesc
// with the checks of builds and updates, and compaction. For rhi/ alone. Threads: those of the BlasBuilder,
// one at a time.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "rhi/acceleration_structure.h"
#include "rhi/blas_builder.h"
#include "rhi/resources.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

// Scratch memory of acceleration-structure builds.
class BuildScratch {
  public:
    BuildScratch() = default;
    BuildScratch(Device& device, const std::string& name, uint64_t bytes);

    // Returns the address, aligned to minAccelerationStructureScratchOffsetAlignment.
    VkDeviceAddress Address() const { return m_address; }
    uint64_t Bytes() const { return m_bytes; }

  private:
    Buffer m_buffer;
    VkDeviceAddress m_address = 0;
    uint64_t m_bytes = 0;
};

// Returns the bytes of scratch that one build uses of a shared buffer, rounded up so that the next one starts
// aligned.
uint64_t AlignedScratchSize(const Device& device, uint64_t bytes);

// Builds split into batches that run one after the other in the same scratch memory.
struct BatchPlan {
    struct Batch {
        size_t first = 0;  // build
        size_t end = 0;    // past the last one
        bool operator==(const Batch&) const = default;
    };
    std::vector<Batch> batches;
    // The offset in bytes of each build's scratch in the shared memory. Builds of a batch do not overlap.
    std::vector<uint64_t> offsets;
    uint64_t scratchBytes = 0;  // bytes for the largest batch
};

// Splits builds in order into batches, each with as many builds as fit the budget, at least one. Pure.
BatchPlan PlanBatches(std::span<const uint64_t> scratchSizes, uint64_t budget);

// Orders builds, copies and size queries of acceleration structures after those recorded or submitted before.
void BarrierBetweenBuilds(CommandList& commands);

// --- The Vulkan structures of a BlasDesc, and the checks of builds and updates ---

// Throws Error{Usage} naming the BLAS for what BlasBuilder::Add refuses.
void CheckBuildable(const BlasDesc& desc);
// Throws Error{Usage} naming the BLAS unless `next` is a legal update of `built`.
void CheckUpdatable(const BlasDesc& built, const BlasDesc& next);

// Geometries and ranges of one build; the Vulkan structures point into this object.
class BlasGeometry {
  public:
    BlasGeometry(const BlasDesc& desc, VkBuildAccelerationStructureFlagsKHR flags);
    BlasGeometry(const BlasGeometry&) = delete;
    BlasGeometry& operator=(const BlasGeometry&) = delete;

    VkAccelerationStructureBuildSizesInfoKHR Sizes(Device& device) const;
    // The caller completes it: mode, source, destination and scratch.
    VkAccelerationStructureBuildGeometryInfoKHR& Info() { return m_info; }
    const VkAccelerationStructureBuildRangeInfoKHR* Ranges() const { return m_ranges.data(); }

  private:
    std::vector<VkAccelerationStructureGeometryKHR> m_geometries;
    std::vector<VkAccelerationStructureBuildRangeInfoKHR> m_ranges;
    VkAccelerationStructureBuildGeometryInfoKHR m_info{};
};

// Queries the compacted sizes of built BLASes, and detects, without waiting, when they have arrived.
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

    // Holds a BLAS, and the structure of its recorded build.
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
    // Holds a BLAS with the memory of its compacted copy.
    struct Reserved {
        std::weak_ptr<Blas> blas;
        AccelerationStructure structure;
    };
    bool ReadSizes(Batch& batch);
    void EvaluateSavings(const Batch& batch);
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

// Scratch memory of acceleration-structure builds: how builds share it in batches, and the barrier between
// them. For rhi/ alone. Threads: those of its owner, one at a time.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rhi/resources.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class CommandList;

class BuildScratch {
  public:
    BuildScratch() = default;
    BuildScratch(Device& device, const std::string& name, uint64_t bytes);

    // The address, aligned to minAccelerationStructureScratchOffsetAlignment.
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
    std::vector<uint64_t>
        offsets;  // of each build's scratch in the shared memory; builds of a batch do not overlap
    uint64_t scratchBytes = 0;  // bytes for the largest batch
};

// Splits builds in order into batches, each with as many builds as fit the budget, at least one. Pure.
BatchPlan PlanBatches(std::span<const uint64_t> scratchSizes, uint64_t budget);

// Orders builds, copies and size queries of acceleration structures after those recorded or submitted before.
void BarrierBetweenBuilds(CommandList& commands);

}  // namespace raygraph::rhi

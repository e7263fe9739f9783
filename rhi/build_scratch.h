// Scratch memory of acceleration-structure builds, and the barrier between builds that share it. For rhi/
// alone.
#pragma once

#include <cstdint>
#include <string>

#include "rhi/resources.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class CommandList;

class BuildScratch {
  public:
    BuildScratch() = default;
    BuildScratch(Device& device, const std::string& name, uint64_t bytes);

    // Aligned to minAccelerationStructureScratchOffsetAlignment.
    VkDeviceAddress Address() const { return m_address; }
    uint64_t Bytes() const { return m_bytes; }

  private:
    Buffer m_buffer;
    VkDeviceAddress m_address = 0;
    uint64_t m_bytes = 0;
};

// Bytes of scratch that one build takes of a shared buffer, rounded up so that the next one starts aligned.
uint64_t ScratchShare(const Device& device, uint64_t bytes);

// Orders builds, copies and size queries of acceleration structures after those recorded or submitted before.
void BarrierBetweenBuilds(CommandList& commands);

}  // namespace raygraph::rhi

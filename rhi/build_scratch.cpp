#include "rhi/build_scratch.h"

#include <algorithm>

#include "base/check.h"
#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/shader_binding_table.h"

namespace raygraph::rhi {

BuildScratch::BuildScratch(Device& device, const std::string& name, uint64_t bytes) : m_bytes(bytes) {
    const uint64_t alignment = device.Info().scratchAlignment;
    m_buffer = device.CreateBuffer({.name = name + " scratch",
                                    .size = bytes + alignment,
                                    .usage = BufferUsage::Storage,
                                    .memory = MemoryKind::Device});
    m_address = AlignUp(m_buffer.Address(), alignment);
    RG_CHECK_EQ(m_address % alignment, 0u);
    RG_CHECK_LE(m_address + bytes, m_buffer.Address() + m_buffer.Size());
}

uint64_t AlignedScratchSize(const Device& device, uint64_t bytes) {
    return AlignUp(bytes, device.Info().scratchAlignment);
}

BatchPlan PlanBatches(std::span<const uint64_t> scratchSizes, uint64_t budget) {
    BatchPlan plan;
    for (size_t first = 0; first < scratchSizes.size();) {
        size_t end = first;
        uint64_t bytes = 0;
        while (end < scratchSizes.size() && (end == first || bytes + scratchSizes[end] <= budget)) {
            plan.offsets.push_back(bytes);
            bytes += scratchSizes[end++];
        }
        plan.batches.push_back({first, end});
        plan.scratchBytes = std::max(plan.scratchBytes, bytes);
        first = end;
    }
    return plan;
}

void BarrierBetweenBuilds(CommandList& commands) {
    VkMemoryBarrier2 barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
    barrier.srcAccessMask =
        VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR | VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
    barrier.dstStageMask = barrier.srcStageMask;
    barrier.dstAccessMask = barrier.srcAccessMask;
    commands.Barriers({&barrier, 1}, {});
}

}  // namespace raygraph::rhi

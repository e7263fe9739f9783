// The common fields of an image barrier. For rhi/ and renderer/graph/ alone. Threads: any.
#pragma once

#include "rhi/resources.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

// Returns a barrier for all levels and layers, without a transfer of queue family ownership. The caller sets
// stages and accesses.
inline VkImageMemoryBarrier2 ImageBarrier(const Texture& texture, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier2 barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = texture.Image();
    barrier.subresourceRange = texture.WholeRange();
    return barrier;
}

}  // namespace raygraph::rhi

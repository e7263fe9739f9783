// The MemoryAllocator of Devices whose host has none. For rhi/ alone; threads as there.
#pragma once

#include <memory>

#include "rhi/functions.h"
#include "rhi/memory_allocator.h"

namespace raygraph::rhi {

struct VmaAllocatorDesc {
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
    PFN_vkGetDeviceProcAddr getDeviceProcAddr = nullptr;
    bool hasMemoryBudget = false;  // VK_EXT_memory_budget is enabled
    const VkAllocationCallbacks* callbacks = nullptr;
};

// Sets `allocator` after a success only.
VkResult CreateVmaAllocator(const VmaAllocatorDesc& desc, std::unique_ptr<MemoryAllocator>& allocator);

}  // namespace raygraph::rhi

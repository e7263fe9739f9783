// The Vulkan Memory Allocator without static Vulkan functions: it calls everything through the device's
// loader.
#pragma once

#include "rhi/vulkan.h"

#define VMA_STATIC_VULKAN_FUNCTIONS  0
#define VMA_DYNAMIC_VULKAN_FUNCTIONS 1
#include <vk_mem_alloc.h>

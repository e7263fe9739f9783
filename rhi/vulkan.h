// The Vulkan headers as the whole project sees them: types only. Functions are reached through
// DeviceFunctions (rhi/functions.h), one table per device, so that nothing is global and a host's loader is
// respected.
#pragma once

#ifndef VK_NO_PROTOTYPES
#define VK_NO_PROTOTYPES
#endif
#include <vulkan/vulkan_core.h>

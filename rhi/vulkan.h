// The Vulkan headers as the whole project sees them: types only. Functions are reached through
// DeviceFunctions (rhi/functions.h), one table per device, so that nothing is global and a host's loader is
// respected. Threads: types only.
#pragma once

// Within this tree VK_NO_PROTOTYPES is defined by the build, so that nothing of ours can call a function of
// libvulkan. Not here: a host that includes our headers before <vulkan/vulkan.h> is to get its own
// prototypes.
#include <vulkan/vulkan_core.h>

// The Vulkan headers as the whole project sees them: types only. Functions are reached through
// DeviceFunctions (rhi/functions.h), one table per device, so that nothing is global and a host's loader is
// respected. Threads: types only.
#pragma once

// Within this tree VK_NO_PROTOTYPES is defined by the build, so that no code here can call a function of
// libvulkan. It is not defined in this header: a host that includes it before <vulkan/vulkan.h> must still
// get its prototypes.
#include <vulkan/vulkan_core.h>

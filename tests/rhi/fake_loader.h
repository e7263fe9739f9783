// A Vulkan loader that lies: the system's own, with chosen answers changed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rhi/functions.h"

namespace raygraph::testing {

// What the loader changes. Vulkan's functions carry no user data, so the lies are the process's; one
// FakeLoader exists at a time.
struct Lies {
    std::string hiddenExtension;             // a device extension that no device has
    bool hasNoScalarBlockLayout = false;     // the feature reads as missing
    uint32_t maxPushDescriptors = 0;         // not 0: the limit reads so
    uint32_t apiVersion = 0;                 // not 0: every device reads so
    VkResult submitResult = VK_SUCCESS;      // not VK_SUCCESS: vkQueueSubmit2 fails so, and submits nothing
    VkResult nextSubmitResult = VK_SUCCESS;  // the same, once
    bool hasNoFloatFilter = false;           // rgba32f reads as not filtered linearly
    int32_t buffersBeforeFailure = -1;       // not -1: vkCreateBuffer fails once after as many successes
    VkResult resetPoolResult = VK_SUCCESS;   // not VK_SUCCESS: vkResetCommandPool fails so
    std::vector<VkBufferMemoryBarrier2> bufferBarriers;  // no lie: what has been recorded
    VkResult waitResult = VK_SUCCESS;                    // not VK_SUCCESS: vkWaitSemaphores fails so
};

class FakeLoader {
  public:
    FakeLoader();
    ~FakeLoader();
    FakeLoader(const FakeLoader&) = delete;
    FakeLoader& operator=(const FakeLoader&) = delete;

    PFN_vkGetInstanceProcAddr Entry() const;
    Lies& Tell();

  private:
    std::shared_ptr<rhi::VulkanLoader> m_system;
};

}  // namespace raygraph::testing

// FakeLoader is the system's Vulkan loader with chosen answers changed.
#pragma once

#include <array>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "rhi/functions.h"

namespace raygraph::testing {

// Lists what the loader changes. Vulkan's functions carry no user data, so the lies are global; one
// FakeLoader exists at a time.
struct Lies {
    std::string hiddenExtension;             // a device extension that no device has
    bool hasNoScalarBlockLayout = false;     // the feature reads as missing
    bool cannotDraw = false;                 // the features that drawing a scene needs read as missing
    bool hasNoBlocks = false;                // textureCompressionBC reads as missing
    uint32_t maxPushDescriptors = 0;         // not 0: the limit reads so
    uint32_t apiVersion = 0;                 // not 0: every device reads so
    VkResult submitResult = VK_SUCCESS;      // not VK_SUCCESS: vkQueueSubmit2 fails so, and submits nothing
    VkResult nextSubmitResult = VK_SUCCESS;  // the same, once
    bool hasNoFloatFilter = false;           // rgba32f reads as not filtered linearly
    int32_t buffersBeforeFailure = -1;       // not -1: vkCreateBuffer fails once after as many successes
    VkResult resetPoolResult = VK_SUCCESS;   // not VK_SUCCESS: vkResetCommandPool fails so
    std::vector<VkBufferMemoryBarrier2> bufferBarriers;  // no lie: what has been recorded
    std::vector<std::vector<VkSemaphoreSubmitInfo>>
        submitWaits;  // no lie: what each vkQueueSubmit2 waits for
    // No lie, either: the modes of the acceleration structures that each command has built or updated.
    std::vector<std::vector<VkBuildAccelerationStructureModeKHR>> builds;
    uint32_t samplers = 0;                      // likewise: how many vkCreateSampler has made
    uint64_t buildScratchBytes = 0;             // not 0: builds of structures need at least so much
    VkResult waitResult = VK_SUCCESS;           // not VK_SUCCESS: vkWaitSemaphores fails so
    uint64_t maxStorageBufferRange = 0;         // not 0: the limit reads so
    std::shared_future<void> beforeRayTracing;  // valid: vkCreateRayTracingPipelinesKHR waits for it first
    std::vector<std::thread::id> rayTracingMakers;  // no lie: the threads that have called it
    // Not 0: a vkCreateComputePipelines waits until as many have been called, but at most ten seconds.
    uint32_t computePipelinesAtOnce = 0;
    bool areComputePipelinesAlone = false;        // no lie: one of them has waited ten seconds for the others
    VkResult computePipelineResult = VK_SUCCESS;  // not VK_SUCCESS: vkCreateComputePipelines fails so
    // On: the device has the memory types below instead of one for all. Set before the device is made.
    bool hasSeparateMemory = false;
    uint64_t deviceBytesLeft = ~uint64_t{0};  // device memory left to vkAllocateMemory with these types
    uint64_t hostBytesLeft = ~uint64_t{0};    // host memory left to it
    std::array<uint64_t, 4> takenBytes{};     // by type: allocated so far
    uint64_t heapUsage = 1u << 20;            // use of each heap that the driver reports
    // On: devices have VK_KHR_pipeline_executable_properties, and tell of two programs of each pipeline that
    // was made to capture statistics: "main" with 40 "Register Count" and a true "Spills", "other" without any.
    bool hasStatistics = false;
};

// The memory types of Lies::hasSeparateMemory: a graphics card's. Heaps: device, host, mapped device memory.
enum FakeMemoryType : uint32_t { kDeviceMemory, kMappedDeviceMemory, kHostMemory, kCachedHostMemory };
inline constexpr uint64_t kFakeDeviceHeapBytes = 64u << 20;
inline constexpr uint64_t kFakeDeviceBudgetBytes = 48u << 20;

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

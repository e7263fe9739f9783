// HostDevice is a host engine's own Vulkan device, made from rhi::Requirements() without rhi::Device.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "rhi/device.h"
#include "rhi/functions.h"

namespace raygraph::testing {

// Counts allocations through callbacks. Thread-safe.
class CountingAllocator {
  public:
    CountingAllocator();
    const VkAllocationCallbacks* Callbacks() const { return &m_callbacks; }
    int64_t Live() const { return m_live.load(); }
    int64_t Total() const { return m_total.load(); }

  private:
    static VKAPI_ATTR void* VKAPI_CALL Allocate(void* user, size_t size, size_t alignment,
                                                VkSystemAllocationScope);
    static VKAPI_ATTR void* VKAPI_CALL Reallocate(void* user, void* old, size_t size, size_t alignment,
                                                  VkSystemAllocationScope);
    static VKAPI_ATTR void VKAPI_CALL Free(void* user, void* memory);
    VkAllocationCallbacks m_callbacks{};
    std::atomic<int64_t> m_live{0}, m_total{0};
};

// Has validation layers where they are installed and wanted, and stores their messages.
class HostDevice {
  public:
    explicit HostDevice(bool wantsValidation = true);
    ~HostDevice();
    HostDevice(const HostDevice&) = delete;
    HostDevice& operator=(const HostDevice&) = delete;

    // Returns a description with everything that Adopt needs.
    rhi::AdoptedDeviceDesc Desc() const;
    // Adds a compute and a transfer queue: of families of their own where the device has them, otherwise the
    // main queue.
    rhi::AdoptedDeviceDesc DescWithQueues() const;
    const rhi::InstanceFunctions& InstanceFunctions() const { return m_instanceFunctions; }
    const rhi::DeviceFunctions& Functions() const { return m_functions; }
    VkDevice Handle() const { return m_device; }
    VkPhysicalDevice PhysicalDevice() const { return m_physicalDevice; }
    const std::string& ValidationText() const { return m_validationText; }

  private:
    void CreateInstance(const rhi::GlobalFunctions& global, bool wantsValidation);
    void CreateDevice();
    void Destroy();

    std::shared_ptr<rhi::VulkanLoader> m_loader;
    bool m_hasDebugUtils = false;
    VkInstance m_instance = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT m_messenger = VK_NULL_HANDLE;
    VkPhysicalDevice m_physicalDevice = VK_NULL_HANDLE;
    VkDevice m_device = VK_NULL_HANDLE;
    std::array<rhi::AdoptedQueue, rhi::kQueueKinds.size()> m_queues{};  // by rhi::QueueKind
    std::vector<std::string> m_extensions;
    rhi::InstanceFunctions m_instanceFunctions;
    rhi::DeviceFunctions m_functions;
    std::string m_validationText;
};

}  // namespace raygraph::testing

// Gate keeps work pending for as long as a test wants.
#pragma once

#include "rhi/device.h"

namespace raygraph::testing {

// Is a timeline semaphore that the test signals: work that waits for it stays pending until then.
class Gate {
  public:
    explicit Gate(rhi::Device& device) : m_device(device) {
        VkSemaphoreTypeCreateInfo type{};
        type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
        type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
        const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
        device.Check(device.Vk().vkCreateSemaphore(device.Handle(), &info, nullptr, &m_semaphore), "gate");
    }
    ~Gate() {
        Open();
        // Mesa's queue thread touches a submission's semaphores for a moment after it has signaled the last one.
        m_device.WaitQueueIdle();
        m_device.Vk().vkDestroySemaphore(m_device.Handle(), m_semaphore, nullptr);
    }
    Gate(const Gate&) = delete;
    Gate& operator=(const Gate&) = delete;

    rhi::SemaphoreUse At(uint64_t value) const { return {m_semaphore, value}; }
    void Open() {
        if (Value() > 0) return;  // open already
        const VkSemaphoreSignalInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, nullptr, m_semaphore, 1};
        m_device.Check(m_device.Vk().vkSignalSemaphore(m_device.Handle(), &info), "gate");
    }
    uint64_t Value() const {
        uint64_t value = 0;
        m_device.Check(m_device.Vk().vkGetSemaphoreCounterValue(m_device.Handle(), m_semaphore, &value),
                       "gate");
        return value;
    }

  private:
    rhi::Device& m_device;
    VkSemaphore m_semaphore = VK_NULL_HANDLE;
};

}  // namespace raygraph::testing

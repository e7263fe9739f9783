// The sink of all messages of a Device: one callback, with a count of validation messages.
#pragma once

#include <atomic>
#include <string>

#include "rhi/device.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

// Thread-safe if the callback is.
class MessageSink {
  public:
    explicit MessageSink(MessageCallback callback) : m_callback(std::move(callback)) {}

    void Send(const Message& message);
    uint64_t ValidationCount() const { return m_validationCount.load(std::memory_order_relaxed); }

    // The messenger that sends warnings and errors of the validation layers to this sink, which has to
    // outlive it.
    VkDebugUtilsMessengerCreateInfoEXT MessengerInfo();

  private:
    MessageCallback m_callback;
    std::atomic<uint64_t> m_validationCount{0};
};

}  // namespace raygraph::rhi

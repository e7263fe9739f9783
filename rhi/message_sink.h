// The sink of all messages of a Device: its log, with a count of validation messages. Threads: as the log's
// callback.
#pragma once

#include <atomic>
#include <string>

#include "rhi/device.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

// Thread-safe if the callback is.
class MessageSink {
  public:
    explicit MessageSink(Log log) : m_log(std::move(log)) {}

    const Log& Messages() const { return m_log; }
    // Counts the message, even if nobody listens.
    void SendValidation(LogLevel level, std::string_view id, std::string_view text) noexcept;
    uint64_t ValidationCount() const { return m_validationCount.load(std::memory_order_relaxed); }

    // Returns a messenger that sends warnings and errors of the validation layers to this sink, which must
    // outlive it.
    VkDebugUtilsMessengerCreateInfoEXT MessengerInfo();

  private:
    Log m_log;
    std::atomic<uint64_t> m_validationCount{0};
};

}  // namespace raygraph::rhi

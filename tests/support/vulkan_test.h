// VulkanTest: a test with a device, which fails when the validation layers say anything.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "rhi/device.h"

namespace raygraph::testing {

// Collects what a device says. Outlives the device. Thread-safe.
class MessageLog {
  public:
    struct Message {
        LogLevel level;
        std::string category, text;
        bool IsValidation() const { return category == log_category::kValidation; }
    };

    // Returns the log for a device.
    raygraph::Log Listener(LogLevel least = LogLevel::Warning);
    size_t Count() const;
    // One line a message, from the `first` one on; `validationOnly` leaves out our own.
    std::string Text(size_t first = 0, bool validationOnly = false) const;
    std::vector<Message> All() const;

  private:
    mutable std::mutex m_mutex;
    std::vector<Message> m_messages;
};

// The fixture of every test on a device. The device is made at the first use with core and synchronization
// validation, shared by all tests of the process and destroyed after the last; it is there before the members
// of a derived fixture are constructed. What the layers say until after those members are destroyed fails the
// test.
class VulkanTest : public ::testing::Test {
  public:
    VulkanTest();
    ~VulkanTest() override;

    static rhi::Device& Device();
    // Returns what the shared device logs from LogLevel::Info on, our own messages included.
    static MessageLog& Log();
    // Runs `destroy` before the shared device is destroyed: for what tests share on it.
    static void OnDeviceDestroy(std::function<void()> destroy);

  private:
    uint64_t m_validationCount;
    size_t m_messageCount;
};

// Values as bytes and back, for uploads and readbacks.
template <typename T>
std::vector<T> As(std::span<const std::byte> bytes) {
    std::vector<T> values(bytes.size() / sizeof(T));
    std::copy_n(bytes.begin(), values.size() * sizeof(T), std::as_writable_bytes(std::span(values)).begin());
    return values;
}
template <typename T>
std::span<const std::byte> BytesOf(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

}  // namespace raygraph::testing

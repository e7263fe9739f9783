// Opens the device of a command and collects its messages.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "rhi/device.h"

namespace raygraph::cli {

// Messages of one device, from any thread. Outlives the device.
class DeviceMessages {
  public:
    void Add(const rhi::Message& message);
    // Warnings and errors that are no validation messages, since the last call; one line each.
    std::vector<std::string> TakeWarnings();
    // Throws Error{Vulkan} with the first validation message and their number, if there was any.
    void RequireValid() const;

  private:
    mutable std::mutex m_mutex;
    std::vector<std::string> m_warnings;
    std::vector<std::string> m_validation;
};

struct DeviceChoice {
    std::string select;  // index or part of the name; "": the best suitable
    bool isValidating = false;
    std::vector<std::string> surfaceExtensions = {};  // as of rhi::DeviceDesc
};

// Error{NoDevice} as of Device::Create.
std::unique_ptr<rhi::Device> OpenDevice(const DeviceChoice& choice, DeviceMessages& messages);

}  // namespace raygraph::cli

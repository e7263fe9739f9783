// Opens the device of a command.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rhi/device.h"

namespace raygraph::cli {

struct DeviceChoice {
    std::string select;  // index or part of the name; "": RAYGRAPH_DEVICE, else the best suitable
    bool isValidating = false;
    std::vector<std::string> surfaceExtensions = {};  // as of rhi::DeviceDesc
};

// Error{NoDevice} as of Device::Create; it names the variable, if the choice is that of the variable.
std::unique_ptr<rhi::Device> OpenDevice(const DeviceChoice& choice, const Log& log);

}  // namespace raygraph::cli

// The choice of one of a machine's devices. Threads: pure functions.
#pragma once

#include <string>
#include <vector>

#include "rhi/device.h"

namespace raygraph::rhi {

// Returns the index of the device that Device::Create takes for DeviceDesc::select. Error{NoDevice} with a
// reason for each that is not used.
RAYGRAPH_API uint32_t ChooseDevice(const std::vector<DeviceReport>& reports, const std::string& select);

}  // namespace raygraph::rhi

// The devices of a machine as text.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "rhi/device.h"

namespace raygraph::cli {

// One paragraph a device: index, name, kind, driver, and whether it is suitable or every reason why not.
std::string DescribeDevices(std::span<const rhi::DeviceReport> devices);
// "1.3", of Vulkan's packing.
std::string VersionText(uint32_t version);

}  // namespace raygraph::cli

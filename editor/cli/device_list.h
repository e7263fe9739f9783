// Describes the devices of a machine, and selects some by a list. Threads: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rhi/device.h"

namespace raygraph::cli {

// Returns one paragraph per device: index, name, kind, driver, and that it is suitable or every reason why
// not.
std::string DescribeDevices(std::span<const rhi::DeviceReport> devices);
// Returns e.g. "1.3" from Vulkan's packed version.
std::string VersionText(uint32_t version);

// Returns the operand of --devices if it is valid: "all", or indices with commas. Throws Error{Usage}.
std::string ValidatedDevices(const std::string& list);

// Returns the indices of the devices in a checked list; "all" means the suitable ones with the name and
// driver of the best. A device whose index is repeated is opened as often. Throws Error{NoDevice}, with the
// reason, for a device that is not suitable, and if there is no suitable one at all.
std::vector<uint32_t> IndicesOf(const std::string& list, const std::vector<rhi::DeviceReport>& devices);

// Returns the devices that one of `count` processes takes: every count-th. With more processes than devices,
// processes share them. It is never empty if `indices` is not.
std::vector<uint32_t> ShareOf(const std::vector<uint32_t>& indices, uint32_t process, uint32_t count);

}  // namespace raygraph::cli

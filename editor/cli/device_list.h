// The devices of a machine, as text and by a list of them. Threads: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rhi/device.h"

namespace raygraph::cli {

// One paragraph a device: index, name, kind, driver, and whether it is suitable or every reason why not.
std::string DescribeDevices(std::span<const rhi::DeviceReport> devices);
// "1.3", of Vulkan's packing.
std::string VersionText(uint32_t version);

// The value of --devices, if it is one: "all", or indices with commas. Error{Usage}.
std::string CheckedDevices(const std::string& list);

// The indices of the devices that a checked list names: for "all" the suitable ones with the name and driver
// of the best. An index may be there twice: then the device is opened twice. Error{NoDevice} for an index
// that is of no suitable device, with the reason, and where there is none at all.
std::vector<uint32_t> IndicesOf(const std::string& list, const std::vector<rhi::DeviceReport>& devices);

// What one of `count` processes takes of these: every count-th one; where there are more processes than
// devices, one that others take, too. At least one of at least one.
std::vector<uint32_t> ShareOf(const std::vector<uint32_t>& indices, uint32_t process, uint32_t count);

}  // namespace raygraph::cli

// Opens the devices of a command.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "editor/cli/arguments.h"
#include "editor/session/process_group.h"
#include "rhi/device.h"

namespace raygraph::cli {

struct DeviceChoice {
    std::string select;  // index or part of the name; "": RAYGRAPH_DEVICE, else the best suitable device
    bool isValidating = false;
    std::vector<std::string> surfaceExtensions = {};  // see rhi::DeviceDesc, which also has the next
    bool capturesStatistics = false;
};

// Throws Error{NoDevice} as Device::Create does; the message names RAYGRAPH_DEVICE if that made the choice.
std::unique_ptr<rhi::Device> OpenDevice(const DeviceChoice& choice, const Log& log);

// Opens the devices of a render, at least one; a repeated one is opened as often. In a group without
// --devices, each process takes its share of the best kind of device of its computer, and shares one if there
// are more processes than devices. Throws Error{NoDevice}.
std::vector<std::unique_ptr<rhi::Device>> OpenDevices(const RenderArguments& arguments,
                                                      const ProcessGroup* group, const Log& log);

}  // namespace raygraph::cli

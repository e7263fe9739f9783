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
    std::string select;  // index or part of the name; "": RAYGRAPH_DEVICE, else the best suitable
    bool isValidating = false;
    std::vector<std::string> surfaceExtensions = {};  // as of rhi::DeviceDesc, likewise the next
    bool capturesStatistics = false;
};

// Error{NoDevice} as of Device::Create; it names the variable, if the choice is that of the variable.
std::unique_ptr<rhi::Device> OpenDevice(const DeviceChoice& choice, const Log& log);

// Those of a render, at least one, each once more for each time that it is named. In a group, where none is
// asked for: each process takes its share of the best kind of devices of its computer, and one that is shared
// where there are more processes. Error{NoDevice}.
std::vector<std::unique_ptr<rhi::Device>> OpenDevices(const RenderArguments& arguments,
                                                      const ProcessGroup* group, const Log& log);

}  // namespace raygraph::cli

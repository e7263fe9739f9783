#include "editor/cli/device_setup.h"

#include <cstdlib>

#include "base/text.h"
#include "editor/cli/device_list.h"

namespace raygraph::cli {

namespace {

// Returns the device to use if no option names one; "": any.
std::string DeviceVariable() {
    const char* variable = std::getenv("RAYGRAPH_DEVICE");
    return variable != nullptr ? variable : "";
}

}  // namespace

std::unique_ptr<rhi::Device> OpenDevice(const DeviceChoice& choice, const Log& log) {
    const auto open = [&](const std::string& select) {
        return rhi::Device::Create({.select = select,
                                    .validation = choice.isValidating,
                                    .log = log,
                                    .surfaceExtensions = choice.surfaceExtensions,
                                    .capturesStatistics = choice.capturesStatistics});
    };
    if (!choice.select.empty()) return open(choice.select);
    const std::string variable = DeviceVariable();
    if (variable.empty()) return open("");
    try {
        return open(variable);
    } catch (const Error& error) {
        const std::string message = error.what();
        if (message.find(Text("'{}'", variable)) == message.npos) throw;  // no device at all is suitable
        throw Error(error.Kind(), "RAYGRAPH_DEVICE: " + message, error.Result());
    }
}

std::vector<std::unique_ptr<rhi::Device>> OpenDevices(const RenderArguments& arguments,
                                                      const ProcessGroup* group, const Log& log) {
    std::vector<std::string> selected;
    if (!arguments.devices.empty()) {
        for (const uint32_t index : IndicesOf(arguments.devices, rhi::Device::Enumerate()))
            selected.push_back(std::to_string(index));
    } else if (group != nullptr && arguments.device.empty() && DeviceVariable().empty()) {
        for (const uint32_t index :
             ShareOf(IndicesOf("all", rhi::Device::Enumerate()), group->LocalRank(), group->LocalSize()))
            selected.push_back(std::to_string(index));
    } else {
        selected.push_back(arguments.device);
    }
    std::vector<std::unique_ptr<rhi::Device>> devices;
    for (const std::string& select : selected)
        devices.push_back(OpenDevice({select, arguments.isValidating}, log));
    return devices;
}

}  // namespace raygraph::cli

#include "editor/cli/device_setup.h"

#include "editor/cli/device_list.h"

namespace raygraph::cli {

std::unique_ptr<rhi::Device> OpenDevice(const DeviceChoice& choice, const Log& log) {
    return rhi::Device::Create({.select = choice.select,
                                .validation = choice.isValidating,
                                .log = log,
                                .surfaceExtensions = choice.surfaceExtensions});
}

std::vector<std::unique_ptr<rhi::Device>> OpenDevices(const RenderArguments& arguments,
                                                      const ProcessGroup* group, const Log& log) {
    std::vector<std::string> selected;
    if (!arguments.devices.empty()) {
        for (const uint32_t index : IndicesOf(arguments.devices, rhi::Device::Enumerate()))
            selected.push_back(std::to_string(index));
    } else if (group != nullptr && arguments.device.empty()) {
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

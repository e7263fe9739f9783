#include "editor/cli/device_list.h"

#include "base/text.h"

namespace raygraph::cli {

// Major in 7 bits from 22, minor in 10 from 12.
std::string VersionText(uint32_t version) {
    return Text("{}.{}", (version >> 22) & 0x7Fu, (version >> 12) & 0x3FFu);
}

std::string DescribeDevices(std::span<const rhi::DeviceReport> devices) {
    if (devices.empty())
        return "no Vulkan devices: no driver is installed, or the loader (libvulkan.so.1) is missing\n";
    std::string text;
    for (const rhi::DeviceReport& device : devices) {
        text += Text("{}  {}\n", device.index, device.name);
        text +=
            "   kind      " + std::string(Name(device.type)) + ", Vulkan " + VersionText(device.apiVersion);
        text += "\n   driver    " + device.driver + "\n";
        if (device.refusals.empty()) {
            text += "   suitable  yes\n";
            continue;
        }
        text += "   suitable  no:\n";
        for (const std::string& refusal : device.refusals) text += "             - " + refusal + "\n";
    }
    return text;
}

}  // namespace raygraph::cli

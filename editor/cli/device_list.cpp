#include "editor/cli/device_list.h"

#include <algorithm>

#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "rhi/choose_device.h"

namespace raygraph::cli {

// Vulkan packs the major version into 7 bits from bit 22, and the minor into 10 from bit 12.
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

std::string ValidatedDevices(const std::string& list) {
    if (list == "all") return list;
    for (const std::string_view index : session::ParseList(list)) session::ParseCount(index);
    return list;
}

std::vector<uint32_t> IndicesOf(const std::string& list, const std::vector<rhi::DeviceReport>& devices) {
    std::vector<uint32_t> indices;
    if (list != "all") {
        for (const std::string_view index : session::ParseList(list))
            indices.push_back(rhi::ChooseDevice(devices, std::string(index)));
        return indices;
    }
    const auto best = std::ranges::find(devices, rhi::ChooseDevice(devices, ""), &rhi::DeviceReport::index);
    for (const rhi::DeviceReport& device : devices)
        if (device.refusals.empty() && device.name == best->name && device.driver == best->driver)
            indices.push_back(device.index);
    return indices;
}

std::vector<uint32_t> ShareOf(const std::vector<uint32_t>& indices, uint32_t process, uint32_t count) {
    if (count > indices.size()) return {indices[process % indices.size()]};
    std::vector<uint32_t> share;
    for (size_t i = process; i < indices.size(); i += count) share.push_back(indices[i]);
    return share;
}

}  // namespace raygraph::cli

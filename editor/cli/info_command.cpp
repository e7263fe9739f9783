// Implements `raygraph info`.
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_list.h"
#include "editor/cli/info_json.h"
#include "editor/cli/scene_text.h"
#include "editor/session/settings/scene_input.h"
#include "rhi/device.h"

namespace raygraph::cli {

void InfoCommand(const InfoArguments& arguments, Console& console) {
    if (arguments.isListingDevices) {
        const std::vector<rhi::DeviceReport> devices = rhi::Device::Enumerate();
        const std::string text = arguments.isJson ? DevicesJson(devices) : DescribeDevices(devices);
        std::fputs(text.c_str(), stdout);
        return;
    }
    if (arguments.isListingExtensions) {
        std::fputs((arguments.isJson ? ExtensionsJson() : DescribeExtensions()).c_str(), stdout);
        return;
    }
    const SceneInput input = LoadInput(arguments.scene, {.scene = arguments.sceneChoice,
                                                         .variant = arguments.variant,
                                                         .pointsAndLines = arguments.pointsAndLines,
                                                         .root = arguments.root,
                                                         .log = console.log.ForLibraries()});
    if (arguments.isJson) {
        std::fputs(SceneJson(input).c_str(), stdout);
        return;
    }
    std::fputs(DescribeScene(input.file, input.data).c_str(), stdout);
    std::fputs(DescribeAnimations(input.animations).c_str(), stdout);
}

}  // namespace raygraph::cli

// raygraph edit: the editor in a window, or played from a script.
#pragma once

#include <filesystem>
#include <string>

namespace raygraph::editor {

struct EditOptions {
    std::filesystem::path scene;    // "": opens empty
    std::filesystem::path script;   // "": a window; else no window, and what the script says
    std::filesystem::path shaders;  // folder of sources to reload from; "": none
    std::string device;             // as of rhi::DeviceDesc::select
    bool isValidating = false;
};

// Until the user leaves, or the script ends. Error{NoDevice} without a display or a device, Error{BadInput}
// for a script that is malformed or whose expectation does not hold, Error{Vulkan} for a validation message.
void RunEditor(const EditOptions& options);

}  // namespace raygraph::editor

// The JSON of `info` for scripts (schema 1), pretty-printed, with a newline at the end. Lists are complete,
// whereas the text is limited to their beginning.
#pragma once

#include <span>
#include <string>

#include "editor/session/settings/scene_input.h"
#include "rhi/device.h"

namespace raygraph::cli {

std::string SceneJson(const session::SceneInput& input);
std::string DevicesJson(std::span<const rhi::DeviceReport> devices);
std::string ExtensionsJson();

}  // namespace raygraph::cli

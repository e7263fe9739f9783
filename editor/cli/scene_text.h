// The content of a scene as text for people.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "editor/session/settings/scene_input.h"
#include "renderer/scene/model/camera_view.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::cli {

// Returns several lines: counts, size, cameras, lights and materials. Long lists are cut off.
std::string DescribeScene(std::string_view file, const scene::SceneData& scene);

// Returns the camera that frames the scene in a picture of the default size.
scene::CameraView FramedView(const scene::SceneData& scene);

// Returns names and lengths, each on a line with its index; "" if there are none.
std::string DescribeAnimations(std::span<const session::AnimationLength> animations);

// Lists the known glTF extensions: whether they are read, and their effect or the reason.
std::string DescribeExtensions();

// Groups digits: "1,234,567".
std::string GroupDigits(uint64_t number);

}  // namespace raygraph::cli

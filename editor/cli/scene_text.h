// What is in a scene, as text for people.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "editor/session/scene_input.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::cli {

// Counts, size, cameras, lights and materials; several lines. Of long lists the beginning is shown.
std::string DescribeScene(std::string_view file, const scene::SceneData& scene);

// Their names and lengths, each on a line with its index; "" without any.
std::string DescribeAnimations(std::span<const session::AnimationLength> animations);

// The glTF extensions that are known: whether they are read, and what becomes of them or why not.
std::string DescribeExtensions();

// "1,234,567"
std::string GroupDigits(uint64_t number);

}  // namespace raygraph::cli

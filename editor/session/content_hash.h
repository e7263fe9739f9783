// Hashes to detect that a scene or a map is still the one of a render. Not for security. Threads: pure
// functions.
#pragma once

#include <string>

#include "base/api.h"
#include "renderer/image/image.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::session {

// Sixteen hexadecimal digits: XXH3 of all that a picture of any view and any settings can depend on. That
// includes the names of materials, lights, nodes and cameras, by which options choose, and leaves out other
// names and the warnings.
RAYGRAPH_API std::string HashOf(const scene::SceneData& scene);
RAYGRAPH_API std::string HashOf(const image::ImageF& image);

}  // namespace raygraph::session

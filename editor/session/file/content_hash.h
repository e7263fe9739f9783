// Hashes scenes and maps, to detect that they differ from those of a render. The hashes are no protection
// against forgery. Threads: pure functions.
#pragma once

#include <string>

#include "base/api.h"
#include "renderer/image/image.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::session {

// Returns sixteen hexadecimal digits: XXH3 of everything that a picture of any view and any settings can
// depend on. It includes the names of materials, lights, nodes and cameras, which options refer to, and
// leaves out other names and the warnings.
RAYGRAPH_API std::string HashOf(const scene::SceneData& scene);
RAYGRAPH_API std::string HashOf(const image::ImageF& image);

}  // namespace raygraph::session

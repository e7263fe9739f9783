// Lower bounds of the values by which a material's alpha is multiplied. Where the product is opaque, no ray
// needs an alpha test. Threads: pure functions.
#pragma once

#include <span>
#include <vector>

#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// Returns the lowest alpha of a primitive's vertex colors; 1 without colors.
float LowestAlpha(std::span<const glm::vec4> colors);

// Returns the lowest alpha of each material's base color texture; 1 without a texture. Each image must have
// its texels or a known LowestAlpha(), which this call also makes known.
std::vector<float> LowestTextureAlphas(scene::SceneData& scene);

}  // namespace raygraph

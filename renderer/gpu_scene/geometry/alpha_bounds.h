// The lowest alpha of what a material's alpha is multiplied with: where the product stays opaque, no ray
// needs an alpha test. Threads: pure functions.
#pragma once

#include <span>
#include <vector>

#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// Of a primitive's vertex colors; 1 without.
float LowestAlpha(std::span<const glm::vec4> colors);

// Of each material's base color texture; 1 without. Images have their texels, or LowestAlpha() is known, as
// it is from then on.
std::vector<float> LowestTextureAlphas(scene::SceneData& scene);

}  // namespace raygraph

// Reads the textures of a scene on the host as samplers do. Threads: pure functions.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// Returns which of the `size` texels in a row is at coordinate `x` of the endless texture.
uint32_t WrapTexel(int64_t x, uint32_t size, scene::WrapMode mode);

// Returns the color at `uv`, decoded to linear values, and alpha. Both are interpolated between the four
// nearest texels of the largest level, also where the filter of the sampler is Nearest. They are 0 where
// `uv` is not finite or beyond 1e15 texels. `image` belongs to the texture, and has its texels.
glm::vec4 LookUp(const scene::Texture& texture, const scene::ImageData& image, const glm::vec2& uv);

}  // namespace raygraph

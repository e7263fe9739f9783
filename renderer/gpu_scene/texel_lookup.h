// Texels of a scene's textures, read on the host as samplers read them. Threads: pure functions.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "renderer/scene/scene_data.h"

namespace raygraph {

// The texel that coordinate `x` of the endless texture shows, of `size` in a row.
uint32_t WrapTexel(int64_t x, uint32_t size, scene::WrapMode mode);

// The color at `uv`, decoded to linear values, and alpha. It is interpolated between the four nearest texels
// of the largest level, also where the sampler's filter is Nearest. It is 0 where `uv` is not finite or beyond
// 1e15 texels. `image` is that of the texture, and has its texels.
glm::vec4 LookUp(const scene::Texture& texture, const scene::ImageData& image, const glm::vec2& uv);

}  // namespace raygraph

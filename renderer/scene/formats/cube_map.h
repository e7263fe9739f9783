// Cube maps of radiance, as the environments that the renderer has: equirectangular. Internal to
// renderer/scene. Threads: pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>

#include "renderer/image/image.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Six square pictures of one size, +x, -x, +y, -y, +z, -z, each as seen from inside the cube, not mirrored:
// the picture of +x is centered at the direction +x, its top towards +y and its right towards +z. Those of
// +y and -y have -z and +z at the top, and both -x at the right.
struct CubeMap {
    std::array<const ImageData*, 6> faces{};
    float intensity = 1.0f;                      // factor on all of it
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};  // Turns the map: +x is then where rotation * +x points.
};

// Returns the radiance of a texel of a face: rgb are sRGB, and the linear values are divided by alpha (RGBD),
// which counts as at least 1 / 255. For an opaque texel this is its color.
glm::vec3 FaceRadiance(const uint8_t* rgba);

// The rows of the map that a cube with faces of so many texels a side becomes; it has twice as many columns.
uint32_t EquirectHeight(uint32_t faceSize);

// Returns a texel of the face scaled down to `size` texels a side: the mean over its solid angle.
glm::vec3 MeanRadiance(const ImageData& face, uint32_t size, uint32_t column, uint32_t row);

// Returns the map: a texel is the mean radiance over its solid angle, where a texel of a face has one
// radiance. So no light is lost, however small the sun is. Faces finer than the map can show are made smaller
// before. On that many threads; the same for any number. The time grows with the texels that are drawn, where
// one counts again for each part of the map that is drawn by itself.
image::ImageF ToEquirect(const CubeMap& cube, unsigned threads, uint64_t* drawnTexels = nullptr);

}  // namespace raygraph::scene

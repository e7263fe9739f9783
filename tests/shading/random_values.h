// Values for tests, uniformly distributed.
#pragma once

#include <random>

#include "renderer/image/image.h"
#include "tests/shading/light_scene.h"

namespace raygraph::shading {

inline float Uniform(std::mt19937& random) {
    return float(random() >> 8) * 0x1p-24f;
}

// Returns a point in a cube about the origin.
inline vec3 PointIn(std::mt19937& random, float halfSize) {
    return halfSize * (2.0f * vec3(Uniform(random), Uniform(random), Uniform(random)) - 1.0f);
}

inline vec3 DirectionIn(std::mt19937& random) {
    return SampleUniformSphere(vec2(Uniform(random), Uniform(random)));
}

inline image::ImageF RandomMap(uint32_t width, uint32_t height, std::mt19937& random) {
    image::ImageF map{.width = width, .height = height, .rgba = {}};
    for (uint32_t i = 0; i < 4 * width * height; ++i) map.rgba.push_back(float(random() % 1000) * 0.001f);
    return map;
}

}  // namespace raygraph::shading

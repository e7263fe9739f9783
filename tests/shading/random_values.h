// Values for tests, uniformly distributed.
#pragma once

#include <cmath>
#include <random>

#include "core/glue.h"
#include "renderer/image/image.h"

namespace raygraph::shading {

inline vec3 DirectionAt(float cosTheta, float phi) {
    const float sinTheta = std::sqrt(1.0f - cosTheta * cosTheta);
    return {sinTheta * std::cos(phi), sinTheta * std::sin(phi), cosTheta};
}

// Uniform numbers of 24 bits.
class Uniform {
  public:
    explicit Uniform(uint32_t seed) : m_generator(seed) {}
    float operator()() { return static_cast<float>(m_generator() >> 8) * 0x1p-24f; }
    vec2 Pair() {
        const float x = (*this)();
        return {x, (*this)()};
    }
    vec3 Direction() {
        const float z = 2.0f * (*this)() - 1.0f;
        return DirectionAt(z, 6.2831853f * (*this)());
    }

  private:
    std::mt19937 m_generator;
};

// Returns a point in a cube about the origin.
inline vec3 PointIn(Uniform& uniform, float halfSize) {
    const float x = uniform(), y = uniform();
    return halfSize * (2.0f * vec3(x, y, uniform()) - 1.0f);
}

inline image::ImageF RandomMap(uint32_t width, uint32_t height, Uniform& uniform) {
    image::ImageF map{.width = width, .height = height, .rgba = {}};
    for (uint32_t i = 0; i < 4 * width * height; ++i)
        map.rgba.push_back(std::floor(1000.0f * uniform()) * 0.001f);
    return map;
}

}  // namespace raygraph::shading

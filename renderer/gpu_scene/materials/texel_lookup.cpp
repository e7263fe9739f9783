#include "renderer/gpu_scene/materials/texel_lookup.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raygraph {

namespace {

float DecodeSrgb(uint8_t value) {
    static const std::array<float, 256> kTable = [] {
        std::array<float, 256> table{};
        for (size_t i = 0; i < table.size(); ++i) {
            const double v = static_cast<double>(i) / 255.0;
            table[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
        }
        return table;
    }();
    return kTable[value];
}

glm::vec4 Texel(const scene::ImageData& image, uint32_t x, uint32_t y, bool isSrgb) {
    const uint8_t* rgba = &image.rgba[4 * (size_t{y} * image.width + x)];
    glm::vec4 color;
    for (int c = 0; c < 4; ++c)
        color[c] = isSrgb && c < 3 ? DecodeSrgb(rgba[c]) : static_cast<float>(rgba[c]) / 255.0f;
    return color;
}

}  // namespace

uint32_t WrapTexel(int64_t x, uint32_t size, scene::WrapMode mode) {
    const auto n = static_cast<int64_t>(size);
    if (mode == scene::WrapMode::ClampToEdge) return static_cast<uint32_t>(std::clamp<int64_t>(x, 0, n - 1));
    const int64_t period = mode == scene::WrapMode::Repeat ? n : 2 * n;
    const int64_t within = (x % period + period) % period;
    return static_cast<uint32_t>(within < n ? within : period - 1 - within);
}

glm::vec4 LookUp(const scene::Texture& texture, const scene::ImageData& image, const glm::vec2& uv) {
    const double x = double{uv.x} * image.width - 0.5, y = double{uv.y} * image.height - 0.5;
    if (!(std::abs(x) < 1e15 && std::abs(y) < 1e15)) return glm::vec4(0.0f);
    const auto column = static_cast<int64_t>(std::floor(x)), row = static_cast<int64_t>(std::floor(y));
    const auto at = [&](int64_t dx, int64_t dy) {
        return Texel(image, WrapTexel(column + dx, image.width, texture.sampler.wrapU),
                     WrapTexel(row + dy, image.height, texture.sampler.wrapV),
                     texture.colorSpace == scene::ColorSpace::Srgb);
    };
    const auto shareX = static_cast<float>(x - std::floor(x)), shareY = static_cast<float>(y - std::floor(y));
    return glm::mix(glm::mix(at(0, 0), at(1, 0), shareX), glm::mix(at(0, 1), at(1, 1), shareX), shareY);
}

}  // namespace raygraph

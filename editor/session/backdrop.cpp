#include "editor/session/backdrop.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <vector>

#include "renderer/scene/model/studio.h"
#include "shaders/core/color.glsl"

namespace raygraph::session {

namespace {

using std::numbers::pi;
constexpr double kTexelsPerDeviation = 2.0;  // of the blurred map; between them it is interpolated
constexpr double kBlurReach = 3.0;           // deviations; beyond them the weight is below 0.012

glm::dvec3 TexelOf(const image::ImageF& map, uint32_t x, uint32_t y) {
    const float* texel = &map.rgba[4 * (size_t{y} * map.width + x)];
    return {texel[0], texel[1], texel[2]};
}

void SetTexel(image::ImageF& map, uint32_t x, uint32_t y, const glm::dvec3& value) {
    float* texel = &map.rgba[4 * (size_t{y} * map.width + x)];
    for (int c = 0; c < 3; ++c) texel[c] = static_cast<float>(value[c]);
    texel[3] = 1.0f;
}

image::ImageF EmptyMap(uint32_t width, uint32_t height) {
    return {width, height, std::vector<float>(size_t{4} * width * height)};
}

// The solid angle of a texel, but for a factor that is the same for all.
double SolidAngle(uint32_t height, uint32_t y) {
    return std::cos(pi * y / height) - std::cos(pi * (y + 1.0) / height);
}

// Returns the map with no more than `width` columns; texels are means over their solid angle.
image::ImageF Reduced(const image::ImageF& map, uint32_t width) {
    width = std::min(width, map.width);
    const uint32_t height = std::clamp(width / 2, 1u, map.height);
    std::vector<glm::dvec3> sums(size_t{width} * height, glm::dvec3(0.0));
    std::vector<double> weights(sums.size(), 0.0);
    for (uint32_t y = 0; y < map.height; ++y) {
        const double weight = SolidAngle(map.height, y);
        const size_t row = size_t{width} * (uint64_t{y} * height / map.height);
        for (uint32_t x = 0; x < map.width; ++x) {
            const size_t at = row + uint64_t{x} * width / map.width;
            sums[at] += weight * TexelOf(map, x, y);
            weights[at] += weight;
        }
    }
    image::ImageF reduced = EmptyMap(width, height);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            SetTexel(reduced, x, y, sums[size_t{y} * width + x] / weights[size_t{y} * width + x]);
    return reduced;
}

image::ImageF Blurred(const image::ImageF& map, double deviation) {
    const auto columns = static_cast<uint32_t>(std::ceil(2.0 * pi * kTexelsPerDeviation / deviation));
    const image::ImageF from = Reduced(map, std::max(columns, 16u));
    const uint32_t width = from.width, height = from.height;
    const double reach = kBlurReach * deviation;
    const auto polar = [&](uint32_t y) { return pi * (y + 0.5) / height; };
    image::ImageF blurred = EmptyMap(width, height);
    for (uint32_t y = 0; y < height; ++y) {
        const double theta = polar(y);
        // Within reach of a pole, all columns are; else the farthest is where a circle touches a meridian
        const bool hasPole = reach >= std::min(theta, pi - theta);
        const double span = hasPole ? pi : std::asin(std::sin(reach) / std::sin(theta));
        const auto across =
            static_cast<int>(std::min(std::ceil(span / (2.0 * pi) * width), std::floor(0.5 * (width - 1.0))));
        std::vector<glm::dvec3> sums(width, glm::dvec3(0.0));
        double weights = 0.0;
        for (uint32_t row = 0; row < height; ++row) {
            const double rowTheta = polar(row);
            if (std::abs(rowTheta - theta) > reach) continue;
            for (int dx = -across; dx <= across; ++dx) {
                const double cosine = std::cos(theta) * std::cos(rowTheta) +
                                      std::sin(theta) * std::sin(rowTheta) * std::cos(2.0 * pi * dx / width);
                const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
                if (angle > reach) continue;
                const double weight =
                    SolidAngle(height, row) * std::exp(-0.5 * angle * angle / (deviation * deviation));
                weights += weight;
                for (uint32_t x = 0; x < width; ++x)
                    sums[x] += weight * TexelOf(from, (x + width + static_cast<uint32_t>(dx)) % width, row);
            }
        }
        for (uint32_t x = 0; x < width; ++x) SetTexel(blurred, x, y, sums[x] / weights);
    }
    return blurred;
}

float Encoded(double linear) {
    return shading::SrgbEncode(static_cast<float>(std::clamp(linear, 0.0, 1.0)));
}

// `behind` returns the linear value behind a number of the picture, by its index.
template <typename Behind>
image::Image8 OverAny(const image::Image8& picture, Behind&& behind) {
    std::array<double, 256> linear{};
    for (size_t i = 0; i < linear.size(); ++i)
        linear[i] = double{shading::SrgbDecode(static_cast<float>(i) / 255.0f)};
    image::Image8 over{picture.width, picture.height, picture.rgba};
    for (size_t i = 0; i < over.rgba.size(); i += 4) {
        const double alpha = picture.rgba[i + 3] / 255.0;
        over.rgba[i + 3] = 255;
        if (alpha == 1.0) continue;
        for (size_t c = 0; c < 3; ++c) {
            const double mixed = alpha * linear[picture.rgba[i + c]] + (1.0 - alpha) * behind(i + c, linear);
            over.rgba[i + c] = static_cast<uint8_t>(std::lround(255.0f * Encoded(mixed)));
        }
    }
    return over;
}

}  // namespace

std::optional<image::ImageF> BackdropMap(const SceneInput& input, const PictureSettings& settings,
                                         float degrees) {
    image::ImageF studio;
    const image::ImageF* map = nullptr;
    if (!input.environment.rgba.empty())
        map = &input.environment;
    else if (settings.background)
        return std::nullopt;
    else if (settings.light == DefaultLight::Studio)
        map = &(studio = scene::StudioMap());
    else if (input.data.environment.IsPresent())
        map = &input.data.environment.map;
    if (map == nullptr) return std::nullopt;
    image::ImageF shown = degrees > 0.0f ? Blurred(*map, glm::radians(double{degrees})) : *map;
    for (size_t i = 0; i < shown.rgba.size(); ++i)
        if (i % 4 != 3) shown.rgba[i] *= settings.environmentTint[i % 4];
    return shown;
}

image::ImageF SeenOf(const image::ImageF& map, float rotation, const gpu::CameraRecord& camera, Extent2D size,
                     const passes::Region& part) {
    image::ImageF seen = EmptyMap(part.width, part.height);
    const glm::dvec3 right(camera.right), up(camera.up), forward(camera.forward);
    for (uint32_t y = 0; y < part.height; ++y)
        for (uint32_t x = 0; x < part.width; ++x) {
            const double filmX = 2.0 * (part.x + x + 0.5) / size.width - 1.0,
                         filmY = 1.0 - 2.0 * (part.y + y + 0.5) / size.height;
            const glm::dvec3 d = camera.orthographic != 0 ? forward : forward + filmX * right + filmY * up;
            const double turns = 0.5 + (std::atan2(d.z, d.x) + double{rotation}) / (2.0 * pi);
            const double v = std::atan2(std::hypot(d.x, d.z), d.y) / pi;
            const double column = (turns - std::floor(turns)) * map.width - 0.5, row = v * map.height - 0.5;
            const auto x0 = static_cast<int64_t>(std::floor(column));
            const auto y0 = static_cast<int64_t>(std::floor(row));
            const double fx = column - static_cast<double>(x0), fy = row - static_cast<double>(y0);
            // Beyond a pole is the row on its other side
            const auto at = [&](int64_t i, int64_t j) {
                const bool isBeyond = j < 0 || j >= map.height;
                const int64_t turned = isBeyond ? i + map.width / 2 : i;
                return TexelOf(map, static_cast<uint32_t>((turned + map.width) % map.width),
                               static_cast<uint32_t>(std::clamp<int64_t>(j, 0, map.height - 1)));
            };
            SetTexel(seen, x, y,
                     (1.0 - fy) * ((1.0 - fx) * at(x0, y0) + fx * at(x0 + 1, y0)) +
                         fy * ((1.0 - fx) * at(x0, y0 + 1) + fx * at(x0 + 1, y0 + 1)));
        }
    return seen;
}

image::Image8 Over(const image::Image8& picture, const image::Image8& behind) {
    return OverAny(picture, [&](size_t i, const auto& linear) { return linear[behind.rgba[i]]; });
}

image::Image8 Over(const image::Image8& picture, const std::array<float, 3>& color) {
    return OverAny(picture, [&](size_t i, const auto&) { return double{color[i % 4]}; });
}

}  // namespace raygraph::session

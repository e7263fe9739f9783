#include "renderer/scene/model/studio.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "renderer/scene/model/camera_view.h"

namespace raygraph::scene {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kWidth = 256, kHeight = 128;

// Describes a luminous rectangle that stands upright and faces the scene, in units of its distance. Angles in
// degrees: azimuth from +z towards +x, elevation above the horizon.
struct SoftBox {
    double azimuth, elevation;
    double halfWidth, halfHeight;  // tangents of angles
    double edge;                   // width of the soft border inside, as a share of the halves
    double radiance;               // in its middle, before StudioMap scales everything
};

// All but the fill is more than 20 degrees above the horizon, where level cameras do not see it.
constexpr SoftBox kKey{-22.0, 46.0, 0.62, 0.38, 0.55, 8.0};
constexpr SoftBox kFill{98.0, 14.0, 1.0, 0.75, 1.0, 1.2};
constexpr SoftBox kBackRim{158.0, 58.0, 0.5, 0.2, 0.6, 5.0};
constexpr SoftBox kSideRim{-108.0, 52.0, 0.16, 0.4, 0.6, 7.0};
// These are the radiances of the backdrop below, at the horizon and above.
constexpr double kFloor = 0.42, kHorizon = 0.58, kCeiling = 0.38;

double SmoothStep(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

double RadianceOf(const SoftBox& box, const glm::dvec3& direction) {
    const double azimuth = glm::radians(box.azimuth), elevation = glm::radians(box.elevation);
    const glm::dvec3 right(std::cos(azimuth), 0.0, -std::sin(azimuth));
    const glm::dvec3 middle(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                            std::cos(azimuth) * std::cos(elevation));
    const double depth = glm::dot(direction, middle);
    if (depth <= 0.0) return 0.0;
    const double x = std::abs(glm::dot(direction, right)) / (depth * box.halfWidth);
    const double y = std::abs(glm::dot(direction, glm::cross(middle, right))) / (depth * box.halfHeight);
    return box.radiance * SmoothStep(1.0, 1.0 - box.edge, x) * SmoothStep(1.0, 1.0 - box.edge, y);
}

double Backdrop(double up) {
    return up < 0.0 ? std::lerp(kHorizon, kFloor, SmoothStep(0.0, 0.9, -up))
                    : std::lerp(kHorizon, kCeiling, SmoothStep(0.0, 0.9, up));
}

double Radiance(const glm::dvec3& direction) {
    double radiance = Backdrop(direction.y);
    for (const SoftBox& box : {kKey, kFill, kBackRim, kSideRim}) radiance += RadianceOf(box, direction);
    return radiance;
}

// Returns the direction that the texel's middle shows, as shaders/core/equirect.glsl maps it.
glm::dvec3 DirectionOf(uint32_t x, uint32_t y) {
    const double longitude = 2.0 * kPi * ((x + 0.5) / kWidth - 0.5), polar = kPi * (y + 0.5) / kHeight;
    return {std::sin(polar) * std::cos(longitude), std::cos(polar), std::sin(polar) * std::sin(longitude)};
}

// Returns the mean radiance over the disc of a white Lambert ball, per steradian of light of radiance 1 that
// comes at this angle to the direction of view: the phase function of a Lambert sphere (Schoenberg 1929),
// whose integral over all directions is 1.
double ShareOfBall(double cosine) {
    const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
    return 2.0 / (3.0 * kPi * kPi) * (std::sin(angle) + (kPi - angle) * std::cos(angle));
}

}  // namespace

image::ImageF StudioMap() {
    image::ImageF map{.width = kWidth, .height = kHeight, .rgba = {}};
    map.rgba.resize(size_t{4} * kWidth * kHeight);
    const glm::dvec3 toEye = -glm::dvec3(ViewOfBounds({}, 1.0f).forward);
    double ball = 0.0;
    for (uint32_t y = 0; y < kHeight; ++y) {
        const double solidAngle =
            2.0 * kPi / kWidth * (std::cos(kPi * y / kHeight) - std::cos(kPi * (y + 1.0) / kHeight));
        for (uint32_t x = 0; x < kWidth; ++x) {
            const glm::dvec3 direction = DirectionOf(x, y);
            const double radiance = Radiance(direction);
            ball += solidAngle * radiance * ShareOfBall(glm::dot(direction, toEye));
            float* texel = &map.rgba[4 * (size_t{y} * kWidth + x)];
            std::fill(texel, texel + 3, static_cast<float>(radiance));
            texel[3] = 1.0f;
        }
    }
    for (size_t i = 0; i < map.rgba.size(); ++i)
        if (i % 4 != 3) map.rgba[i] = static_cast<float>(map.rgba[i] / ball);
    return map;
}

}  // namespace raygraph::scene

#include "renderer/gpu_scene/lights/light_bounds.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace raygraph {

namespace {

// Computes the narrowest cone around both: Conty Estevez and Kulla 2018, algorithm 1.
void UniteAxes(LightBounds& a, const LightBounds& b) {
    const double cosine = std::clamp(glm::dot(a.axis, b.axis), -1.0, 1.0);
    const double between = std::acos(cosine);
    if (std::min(between + b.thetaO, std::numbers::pi) <= a.thetaO) return;
    if (std::min(between + a.thetaO, std::numbers::pi) <= b.thetaO) {
        a.axis = b.axis;
        a.thetaO = b.thetaO;
        return;
    }
    const double theta = 0.5 * (a.thetaO + between + b.thetaO);
    const glm::dvec3 across = b.axis - cosine * a.axis;  // perpendicular to a, towards b
    const double length = glm::length(across);
    if (theta >= std::numbers::pi || length < 1e-12) {
        a.thetaO = std::numbers::pi;
        return;
    }
    const double turn = theta - a.thetaO;
    a.axis = glm::normalize(std::cos(turn) * a.axis + std::sin(turn) / length * across);
    a.thetaO = theta;
}

// Rounds to 16 bits, to a wider angle and one step more, so that a rounding error excludes no light.
int16_t WidenedCosine(double angle) {
    return static_cast<int16_t>(
        std::max(std::floor(std::cos(std::min(angle, std::numbers::pi)) * 32767.0) - 1.0, -32767.0));
}

}  // namespace

LightBox BoxOf(const gpu::LightRecord& light) {
    LightBox box{light.p0, light.p0};
    if (light.kind != gpu::kLightTriangle) return box;
    for (const glm::vec3& corner : {light.p0 + light.e1, light.p0 + light.e2}) {
        box.min = glm::min(box.min, corner);
        box.max = glm::max(box.max, corner);
    }
    return box;
}

LightBounds BoundsOf(const gpu::LightRecord& light, float power) {
    const LightBox box = BoxOf(light);
    LightBounds bounds;
    bounds.power = power;
    bounds.min = box.min;
    bounds.max = box.max;
    bounds.thetaE = 0.5 * std::numbers::pi;
    if (light.kind == gpu::kLightTriangle) {
        bounds.axis = glm::normalize(glm::cross(glm::dvec3(light.e1), glm::dvec3(light.e2)));
        if ((light.flags & gpu::kLightMirrored) != 0) bounds.axis = -bounds.axis;
        bounds.isTwoSided = (light.flags & gpu::kLightDoubleSided) != 0;
    } else if (light.kind == gpu::kLightPoint) {
        bounds.thetaO = std::numbers::pi;
    } else {
        const double offset = light.spotOffsetOrClearance, scale = light.spotScale;
        const double outer = std::acos(std::clamp(-offset / scale, -1.0, 1.0));
        bounds.axis = glm::normalize(glm::dvec3(light.e1));
        bounds.thetaO = std::acos(std::clamp((1.0 - offset) / scale, -1.0, 1.0));
        bounds.thetaE = outer - bounds.thetaO;
    }
    return bounds;
}

void Unite(LightBounds& a, const LightBounds& b) {
    if (b.IsEmpty()) return;
    if (a.IsEmpty()) {
        a = b;
        return;
    }
    a.min = glm::min(a.min, b.min);
    a.max = glm::max(a.max, b.max);
    UniteAxes(a, b);
    a.thetaE = std::max(a.thetaE, b.thetaE);
    a.power += b.power;
    a.isTwoSided |= b.isTwoSided;
}

double Cost(const LightBounds& bounds) {
    const double o = bounds.thetaO;
    const double w = std::min(o + bounds.thetaE, std::numbers::pi);
    double directions =
        2.0 * std::numbers::pi * (1.0 - std::cos(o)) +
        0.5 * std::numbers::pi *
            (2.0 * w * std::sin(o) - std::cos(o - 2.0 * w) - 2.0 * o * std::sin(o) + std::cos(o));
    if (bounds.isTwoSided) directions *= 2.0;
    const glm::dvec3 d(bounds.max - bounds.min);
    const double places = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x) + glm::dot(d, d);
    return bounds.power * directions * places;
}

gpu::LightNode NodeOf(const LightBounds& bounds, uint32_t link) {
    const auto o = static_cast<uint16_t>(WidenedCosine(bounds.thetaO));
    const auto e = static_cast<uint16_t>(WidenedCosine(bounds.thetaE));
    return {.boundsMin = bounds.min,
            .power = static_cast<float>(bounds.power),
            .boundsMax = bounds.max,
            .link = link | (bounds.isTwoSided ? gpu::kLightNodeTwoSided : 0u),
            .axis = glm::vec3(bounds.axis),
            .cones = o | (uint32_t{e} << 16u)};
}

}  // namespace raygraph

// Bounds of lights in position, direction and power, as the nodes of a light tree store them. A. Conty
// Estevez and C. Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting". Threads: pure
// functions.
#pragma once

#include <glm/glm.hpp>
#include <limits>

#include "shaders/shared/light_records.h"

namespace raygraph {

// Bounds of lights: their box, and their emission within thetaE about directions within thetaO of the axis.
struct LightBounds {
    glm::vec3 min{std::numeric_limits<float>::infinity()};
    glm::vec3 max{-std::numeric_limits<float>::infinity()};
    glm::dvec3 axis{0.0, 0.0, 1.0};
    double thetaO = 0.0;
    double thetaE = 0.0;
    double power = 0.0;  // luminance, W
    bool isTwoSided = false;

    bool IsEmpty() const { return power == 0.0; }
};

// Returns the bounds of a triangle, point or spot light with that power.
LightBounds BoundsOf(const gpu::LightRecord& light, float power);

// Describes a box around a light, for each kind of light that has a record.
struct LightBox {
    glm::vec3 min, max;
};
LightBox BoxOf(const gpu::LightRecord& light);

void Unite(LightBounds& bounds, const LightBounds& other);

// Returns power times the measure of the directions times that of the positions. The latter uses the
// diagonal, since boxes without area (points in a row) still differ in extent.
double Cost(const LightBounds& bounds);

// Its cones are rounded to wider angles.
gpu::LightNode NodeOf(const LightBounds& bounds, uint32_t link);

}  // namespace raygraph

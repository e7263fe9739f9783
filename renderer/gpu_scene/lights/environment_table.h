// The environment's importance: a table over the cells of its equirectangular map, to be inverted.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "renderer/image/image.h"
#include "shaders/shared/environment_entries.h"

namespace raygraph {

struct EnvironmentTable {
    uint32_t width = 1, height = 1;              // cells
    std::vector<gpu::EnvironmentEntry> entries;  // the rows, then the cells of each row
    glm::vec3 meanRadiance{1.0f};                // of the map over the sphere, linear Rec. 709
};

inline constexpr uint64_t kMaxEnvironmentCells = uint64_t{1} << 22;

// Error{Usage} for a map without texels, or with values that are negative or not finite.
void RequireRadiance(const image::ImageF& map);

// A cell is a texel, or a square of 2^k x 2^k where the map is larger than `maxCells` and its size allows.
// Its weight is the luminance of its texels above half of the map's mean, times solid angle, of the map as a
// sampler interpolates it (bilinear, repeated in u, clamped in v). So directions to the dim part of a map
// have no density: BSDF sampling finds them anyway (Karlik et al. 2019, "MIS Compensation: Optimizing
// Sampling Techniques in Multiple Importance Sampling"). Values of the map are finite and not negative.
// Linear time; needs no device.
EnvironmentTable BuildEnvironmentTable(const image::ImageF& map, uint64_t maxCells = kMaxEnvironmentCells);

// The table of an environment without a map: one cell, uniform over all directions.
EnvironmentTable ConstantEnvironmentTable();

}  // namespace raygraph

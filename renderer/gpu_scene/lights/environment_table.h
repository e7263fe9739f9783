// The importance of the environment: a table over the cells of its equirectangular map, from which directions
// are sampled by inversion. Threads: pure functions.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "renderer/image/image.h"
#include "shaders/shared/environment_entries.h"

namespace raygraph {

struct EnvironmentTable {
    uint32_t width = 1, height = 1;  // cells
    // The marginal entries of the rows, then the cells of each row.
    std::vector<gpu::EnvironmentEntry> entries;
    glm::vec3 meanRadiance{1.0f};  // mean of the map over the sphere, linear Rec. 709
};

inline constexpr uint64_t kMaxEnvironmentCells = uint64_t{1} << 22;

// Throws Error{Usage} for a map without texels, or with values that are negative or not finite.
void RequireRadiance(const image::ImageF& map);

// Builds the table of a map. A cell is a texel, or a square of 2^k x 2^k texels where the map is larger than
// `maxCells` and its size allows. Its weight is the luminance of its texels above half of the map's mean,
// times solid angle, of the map as a sampler interpolates it (bilinear, repeated in u, clamped in v). Hence
// directions to the dim part of a map have no density: BSDF sampling finds them anyway (Karlik et al. 2019,
// "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling"). Values of the map are
// finite and not negative. Takes linear time and needs no device.
EnvironmentTable BuildEnvironmentTable(const image::ImageF& map, uint64_t maxCells = kMaxEnvironmentCells);

// Returns the table of an environment without a map: one cell, uniform over all directions.
EnvironmentTable ConstantEnvironmentTable();

}  // namespace raygraph

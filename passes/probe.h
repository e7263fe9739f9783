// Probe: means and variances of a few pixels, to be read back. Threads: that of the Renderer.
#pragma once

#include <glm/glm.hpp>

#include "base/api.h"
#include "passes/accumulate.h"

namespace raygraph::passes {

// An element of the buffer: zeros for a pixel without samples, and no variance below two samples.
struct ProbedTexels {
    glm::vec4 mean;
    glm::vec4 variance;
};

// One ProbedTexels for each of `grid` pixels that are spread evenly over `region`, row by row, from the sums
// of samples that were accumulated with variance. `progress` is that of the samples. Error{Usage} for a
// region that is not within the picture, and for a grid of more pixels than the region has.
[[nodiscard]] RAYGRAPH_API BufferId Probe(Renderer& renderer, const AccumulatedIds& samples,
                                          const Accumulation::Progress& progress, const Region& region,
                                          Extent2D grid = {1, 1});

}  // namespace raygraph::passes

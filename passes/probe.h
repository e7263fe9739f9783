// Probe: means and variances of a few pixels, to be read back. Threads: that of the Renderer.
#pragma once

#include <glm/glm.hpp>

#include "base/api.h"
#include "passes/accumulate.h"

namespace raygraph::passes {

// Describes an element of the buffer: zeros for a pixel without samples; the variance is 0 below two samples.
struct ProbedPixel {
    glm::vec4 mean;
    glm::vec4 variance;
};

// Returns a ProbedPixel for one pixel of each cell of a `grid` over `region`, row by row, at a quasi-random
// place in the cell, from the sums of samples that were accumulated with variance. `progress` is that of the
// samples. Error{Usage} for a region that is not within the picture, and for a grid that is empty, wider or
// higher than the region.
[[nodiscard]] RAYGRAPH_API BufferId Probe(Renderer& renderer, const AccumulatedIds& samples,
                                          const Accumulation::Progress& progress, const Region& region,
                                          Extent2D grid = {1, 1});

}  // namespace raygraph::passes

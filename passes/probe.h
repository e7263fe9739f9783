// Probe: one texel of two pictures, to be read back. Threads: that of the Renderer.
#pragma once

#include <glm/glm.hpp>

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// What the buffer holds.
struct ProbedTexels {
    glm::vec4 mean;
    glm::vec4 variance;
};

// One ProbedTexels of a mean and a variance as Accumulate gives them: rgba32f of one extent. Error{Usage} for
// others, and for a pixel outside of them.
[[nodiscard]] RAYGRAPH_API BufferId Probe(Renderer& renderer, TextureId mean, TextureId variance,
                                          glm::uvec2 pixel);

// The same for pixels that are spread evenly over the pictures, `grid` of them, row by row: for an estimate
// of the whole. At most one a pixel: of a smaller picture, every pixel.
[[nodiscard]] RAYGRAPH_API BufferId ProbeGrid(Renderer& renderer, TextureId mean, TextureId variance,
                                              Extent2D grid);

}  // namespace raygraph::passes

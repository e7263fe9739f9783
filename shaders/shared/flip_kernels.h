// The filters of FLIP, one-dimensional and symmetric: taps 0 to the radius. Scalar layout.
#ifndef RAYGRAPH_SHARED_FLIP_KERNELS_H
#define RAYGRAPH_SHARED_FLIP_KERNELS_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::vec2;
using glm::vec4;
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

RAYGRAPH_CONSTANT uint kFlipTaps = 65u;

struct FlipKernels {
    // Contrast sensitivity: of the luminance, of red-green, and the two Gaussians of blue-yellow. Each sums
    // to 1.
    vec4 color[kFlipTaps];
    // A Gaussian that sums to 1; its first derivative, for taps to the right, whose weights sum to 1; its
    // second, whose positive weights sum to 1 and whose negative ones to -1.
    vec4 feature[kFlipTaps];
    vec2 blueYellow;  // what each of its Gaussians counts
    uint colorRadius;
    uint featureRadius;
};

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

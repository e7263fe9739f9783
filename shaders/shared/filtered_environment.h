// The environment map, prefiltered for rough surfaces: levels of equirectangular pictures, one below the
// other. Level i is filtered for a roughness of (i + 1) kFilteredStep, the last one for diffuse surfaces.
// Without rotation and scale, like the map.
#ifndef RAYGRAPH_SHARED_FILTERED_ENVIRONMENT_H
#define RAYGRAPH_SHARED_FILTERED_ENVIRONMENT_H

#ifdef __cplusplus
#include <cstdint>

namespace raygraph::gpu {
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

RAYGRAPH_CONSTANT uint kFilteredWidth = 128u;
RAYGRAPH_CONSTANT uint kFilteredHeight = 64u;  // of a level
RAYGRAPH_CONSTANT uint kFilteredLevels = 6u;
RAYGRAPH_CONSTANT uint kFilteredDiffuse = kFilteredLevels - 1u;
RAYGRAPH_CONSTANT float kFilteredStep = 0.2f;

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

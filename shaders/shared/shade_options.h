// Additional inputs of RasterShade: bits, named once.
#ifndef RAYGRAPH_SHARED_SHADE_OPTIONS_H
#define RAYGRAPH_SHARED_SHADE_OPTIONS_H

#ifdef __cplusplus
#include <cstdint>

namespace raygraph::gpu {
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

RAYGRAPH_CONSTANT uint kShadeOcclusion = 1u;  // occlusion of the environment: passes/raster.h
RAYGRAPH_CONSTANT uint kShadeBehind = 2u;     // the picture behind glass: passes/raster.h

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

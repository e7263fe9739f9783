// Sizes of what the kernels of a wavefront hand on: shaders/pathtrace/wave_state.glsl, passes/wavefront.cpp.
#ifndef RAYGRAPH_SHARED_WAVEFRONT_H
#define RAYGRAPH_SHARED_WAVEFRONT_H

#ifdef __cplusplus
#include <cstdint>
namespace raygraph::gpu {
#define RAYGRAPH_COUNT inline constexpr uint32_t
#else
#define RAYGRAPH_COUNT const uint
#endif

RAYGRAPH_COUNT kWavePathRows = 5u;    // of 16 bytes each
RAYGRAPH_COUNT kWaveShadowRows = 4u;

#undef RAYGRAPH_COUNT
#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

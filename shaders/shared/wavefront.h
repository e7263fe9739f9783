// What the kernels of a wavefront hand on: shaders/pathtrace/wave_state.glsl, passes/wavefront.cpp.
#ifndef RAYGRAPH_SHARED_WAVEFRONT_H
#define RAYGRAPH_SHARED_WAVEFRONT_H

#ifdef __cplusplus
#include <cstdint>

#include <glm/glm.hpp>

namespace raygraph::gpu {
using uint = uint32_t;
using glm::uvec2;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

// Rows of 16 bytes of a path in every scene, and those that come with parts of the radiance, levels of
// textures, and media
RAYGRAPH_CONSTANT uint kWavePathRows = 5u;
RAYGRAPH_CONSTANT uint kWaveLobeRows = 1u;
RAYGRAPH_CONSTANT uint kWaveConeRows = 1u;
RAYGRAPH_CONSTANT uint kWaveMediaRows = 2u;
// Of a shadow ray in every scene, and where it passes from medium to medium; parts add kWaveLobeRows
RAYGRAPH_CONSTANT uint kWaveShadowRows = 4u;
RAYGRAPH_CONSTANT uint kWaveShadowMediaRows = 3u;

// What a launch of pathtrace/wave_trace.rgen traces
RAYGRAPH_CONSTANT uint kWaveTracesPaths = 1u;
RAYGRAPH_CONSTANT uint kWaveTracesShadows = 2u;

struct WaveConstants {
    uvec2 size;         // pixels of the traced region
    uint step;          // rays that the paths have traced before this one
    uint pathRows;      // of a path
    uint isProbedOnce;  // the media of all camera rays are the same
    uint traces;        // kWaveTraces*
};

#undef RAYGRAPH_CONSTANT
#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

// The records that the kernels of a wavefront pass on: shaders/pathtrace/wave_state.glsl,
// passes/wavefront.cpp.
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

// The records of a PathState `path` and of a WaveShadow `shadow`, as lists of their rows of 16 bytes:
// ROW(condition, members). A row is there in pictures where the condition holds. How records are loaded and
// stored, and how many rows they have, follows from the lists. A path begins with what its next ray needs.
#define RAYGRAPH_WAVE_RAY_ROWS(ROW)                      \
    ROW(true, VEC3_UINT(path.ray.origin, path.rayCount)) \
    ROW(true, VEC3_FLOAT(path.ray.direction, path.scatterPDF))
#define RAYGRAPH_WAVE_MEDIA_ROWS(ROW, condition, of)                          \
    ROW(condition, UINTS(of.media.m0, of.media.m1, of.media.m2, of.media.m3)) \
    ROW(condition, VEC3_FLOAT(of.start.normal, of.start.height))
#define RAYGRAPH_WAVE_PATH_ROWS(ROW)                                                          \
    RAYGRAPH_WAVE_RAY_ROWS(ROW)                                                               \
    ROW(true, VEC3_FLOAT(path.throughput, path.etaScale))                                     \
    ROW(true, VEC3_UINT(path.scatter.position, path.depth))                                   \
    ROW(true, VEC3_FLOAT(path.scatter.normal, path.wavelength))                               \
    ROW(HasTraceFeature(kTraceTextureLod), FLOATS(path.ray.cone.width, path.ray.cone.spread)) \
    RAYGRAPH_WAVE_MEDIA_ROWS(ROW, HasTraceFeature(kTraceVolumes), path)                       \
    ROW(KeepsParts(), VEC3_BOOL(path.lobe.diffuse, path.lobe.isThrough))
#define RAYGRAPH_WAVE_SHADOW_ROWS(ROW)                                                         \
    ROW(true, VEC3_FLOAT(shadow.light.ray.origin, shadow.light.distance))                      \
    ROW(true, VEC3_FLOAT(shadow.light.ray.direction, shadow.light.ior))                        \
    ROW(true, VEC3_UINT(shadow.light.radiance, shadow.slot))                                   \
    ROW(true, UINTS(shadow.rayCount, shadow.depth, shadow.light.light, shadow.light.triangle)) \
    ROW(KeepsParts(), VEC3_BOOL(shadow.light.lobe.diffuse, shadow.light.lobe.isThrough))       \
    RAYGRAPH_WAVE_MEDIA_ROWS(ROW, HasTraceFeature(kTraceMatchedMedia), shadow.light)           \
    ROW(HasTraceFeature(kTraceMatchedMedia), FLOAT(shadow.wavelength))

#define RAYGRAPH_WAVE_COUNT_ROW(condition, members) +((condition) ? 1u : 0u)

// The rays that a launch of pathtrace/wave_trace.rgen traces.
RAYGRAPH_CONSTANT uint kWaveTracesPaths = 1u;
RAYGRAPH_CONSTANT uint kWaveTracesShadows = 2u;

struct WaveConstants {
    uvec2 size;         // pixels of the traced region
    uint step;          // rays that the paths have traced before this one
    uint pathRows;      // rows of a path
    uint isProbedOnce;  // the media of all camera rays are the same
    uint traces;        // kWaveTraces*
    uint firstPaths;    // number of paths that the camera starts
};

#undef RAYGRAPH_CONSTANT
#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

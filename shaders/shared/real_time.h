// Records and constants of the passes in passes/real_time.h: one source for C++ and GLSL, scalar layout.
#ifndef RAYGRAPH_SHARED_REAL_TIME_H
#define RAYGRAPH_SHARED_REAL_TIME_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::vec2;
using glm::vec3;
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

// Film holds the frame of a camera and the size of its picture.
struct Film {
    vec3 right;  // those of CameraRecord
    vec3 up;
    vec3 forward;
    uint orthographic;
    vec2 size;  // pixels
};

RAYGRAPH_CONSTANT uint kHandOverBlock = 8u;  // pixels a side
RAYGRAPH_CONSTANT uint kChangeBlock = 8u;    // pixels a side: blocks in which light is compared

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

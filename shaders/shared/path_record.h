// Records of an explained path's vertices (core/record.glsl, passes/trace.h): one source for C++ and GLSL,
// scalar layout.
//
// The buffer begins with the number of the path's vertices; their records follow in their order. The sample's
// value is the sum of `emitted` and then `lit` of each vertex, in this order and in float: to the bit, unless
// it is not finite, which a picture has as 0.
#ifndef RAYGRAPH_SHARED_PATH_RECORD_H
#define RAYGRAPH_SHARED_PATH_RECORD_H

#include "choice.h"
#include "trace_options.h"

// What happens where a ray ends.
//   Environment: it meets no surface
//   Surface:     a BSDF scatters the path, or it ends there
//   Medium:      the medium scatters it before it gets to a surface
//   Straight:    it passes straight through a smooth thin wall or a boundary of one index
//   Ignored:     the surface bounds a medium that does not change there
#define RAYGRAPH_PATH_EVENTS(X, Of)          \
    X(Of, Environment, 0, "environment", "") \
    X(Of, Surface, 1, "surface", "")         \
    X(Of, Medium, 2, "medium", "")           \
    X(Of, Straight, 3, "straight", "")       \
    X(Of, Ignored, 4, "ignored", "")

// Why a path ends at a vertex.
//   None:      it goes on
//   Escaped:   it leaves the scene
//   Depth:     the limit of bounces
//   Unlit:     the material scatters nothing
//   Absorbed:  no lobe has a direction, or its light is 0
//   Leak:      the direction is below the surface: that of the shading normal differs
//   Roulette:  Russian roulette
//   RayLimit:  kMaxRays of trace_options.h
#define RAYGRAPH_PATH_ENDS(X, Of)                          \
    X(Of, None, 0, "", "goes on")                          \
    X(Of, Escaped, 1, "escaped", "leaves the scene")       \
    X(Of, Depth, 2, "depth", "limit of bounces")           \
    X(Of, Unlit, 3, "unlit", "scatters nothing")           \
    X(Of, Absorbed, 4, "absorbed", "nothing is scattered") \
    X(Of, Leak, 5, "leak", "direction below the surface")  \
    X(Of, Roulette, 6, "roulette", "Russian roulette")     \
    X(Of, RayLimit, 7, "ray limit", "limit of rays")

// The lobe from which a direction is drawn: a line for each struct of GLTF_LOBES (bxdf/gltf_lobes.glsl).
//   None: the model of the BSDF has no such lobes (bxdf/bsdf.glsl), or no direction is drawn
#define RAYGRAPH_PATH_LOBES(X, Of)                                \
    X(Of, None, 0, "", "")                                        \
    X(Of, ClearcoatBxDF, 1, "clear coat", "")                     \
    X(Of, SheenBxDF, 2, "sheen", "")                              \
    X(Of, GlassBxDF, 3, "glass", "")                              \
    X(Of, ConductorBxDF, 4, "metal", "")                          \
    X(Of, DielectricLayerBxDF, 5, "dielectric", "")               \
    X(Of, DiffuseTransmissionBxDF, 6, "diffuse transmission", "") \
    X(Of, DiffuseBxDF, 7, "diffuse", "")

// The light of a candidate.
#define RAYGRAPH_PATH_LIGHTS(X, Of)    \
    X(Of, None, 0, "", "")             \
    X(Of, Surface, 1, "surface", "")   \
    X(Of, Punctual, 2, "punctual", "") \
    X(Of, Environment, 3, "environment", "")

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph {
RAYGRAPH_CHOICE(PathEvent, RAYGRAPH_PATH_EVENTS)
RAYGRAPH_CHOICE(PathEnd, RAYGRAPH_PATH_ENDS)
RAYGRAPH_CHOICE(PathLobe, RAYGRAPH_PATH_LOBES)
RAYGRAPH_CHOICE(PathLight, RAYGRAPH_PATH_LIGHTS)
RAYGRAPH_CHOICE_CONSTANTS(PathEvent, RAYGRAPH_PATH_EVENTS)
RAYGRAPH_CHOICE_CONSTANTS(PathEnd, RAYGRAPH_PATH_ENDS)
RAYGRAPH_CHOICE_CONSTANTS(PathLobe, RAYGRAPH_PATH_LOBES)
RAYGRAPH_CHOICE_CONSTANTS(PathLight, RAYGRAPH_PATH_LIGHTS)
}  // namespace raygraph

namespace raygraph::gpu {
using glm::vec2;
using glm::vec3;
using uint = uint32_t;
using PathIndex = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
RAYGRAPH_CHOICE_CONSTANTS(PathEvent, RAYGRAPH_PATH_EVENTS)
RAYGRAPH_CHOICE_CONSTANTS(PathEnd, RAYGRAPH_PATH_ENDS)
RAYGRAPH_CHOICE_CONSTANTS(PathLobe, RAYGRAPH_PATH_LOBES)
RAYGRAPH_CHOICE_CONSTANTS(PathLight, RAYGRAPH_PATH_LIGHTS)
#define PathIndex         uint
#define RAYGRAPH_CONSTANT const
#endif

RAYGRAPH_CONSTANT uint kNoRecord = 0xFFFFFFFFu;
RAYGRAPH_CONSTANT uint kMaxRecordedVertices = kMaxRays;  // each has a ray of its own

struct LightCandidateRecord {
#define RAYGRAPH_CANDIDATE_VALUE(type, name) type name;
#include "path_vertex_list.h"
};

struct PathVertexRecord {
#define RAYGRAPH_PATH_VALUE(type, name) type name;
#include "path_vertex_list.h"
    LightCandidateRecord candidates[kLightCandidates];
    // Two values on their way from a function of the integrator to its caller; the buffer lacks them.
    float lightProbability;
    vec3 collected;
};

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif

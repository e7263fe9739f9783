// The records of the deformation of vertices: one source for C++ and GLSL, scalar layout. Streams are reached
// by device address, as in scene_records.h; 0 means that there is none.
#ifndef RAYGRAPH_SHARED_DEFORM_RECORDS_H
#define RAYGRAPH_SHARED_DEFORM_RECORDS_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::uvec2;
using uint = uint32_t;
#define RAYGRAPH_ADDRESS  uint64_t
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_ADDRESS  uvec2
#define RAYGRAPH_CONSTANT const
#endif

// Vertices that a workgroup deforms; and workgroups in a row of a dispatch, which devices bound.
RAYGRAPH_CONSTANT uint kDeformGroupSize = 64u;
RAYGRAPH_CONSTANT uint kDeformRowGroups = 32768u;

// One primitive of a mesh that is drawn deformed. Each stream starts with the primitive's first vertex.
struct DeformRecord {
    RAYGRAPH_ADDRESS positions;  // vec3; of the base shape, as normals and tangents are
    RAYGRAPH_ADDRESS normals;    // vec3
    RAYGRAPH_ADDRESS tangents;   // vec4
    RAYGRAPH_ADDRESS joints;     // 16 bits each, `perVertex` a vertex, the first in the lower half of a word
    RAYGRAPH_ADDRESS weights;    // float, of these joints
    RAYGRAPH_ADDRESS targets;    // DeformTarget[targetCount]
    RAYGRAPH_ADDRESS deformedPositions;  // where the results go
    RAYGRAPH_ADDRESS deformedNormals;
    RAYGRAPH_ADDRESS deformedTangents;
    uint vertexCount;
    uint perVertex;  // 0: no joints
    uint targetCount;
    uint firstMatrix;  // first matrix of its skin
    uint firstWeight;  // first weight of its morph targets
    uint isFlat;       // 1: three vertices a triangle, whose normal they get
};

// Holds displacements of all vertices of a primitive: vec3 each.
struct DeformTarget {
    RAYGRAPH_ADDRESS positions;
    RAYGRAPH_ADDRESS normals;
    RAYGRAPH_ADDRESS tangents;
};

// Describes a record to be deformed now, by the workgroups from firstGroup on.
struct DeformTask {
    uint record;
    uint firstGroup;
};

#undef RAYGRAPH_CONSTANT
#undef RAYGRAPH_ADDRESS

#ifdef __cplusplus
static_assert(sizeof(DeformRecord) == 24 * 4);
static_assert(sizeof(DeformTarget) == 6 * 4);
static_assert(sizeof(DeformTask) == 2 * 4);
}  // namespace raygraph::gpu
#endif

#endif

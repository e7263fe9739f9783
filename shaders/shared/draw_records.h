// Records for drawing the scene by draws and by compute: one source for C++ and GLSL, scalar layout.
//
// A draw is one group of triangles, for all of its visible placements at once: instance i of it is the
// placement, as the index of its InstanceRecord, that stands in slot firstInstance + i of the list of
// visible placements. Draws are ordered by how their triangles are drawn (DrawKind of
// gpu_scene/scene_ids.h).
#ifndef RAYGRAPH_SHARED_DRAW_RECORDS_H
#define RAYGRAPH_SHARED_DRAW_RECORDS_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::vec3;
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

// Describes a group as it would be drawn if all of its placements were visible.
struct DrawRecord {
    vec3 boundsMin;  // object space
    uint vertexCount;
    vec3 boundsMax;
    uint firstSlot;  // it has as many as the group has placements
};

// VkDrawIndirectCommand.
struct DrawCommand {
    uint vertexCount;
    uint instanceCount;
    uint firstVertex;
    uint firstInstance;
};

// --- Drawing by compute ---
//
// A chunk is kChunkTriangles triangles one after the other of one visible placement. Chunks are numbered
// through the draws, and in a draw through its visible placements; a triangle's number is that of its chunk
// and its place in it. A triangle of many pixels is drawn tile by tile.

RAYGRAPH_CONSTANT uint kChunkBits = 4u;
RAYGRAPH_CONSTANT uint kChunkTriangles = 1u << kChunkBits;
RAYGRAPH_CONSTANT uint kMaxChunks = 1u << (32u - kChunkBits);  // triangles are numbered by 32 bits
RAYGRAPH_CONSTANT uint kChunkGroupSize = 64u;                  // invocations a group, one a triangle
RAYGRAPH_CONSTANT uint kTileSize = 64u;                        // pixels a side
RAYGRAPH_CONSTANT uint kTileCapacity = 1u << 20u;              // beyond it, an invocation draws a tile

struct TriangleTile {
    uint triangle;  // number of the triangle
    uint tile;      // column, and row << 16
};

// The surfaces that are drawn: bits of the specialization constant kDrawn.
RAYGRAPH_CONSTANT uint kDrawnAlpha = 1u;  // some triangles are alpha-tested
RAYGRAPH_CONSTANT uint kDrawnGlass = 2u;  // transmissive surfaces, too

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
static_assert(sizeof(DrawRecord) == 8 * 4);
static_assert(sizeof(DrawCommand) == 4 * 4);
}  // namespace raygraph::gpu
#endif

#endif

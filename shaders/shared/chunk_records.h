// Drawing by compute: one source for C++ and GLSL.
//
// A chunk is kChunkTriangles triangles one after the other of one visible placement. Chunks are numbered
// through the draws, and in a draw through its visible placements; a triangle's number is that of its chunk
// and its place in it. A triangle of many pixels is drawn tile by tile.
#ifndef RAYGRAPH_SHARED_CHUNK_RECORDS_H
#define RAYGRAPH_SHARED_CHUNK_RECORDS_H

#ifdef __cplusplus
#include <cstdint>

namespace raygraph::gpu {
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

RAYGRAPH_CONSTANT uint kChunkBits = 4u;
RAYGRAPH_CONSTANT uint kChunkTriangles = 1u << kChunkBits;
RAYGRAPH_CONSTANT uint kMaxChunks = 1u << (32u - kChunkBits);  // triangles are numbered by 32 bits
RAYGRAPH_CONSTANT uint kChunkGroupSize = 64u;                  // invocations a group, one a triangle
RAYGRAPH_CONSTANT uint kTileSize = 64u;                        // pixels a side
RAYGRAPH_CONSTANT uint kTileCapacity = 1u << 20u;              // beyond it, an invocation draws a tile

struct TriangleTile {
    uint triangle;  // its number
    uint tile;      // column, and row << 16
};

// The surfaces that are drawn: bits of the specialization constant kDrawn.
RAYGRAPH_CONSTANT uint kDrawnAlpha = 1u;  // some triangles are alpha-tested
RAYGRAPH_CONSTANT uint kDrawnGlass = 2u;  // transmissive surfaces, too

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif
#undef RAYGRAPH_CONSTANT

#endif

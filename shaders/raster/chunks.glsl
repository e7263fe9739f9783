// Finds the triangle of an invocation's number: see shared/draw_records.h.
#ifndef RAYGRAPH_RASTER_CHUNKS_GLSL
#define RAYGRAPH_RASTER_CHUNKS_GLSL

#include "scene/bindings.glsl"
#include "shared/draw_records.h"

layout(set = 0, binding = 16, scalar) readonly buffer VisiblePlacements { uint at[]; } visiblePlacements;
layout(set = 0, binding = 17, scalar) readonly buffer Draws { DrawRecord at[]; } draws;
// The first chunk of each draw, and at last the number of all chunks
layout(set = 0, binding = 18, scalar) readonly buffer FirstChunks { uint at[]; } firstChunks;

struct DrawnTriangle {
    uint draw;
    uint placement;
    uint primitive;
};

// Returns false if the number is beyond the triangles of a placement, whose last chunk need not be full.
bool FindTriangle(uint number, uint drawCount, out DrawnTriangle triangle) {
    uint chunk = number >> kChunkBits;
    uint low = 0u, high = drawCount;  // first of low <= chunk < first of high
    while (low + 1u < high) {
        uint middle = (low + high) / 2u;
        if (firstChunks.at[middle] <= chunk)
            low = middle;
        else
            high = middle;
    }
    uint triangleCount = draws.at[low].vertexCount / 3u;
    uint chunksEach = (triangleCount + kChunkTriangles - 1u) >> kChunkBits;
    uint chunkInDraw = chunk - firstChunks.at[low];
    triangle.draw = low;
    triangle.placement = visiblePlacements.at[draws.at[low].firstSlot + chunkInDraw / chunksEach];
    triangle.primitive = ((chunkInDraw % chunksEach) << kChunkBits) + (number & (kChunkTriangles - 1u));
    return triangle.primitive < triangleCount;
}

#endif

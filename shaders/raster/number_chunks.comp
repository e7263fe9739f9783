// Numbers the chunks of all draws' visible placements: a running sum over the draws, by one group. No tile is
// listed yet.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/draw_records.h"

const uint kSize = 256u;

layout(local_size_x = 256) in;
layout(set = 0, binding = 0, scalar) readonly buffer Draws { DrawRecord at[]; } draws;
layout(set = 0, binding = 1, scalar) readonly buffer Commands { DrawCommand at[]; } commands;
layout(set = 0, binding = 2, scalar) writeonly buffer FirstChunks { uint at[]; } firstChunks;
layout(set = 0, binding = 3, scalar) writeonly buffer Tiles { uint count; TriangleTile at[]; } tiles;
layout(push_constant, scalar) uniform Constants { uint count; } constants;

shared uint sums[kSize];

uint ChunksOf(uint draw) {
    uint triangleCount = draws.at[draw].vertexCount / 3u;
    return commands.at[draw].instanceCount * ((triangleCount + kChunkTriangles - 1u) >> kChunkBits);
}

void main() {
    uint self = gl_LocalInvocationID.x;
    uint each = (constants.count + kSize - 1u) / kSize;
    uint begin = min(self * each, constants.count), end = min(begin + each, constants.count);
    uint sum = 0u;
    for (uint draw = begin; draw < end; ++draw) sum += ChunksOf(draw);
    sums[self] = sum;
    barrier();
    for (uint step = 1u; step < kSize; step *= 2u) {
        uint before = self >= step ? sums[self - step] : 0u;
        barrier();
        sums[self] += before;
        barrier();
    }
    uint first = sums[self] - sum;
    for (uint draw = begin; draw < end; ++draw) {
        firstChunks.at[draw] = first;
        first += ChunksOf(draw);
    }
    if (self == kSize - 1u) {
        firstChunks.at[constants.count] = sums[self];
        tiles.count = 0u;
    }
}

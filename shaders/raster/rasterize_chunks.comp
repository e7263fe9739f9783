// Draws small triangles, one an invocation, and lists the tiles that larger ones may cover.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/rasterize.glsl"

layout(local_size_x = 64) in;  // kChunkGroupSize
layout(set = 0, binding = 20, scalar) buffer Tiles { uint count; TriangleTile at[]; } tiles;

const int kSmallPixels = 96;  // more are faster by tiles

void DrawPixels(Drawing drawing, ivec2 low, ivec2 high) {
    for (int y = low.y; y < high.y; ++y)
        for (int x = low.x; x < high.x; ++x) DrawPixel(drawing, ivec2(x, y));
}

void main() {
    mat4 offsetToPicture = OffsetToPicture(parameters.value.camera, constants.shift, constants.size);
    uint chunkCount = firstChunks.at[constants.drawCount];
    uint stride = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    // 32 bits may overflow: chunks are counted, then triangles
    for (uint chunk = gl_GlobalInvocationID.x >> kChunkBits; chunk < chunkCount;
         chunk += stride >> kChunkBits) {
        uint number = (chunk << kChunkBits) | (gl_LocalInvocationID.x & (kChunkTriangles - 1u));
        Drawing drawing;
        if (!PrepareDrawing(number, offsetToPicture, drawing)) continue;
        ivec2 low, high;
        BoundsOf(drawing.picture, constants.size, low, high);
        if (low.x >= high.x || low.y >= high.y) continue;
        if (drawing.isCulled && IsBackFacing(drawing.picture, vec2(low + high) * 0.5f)) continue;
        if ((high.x - low.x) * (high.y - low.y) <= kSmallPixels) {
            DrawPixels(drawing, low, high);
            continue;
        }
        ivec2 firstTile = low / int(kTileSize), lastTile = (high - 1) / int(kTileSize);
        for (int y = firstTile.y; y <= lastTile.y; ++y)
            for (int x = firstTile.x; x <= lastTile.x; ++x) {
                ivec2 from = max(low, ivec2(x, y) * int(kTileSize));
                ivec2 to = min(high, ivec2(x + 1, y + 1) * int(kTileSize));
                if (!OverlapsRectangle(drawing.picture, vec2(from) + 0.5f, vec2(to) - 0.5f, drawing.isCulled))
                    continue;
                uint slot = atomicAdd(tiles.count, 1u);
                if (slot < kTileCapacity)
                    tiles.at[slot] = TriangleTile(number, uint(x) | (uint(y) << 16u));
                else
                    DrawPixels(drawing, from, to);
            }
    }
}

// Draws the listed tiles of larger triangles, one a group.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/rasterize.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 20, scalar) readonly buffer Tiles { uint count; TriangleTile at[]; } tiles;

void main() {
    mat4 offsetToPicture = OffsetToPicture(parameters.value.camera, constants.shift, constants.size);
    uint count = min(tiles.count, kTileCapacity);
    for (uint i = gl_WorkGroupID.x; i < count; i += gl_NumWorkGroups.x) {
        TriangleTile entry = tiles.at[i];
        Drawing drawing;
        if (!PrepareDrawing(entry.triangle, offsetToPicture, drawing)) continue;
        ivec2 low, high;
        BoundsOf(drawing.picture, constants.size, low, high);
        ivec2 corner = ivec2(entry.tile & 0xFFFFu, entry.tile >> 16u) * int(kTileSize);
        low = max(low, corner);
        high = min(high, corner + int(kTileSize));
        for (int y = low.y + int(gl_LocalInvocationID.y); y < high.y; y += 8)
            for (int x = low.x + int(gl_LocalInvocationID.x); x < high.x; x += 8)
                DrawPixel(drawing, ivec2(x, y));
    }
}

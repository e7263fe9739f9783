// ProbeGrid: texels of two pictures, spread evenly.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D variance;
layout(set = 0, binding = 2, std430) writeonly buffer Texels {
    vec4 values[];  // a mean and a variance each
} texels;

layout(push_constant) uniform Constants {
    uvec2 grid;
} constants;

void main() {
    uvec2 cell = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(cell, constants.grid))) return;
    // A varying position in the cell, so that the grid does not alias with a pattern of the picture:
    // Roberts' sequence
    uint index = cell.y * constants.grid.x + cell.x;
    vec2 within = fract(0.5f + float(index) * vec2(0.7548776662f, 0.5698402910f));
    uvec2 size = uvec2(imageSize(mean));
    ivec2 pixel = ivec2(min(uvec2((vec2(cell) + within) * vec2(size) / vec2(constants.grid)), size - 1u));
    texels.values[2u * index] = imageLoad(mean, pixel);
    texels.values[2u * index + 1u] = imageLoad(variance, pixel);
}

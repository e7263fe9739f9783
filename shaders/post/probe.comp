// Probe: mean and variance of some pixels of a region, spread evenly, from their sums.
#version 460
#extension GL_GOOGLE_include_directive : require
#define WITH_VARIANCE
#include "post/pixel_sums.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, std430) writeonly buffer Texels {
    vec4 values[];  // a mean and a variance each
} texels;

layout(push_constant) uniform Constants {
    uvec2 offset;  // position of the region
    uvec2 size;
    uvec2 grid;
    // samples of each pixel; pixels that a tile of the next sample has reached have one more
    uint sampleCount;
    uint doneRows, doneColumns, bandHeight;
} constants;

void main() {
    uvec2 cell = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(cell, constants.grid))) return;
    // A varying position in the cell, so that the grid does not alias with a pattern of the picture:
    // Roberts' sequence
    uint index = cell.y * constants.grid.x + cell.x;
    vec2 within = fract(0.5f + float(index) * vec2(0.7548776662f, 0.5698402910f));
    vec2 inRegion = (vec2(cell) + within) * vec2(constants.size) / vec2(constants.grid);
    uvec2 picked = constants.offset + min(uvec2(inRegion), constants.size - 1u);
    uint count = SamplesAt(picked, constants.sampleCount, constants.doneRows, constants.doneColumns,
                           constants.bandHeight);
    ivec2 pixel = ivec2(picked);
    vec4 mean = vec4(0.0f), variance = vec4(0.0f);
    if (count > 0u) {
        PixelSums sums = SumsOf(pixel);
        for (int c = 0; c < 4; ++c) mean[c] = uintBitsToFloat(MeanOfCount(SumOf(sums, c), count));
        for (int c = 0; c < 3; ++c) variance[c] = uintBitsToFloat(VarianceOf(sums, c, count));
    }
    texels.values[2u * index] = mean;
    texels.values[2u * index + 1u] = variance;
}

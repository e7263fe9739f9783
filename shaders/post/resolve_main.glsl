// ResolveSums: mean, and variance if WITH_VARIANCE is defined, of the sums of Accumulate in a region. If
// WITH_COUNTS is defined, each pixel has a number of samples of its own.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "post/pixel_sums.glsl"

layout(set = 0, binding = 0, rgba32f) uniform image2D mean;
#ifdef WITH_VARIANCE
layout(set = 0, binding = 1, rgba32f) uniform image2D variance;
#endif
#ifdef WITH_COUNTS
layout(set = 0, binding = 2, r32ui) readonly uniform uimage2D counts;  // samples of each tile of the picture
#endif

layout(push_constant) uniform Constants {
    uvec2 offset;
    uvec2 extent;
#ifndef WITH_COUNTS
    ExactDivisor divisor;  // divisor for sampleCount
    uint sampleCount;      // samples of these pixels
#endif
} constants;

void main() {
    uvec2 texel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(texel, constants.extent))) return;
    ivec2 pixel = ivec2(texel + constants.offset);
    PixelSums sums = SumsOf(pixel);
    uvec4 bits;
#ifdef WITH_COUNTS
    uint sampleCount = imageLoad(counts, ivec2(uvec2(pixel) % uvec2(imageSize(counts)))).x;
#else
    uint sampleCount = constants.sampleCount;
#endif
    for (int c = 0; c < 4; ++c) {
#ifdef WITH_COUNTS
        bits[c] = MeanOfCount(SumOf(sums, c), sampleCount);
#else
        bits[c] = MeanOfExactSum(SumOf(sums, c), constants.divisor);
#endif
    }
    imageStore(mean, pixel, uintBitsToFloat(bits));
#ifdef WITH_VARIANCE
    for (int c = 0; c < 3; ++c) bits[c] = VarianceOf(sums, c, sampleCount);
    bits.w = 0u;
    imageStore(variance, pixel, uintBitsToFloat(bits));
#endif
}

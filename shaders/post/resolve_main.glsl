// ResolveSums: mean, and variance if WITH_VARIANCE is defined, of the sums of Accumulate in a region.
layout(local_size_x = 8, local_size_y = 8) in;

#define PLANE_ACCESS readonly
#include "post/exact_planes.glsl"

layout(set = 0, binding = 0, rgba32f) uniform image2D mean;
#ifdef WITH_VARIANCE
layout(set = 0, binding = 1, rgba32f) uniform image2D variance;
#endif

layout(push_constant) uniform Constants {
    uvec2 offset;
    uvec2 extent;
    ExactDivisor divisor;  // of sampleCount
    uint sampleCount;      // of these pixels
} constants;

void main() {
    uvec2 texel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(texel, constants.extent))) return;
    ivec2 pixel = ivec2(texel + constants.offset);
    uvec4 sums[4] = uvec4[4](imageLoad(sum0, pixel), imageLoad(sum1, pixel), imageLoad(sum2, pixel),
                             imageLoad(sum3, pixel));
    uvec4 bits;
    ExactSum sum;
    for (int c = 0; c < 4; ++c) {
        for (int k = 0; k < 4; ++k) sum.words[k] = sums[k][c];
        bits[c] = MeanOfExactSum(sum, constants.divisor);
    }
    imageStore(mean, pixel, uintBitsToFloat(bits));
#ifdef WITH_VARIANCE
    uvec4 squares[4] = uvec4[4](imageLoad(squares0, pixel), imageLoad(squares1, pixel),
                                imageLoad(squares2, pixel), imageLoad(squares3, pixel));
    ExactSquares square;
    for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < 4; ++k) {
            sum.words[k] = sums[k][c];
            square.words[k] = squares[k][c];
        }
        square.words[4] = squares[c].w;
        bits[c] = VarianceOfExactSums(sum, square, constants.sampleCount);
    }
    bits.w = 0u;
    imageStore(variance, pixel, uintBitsToFloat(bits));
#endif
}

// NoteSamples: the variance of one sample and the mean, R, G and B together, of the listed pixels that have a
// given number of samples.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#define WITH_VARIANCE
#define PLANE_ACCESS readonly
#include "post/exact_planes.glsl"
#include "post/mean_of_count.glsl"
#include "scene/pixel_list.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, r32f) uniform image2D variance;
layout(set = 0, binding = 1, r32f) uniform image2D mean;

layout(push_constant) uniform Constants {
    uvec2 list;  // address
    uint listCount;
    uint sampleIndex;  // the next one of pixels that have as many samples
    uint sampleCount;
} constants;

void main() {
    // A dispatch over a row has rows of groups where there are too many for one
    uint width = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    for (uint entry = gl_GlobalInvocationID.x; entry < constants.listCount; entry += width) {
        ListedPixel listed = PixelListStream(constants.list).at[entry];
        if (listed.sampleIndex != constants.sampleIndex) continue;
        ivec2 pixel = ivec2(PixelOf(listed));
        uvec4 sums[4] = uvec4[4](imageLoad(sum0, pixel), imageLoad(sum1, pixel), imageLoad(sum2, pixel),
                                 imageLoad(sum3, pixel));
        uvec4 squares[4] = uvec4[4](imageLoad(squares0, pixel), imageLoad(squares1, pixel),
                                    imageLoad(squares2, pixel), imageLoad(squares3, pixel));
        vec3 variances, means;
        ExactSum sum;
        ExactSquares square;
        for (int c = 0; c < 3; ++c) {
            for (int k = 0; k < 4; ++k) {
                sum.words[k] = sums[k][c];
                square.words[k] = squares[k][c];
            }
            square.words[4] = squares[c].w;
            means[c] = uintBitsToFloat(MeanOfCount(sum, constants.sampleCount));
            variances[c] = uintBitsToFloat(VarianceOfExactSums(sum, square, constants.sampleCount));
        }
        imageStore(variance, pixel, vec4(variances.x + variances.y + variances.z));
        imageStore(mean, pixel, vec4(means.x + means.y + means.z));
    }
}

// RecordVariance: the variance of one sample and the mean, R, G and B together, of the listed pixels that
// have a given number of samples.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#define WITH_VARIANCE
#include "post/pixel_sums.glsl"
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
        PixelSums sums = SumsOf(pixel);
        vec3 variances, means;
        for (int c = 0; c < 3; ++c) {
            means[c] = uintBitsToFloat(MeanOfCount(SumOf(sums, c), constants.sampleCount));
            variances[c] = uintBitsToFloat(VarianceOf(sums, c, constants.sampleCount));
        }
        imageStore(variance, pixel, vec4(variances.x + variances.y + variances.z));
        imageStore(mean, pixel, vec4(means.x + means.y + means.z));
    }
}

// RelativeSquaredError: the error of a picture against the mean of samples, and the part of it that is their
// noise.
#version 460
#extension GL_GOOGLE_include_directive : require
#define WITH_VARIANCE
#include "post/pixel_sums.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D test;
layout(set = 0, binding = 1, r32f) writeonly uniform image2D error;
layout(set = 0, binding = 2, r32f) writeonly uniform image2D noise;

layout(push_constant) uniform Constants {
    uint sampleCount;
    uint doneRows, doneColumns, bandHeight;
} constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(error)))) return;
    uint samples = SamplesAt(uvec2(pixel), constants.sampleCount, constants.doneRows, constants.doneColumns,
                             constants.bandHeight);
    PixelSums sums = SumsOf(pixel);
    vec3 reference, variance = vec3(0.0f);
    for (int c = 0; c < 3; ++c) {
        reference[c] = uintBitsToFloat(MeanOfCount(SumOf(sums, c), samples));
        if (samples > 1u) variance[c] = uintBitsToFloat(VarianceOf(sums, c, samples)) / float(samples);
    }
    vec3 difference = imageLoad(test, pixel).xyz - reference;
    vec3 scale = 1.0f / (3.0f * (reference * reference + 0.01f));
    imageStore(error, pixel, vec4(dot(difference * difference, scale)));
    imageStore(noise, pixel, vec4(dot(variance, scale)));
}

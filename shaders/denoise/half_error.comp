// Writes two estimates of the squared error of the mean, each a number a pixel: by the difference of the
// means of both halves of the samples, and by the variance of a sample. Their local ratio is how much better
// than independent samples the sampler is. Both are 0 where the variance is mostly that of lights.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D variance;  // denoise/variance.comp
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D firstHalf;
layout(set = 0, binding = 3, rg32f) writeonly uniform image2D errors;

layout(push_constant) uniform Constants {
    float perSample;  // 1 / count of samples
    float byHalf;     // factor of the squared difference between the mean and that of the first half
} constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    ivec2 begin = WindowBegin(pixel, 3), end = WindowEnd(pixel, 3, size);
    vec3 smoothed = vec3(0.0f);
    for (int y = begin.y; y <= end.y; ++y)
        for (int x = begin.x; x <= end.x; ++x) smoothed += FiniteOr0(imageLoad(mean, ivec2(x, y)).xyz);
    smoothed /= float((end.x - begin.x + 1) * (end.y - begin.y + 1));
    vec3 weight = ErrorWeight(smoothed);
    vec3 difference =
        FiniteOr0(imageLoad(firstHalf, pixel).xyz) - FiniteOr0(imageLoad(mean, pixel).xyz);
    vec4 sampled = imageLoad(variance, pixel);
    imageStore(errors, pixel,
               sampled.w * vec4(constants.byHalf * Sum(difference * difference * weight),
                                constants.perSample * Sum(sampled.xyz * weight), 0.0f, 0.0f));
}

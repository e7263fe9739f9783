// Writes the squared error of each candidate, by Stein's unbiased risk estimate (Stein 1981):
// |f - y|^2 - s^2 + 2 s^2 df/dy, for the estimate f, the mean y and the variance s^2 of the mean. df/dy is
// taken as twice the pixel's own weight, because the weights depend on y, too.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D noise;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D detailed;
layout(set = 0, binding = 3, rgba32f) readonly uniform image2D medium;
layout(set = 0, binding = 4, rgba32f) readonly uniform image2D smoothed;
layout(set = 0, binding = 5, rgba32f) writeonly uniform image2D errors;

const float kPerOwnWeight = 2.0f;  // df/dy

float ErrorOf(vec4 candidate, vec3 value, vec3 variance, vec3 weight) {
    vec3 difference = candidate.xyz - value;
    float slope = min(kPerOwnWeight * candidate.w, 1.0f);
    return Sum((difference * difference - variance * (1.0f - 2.0f * slope)) * weight);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    vec3 value = FiniteOr0(imageLoad(mean, pixel).xyz), variance = imageLoad(noise, pixel).xyz;
    vec4 middle = imageLoad(medium, pixel);
    vec3 weight = ErrorWeight(middle.xyz);
    imageStore(errors, pixel,
               vec4(ErrorOf(imageLoad(detailed, pixel), value, variance, weight),
                    ErrorOf(middle, value, variance, weight),
                    ErrorOf(imageLoad(smoothed, pixel), value, variance, weight), 0.0f));
}

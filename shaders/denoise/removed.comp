// Writes two numbers a pixel for the blend of an estimate with the mean: the noise that the estimate has
// removed, as far as its share of the pixel's own value says, and its squared difference to the mean.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/denoise.glsl"

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D mean;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D noise;
layout(set = 0, binding = 2, rgba32f) readonly uniform image2D estimate;  // w: share of the pixel's own value
layout(set = 0, binding = 3, rg32f) writeonly uniform image2D removed;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(mean);
    if (!IsInside(pixel, size)) return;
    vec4 value = imageLoad(estimate, pixel);
    vec3 weight = ErrorWeight(value.xyz);
    vec3 difference = FiniteOr0(imageLoad(mean, pixel).xyz) - value.xyz;
    imageStore(removed, pixel,
               vec4((1.0f - value.w) * Sum(imageLoad(noise, pixel).xyz * weight),
                    Sum(difference * difference * weight), 0.0f, 0.0f));
}
